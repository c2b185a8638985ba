// How numbers, units, times and names read.

const LOCALE = "en-GB";
const DASH = "–";
/** Units that take prefixes; all others stay as they are. */
const PREFIXED = new Set(["Pa", "W", "J/kg", "J", "Hz", "V", "A", "N"]);

/** How the service's clock differs from this computer's, in milliseconds. */
let clock_offset_ms = 0;

/** Takes the service's time, as it was about now. */
export function setClock(now_ms) {
  clock_offset_ms = now_ms - Date.now();
}

/** The service's time. */
export const now = () => Date.now() + clock_offset_ms;

/** How far this computer's clock is off, in milliseconds. */
export const clockOffset = () => clock_offset_ms;

const known = (value) => typeof value === "number" && Number.isFinite(value);

/** A number with so many significant digits. */
export function number(value, digits = 4) {
  if (!known(value)) return DASH;
  const size = Math.abs(value);
  if (size !== 0 && (size >= 1e6 || size < 1e-4)) return value.toExponential(digits - 2);
  const decimals = size === 0 ? digits - 1 : digits - 1 - Math.floor(Math.log10(size));
  const text = value.toFixed(Math.min(Math.max(decimals, 0), 8));
  return text.replace("-", "−");
}

/** A whole number with its thousands apart. */
export const count = (value) =>
  known(value) ? value.toLocaleString(LOCALE).replaceAll(",", "\u202f") : DASH;

/** How values of a unit that go up to `largest` are shown: divided by `factor`, in `unit`. */
export function scaleFor(unit, largest) {
  if (PREFIXED.has(unit)) {
    for (const [factor, prefix] of [[1e9, "G"], [1e6, "M"], [1e3, "k"]]) {
      if (Math.abs(largest) >= factor) return { factor, unit: prefix + unit };
    }
  }
  return { factor: 1, unit: unit ?? "" };
}

/** A number with its unit, prefixed where that reads better. */
export function quantity(value, unit, digits = 3) {
  if (!known(value)) return DASH;
  const scale = scaleFor(unit, value);
  return `${number(value / scale.factor, digits)}\u00a0${scale.unit}`.trim();
}

/** An interval with its unit. */
export function interval(ends, unit, digits = 3) {
  if (!ends || !known(ends[0]) || !known(ends[1])) return null;
  const scale = scaleFor(unit, Math.max(Math.abs(ends[0]), Math.abs(ends[1])));
  const [low, high] = ends.map((end) => number(end / scale.factor, digits));
  return `${low} to ${high}\u00a0${scale.unit}`.trim();
}

/** A probability in percent that is never rounded to certainty. */
export function percent(probability) {
  if (!known(probability)) return DASH;
  if (probability > 0.999 && probability < 1) return "> 99.9 %";
  if (probability > 0 && probability < 0.001) return "< 0.1 %";
  return `${(100 * probability).toFixed(probability < 0.1 || probability > 0.99 ? 1 : 0)} %`;
}

const TIME = { hour: "2-digit", minute: "2-digit", second: "2-digit", hourCycle: "h23" };
const timeFormat = new Intl.DateTimeFormat(LOCALE, TIME);
const minuteFormat = new Intl.DateTimeFormat(LOCALE, { ...TIME, second: undefined });
const dayFormat = new Intl.DateTimeFormat(LOCALE, { day: "numeric", month: "short" });
const fullFormat = new Intl.DateTimeFormat(LOCALE, {
  ...TIME, day: "numeric", month: "short", year: "numeric", timeZoneName: "short",
});
const zoneFormat = new Intl.DateTimeFormat(LOCALE, { timeZoneName: "short" });

const valid = (ms) => known(ms) && Math.abs(ms) < 8.64e15;

/** A time of day in this computer's zone; with the day where that is not today's. */
export function clock(ms) {
  if (!valid(ms)) return DASH;
  const time = timeFormat.format(ms);
  const day = dayFormat.format(ms);
  return day === dayFormat.format(now()) ? time : `${day} ${time}`;
}

/** A time of day for an axis; seconds only where they are told apart. */
export const axisTime = (ms, step_ms) => (step_ms < 60_000 ? timeFormat : minuteFormat).format(ms);

/** Day, time and zone. */
export const fullTime = (ms) => (valid(ms) ? fullFormat.format(ms) : DASH);

/** The short name of this computer's time zone at a time. */
export function zone(ms = now()) {
  const parts = zoneFormat.formatToParts(valid(ms) ? ms : 0);
  return parts.find((part) => part.type === "timeZoneName")?.value ?? "local time";
}

/** A duration in whole seconds or the two units that matter. */
export function duration(ms) {
  if (!known(ms)) return DASH;
  const seconds = Math.max(0, ms / 1000);
  if (seconds < 1) return "< 1 s";
  if (seconds < 60) return `${Math.floor(seconds)} s`;
  const pair = (large, small, unit, below) => {
    const rest = Math.floor((seconds % large) / small);
    return `${Math.floor(seconds / large)} ${unit}${rest ? ` ${rest} ${below}` : ""}`;
  };
  if (seconds < 3600) return pair(60, 1, "min", "s");
  if (seconds < 86_400) return pair(3600, 60, "h", "min");
  return pair(86_400, 3600, "d", "h");
}

/** A duration in the one unit that matters. */
export function roughDuration(ms) {
  const text = duration(ms);
  return /^\d/.test(text) ? text.split(" ").slice(0, 2).join(" ") : text;
}

/** How long ago a time was, or in how long it will be. */
export function age(ms) {
  if (!valid(ms)) return DASH;
  const past_ms = now() - ms;
  if (past_ms < -1000) return `in ${duration(-past_ms)}`;
  return past_ms < 1000 ? "now" : `${duration(past_ms)} ago`;
}

/** `compressor_fouling` as `Compressor fouling`; a name that is no such word stays as it is. */
export function plainName(name) {
  if (!/^[a-z0-9_ ]+$/.test(name)) return name;
  const words = name.replaceAll("_", " ");
  return words.charAt(0).toUpperCase() + words.slice(1);
}

/** What an alarm found, as a headline. */
export function headline(alarm) {
  if (alarm.fault) return plainName(alarm.fault);
  return {
    undecided: "Fault not yet identified",
    none_of_these: "None of the known faults",
    both: "Two faults at once",
    named: "Named without a name",
  }[alarm.finding] ?? plainName(String(alarm.finding));
}

/** The band of a severity from 1 to 1000, after OPC. */
export const priority = (severity) =>
  severity >= 667 ? "high" : severity >= 334 ? "medium" : "low";
