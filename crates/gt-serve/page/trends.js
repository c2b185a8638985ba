// The charts of the machine that is shown: reading, following, cursor and zoom.

import { get, path } from "./api.js";
import { chartColours } from "./chart.js";
import { byId, choice, el, note, throttled, write } from "./dom.js";
import { age, clock, duration, zone } from "./format.js";
import { on, state } from "./state.js";
import { Trend } from "./trend.js";
import { Card } from "./trend_card.js";
import { followPointer, followKeys } from "./trend_input.js";

const GROUPS = [
  ["statistic", "Statistics", true],
  ["residual", "Residuals", true],
  ["output", "Outputs", true],
  ["input", "Inputs", false],
];
const SPANS = [["120", "2 min"], ["600", "10 min"], ["3600", "1 h"], ["28800", "8 h"]];
const POINTS = 600;
const MEANWHILE = 1000;
/** Pause before another try to read a trend. */
const RETRY_MS = 10_000;
const CLOSED = "gtfdi.closed";

let span_s = 600;
let cards = [];
let reading = 0;
let past_alarms = [];
/** Samples that come while a trend is on its way; null where none is. */
let meanwhile = null;
const seen = new IntersectionObserver((entries) => {
  for (const entry of entries) {
    const { card } = entry.target;
    card.visible = entry.isIntersecting;
    if (card.visible && view.trend) card.draw();
  }
}, { rootMargin: "100px" });

/** What all charts share. `zoom` is a pair of times, or null while they follow the samples. */
const view = {
  trend: null, from: 0, to: 1, cursor_ms: null, zoom: null, marks: [], log: false,
  /** The place under the cursor, looked up anew: places move when old buckets go. */
  get cursor() {
    return this.cursor_ms === null || this.trend === null ? null : this.trend.place(this.cursor_ms);
  },
  colours: chartColours(),
};

/** The cards that can be reached, in the order of the page. */
const shownCards = () => cards.filter((card) => !card.element.hidden && card.element.closest("details").open);

const spans = choice(byId("spans"), SPANS, (key) => {
  span_s = Number(key);
  view.zoom = null;
  setCursor(null);
  readTrend();
});
spans.press("600");

/** Reads the trend of the machine that is shown. */
export async function readTrend() {
  const machine = state.selected;
  if (machine === null) return;
  spans.press(String(span_s));
  const own = ++reading;
  meanwhile = [];
  const wanted_s = span_s;
  try {
    const answer = await get(path(["machines", machine, "trend"], { seconds: wanted_s, points: POINTS }));
    if (own !== reading) return;
    view.trend = new Trend(answer, 1000 * wanted_s);
    for (const sample of meanwhile) view.trend.add(sample, false);
    meanwhile = null;
    note("trend-notes", "trend", answer.times_ms.length ? null : "No samples in this time.");
    build();
    readPastAlarms(machine, own);
  } catch (error) {
    if (own !== reading) return;
    setTimeout(() => own === reading && state.live && readTrend(), RETRY_MS);
    note("trend-notes", "trend", `The trends of ${machine} could not be read: ${error.message}.`, {
      label: "Try again",
      run: readTrend,
    });
  }
}

/** Ended alarms leave their marks too. */
async function readPastAlarms(machine, own) {
  try {
    const since_ms = view.trend.last_ms === null ? "" : Math.round(view.trend.last_ms - view.trend.span_ms);
    const answer = await get(path(["alarms"], { open: false, machine, since_ms, limit: 50 }));
    if (own === reading) past_alarms = answer.alarms;
  } catch {
    past_alarms = []; // The marks of ended alarms are missed by nobody who cannot reach the service.
  }
  redraw();
}

/** Takes a sample of the event stream. */
export function takeSample(sample) {
  if (sample.machine !== state.selected) return;
  if (meanwhile !== null && meanwhile.length < MEANWHILE) meanwhile.push(sample);
  if (view.trend === null || sample.machine !== view.trend.machine) return;
  if (view.trend.add(sample, view.zoom !== null)) redraw();
  else readSoon();
}

/** Reads again when somebody noticed that the trend is no longer whole. */
export const readSoon = throttled(readTrend, 5000);

const shape = (trend) => JSON.stringify([trend.machine, trend.series.map(({ kind, tag, unit }) => [kind, tag, unit])]);

function build() {
  const place = byId("charts");
  if (place.shape === shape(view.trend)) {
    cards.forEach((card) => (card.series = view.trend.series[card.row]));
  } else {
    place.shape = shape(view.trend);
    seen.disconnect();
    cards = [];
    place.replaceChildren(...GROUPS.map(buildGroup).filter(Boolean));
    if (cards.length > 0) cards[0].plot.tabIndex = 0;
    filter();
  }
  write(byId("key-band"), `least to most in ${bucketText(view.trend.bucket_ms)}`);
  setCursor(view.cursor_ms);
  redraw();
}

const bucketText = (ms) => (ms < 1000 ? `${Math.round(ms)} ms` : duration(ms));
const closed = () => new Set((localStorage.getItem(CLOSED) ?? "").split(" "));

function buildGroup([kind, title, open]) {
  const own = view.trend.series.map((series, row) => [series, row]).filter(([series]) => series.kind === kind);
  if (own.length === 0) return null;
  const made = own.map(([series, row]) => new Card(series, row, view));
  cards.push(...made);
  for (const card of made) {
    card.element.card = card;
    seen.observe(card.element);
  }
  const group = el(
    "details",
    { class: "group", open: isOpen(kind, open) },
    el("summary", {}, el("h4", {}, `${title} (${own.length})`)),
    el("div", { class: "cards" }, ...made.map((card) => card.element)),
  );
  group.addEventListener("toggle", () => {
    redraw();
    if (wantedTag() !== "") return; // The search opened it.
    const kept = closed();
    kept.delete(kind);
    kept.delete(`${kind}-open`);
    kept.add(group.open ? `${kind}-open` : kind);
    localStorage.setItem(CLOSED, [...kept].join(" ").trim());
  });
  return group;
}

/** Whether a group is open: as it was left, else as is usual. */
function isOpen(kind, usual) {
  const remembered = closed();
  if (remembered.has(`${kind}-open`)) return true;
  // On a narrow screen all of them would be a long way.
  const wanted = kind === "statistic" || (usual && !matchMedia("(max-width: 760px)").matches);
  return wanted && !remembered.has(kind);
}

const wantedTag = () => byId("find-tag").value.trim().toLowerCase();

function filter() {
  const wanted = wantedTag();
  for (const card of cards) {
    card.element.hidden = !`${card.series.tag} ${card.name}`.toLowerCase().includes(wanted);
  }
  for (const [kind, , usual] of GROUPS) {
    const own = cards.filter((card) => card.series.kind === kind);
    const group = own[0]?.element.closest("details");
    if (group) group.open = wanted === "" ? isOpen(kind, usual) : own.some((card) => !card.element.hidden);
  }
}

/** Draws all again, soon. */
export const redraw = throttled(() => {
  const { trend } = view;
  if (trend === null || byId("machine").hidden) return;
  const last = (trend.last_ms ?? 0) + trend.bucket_ms;
  [view.from, view.to] = view.zoom ?? [last - trend.span_ms, last];
  view.marks = marks();
  if (view.cursor !== null && trend.times[view.cursor] < view.from - 2 * trend.bucket_ms) setCursor(null);
  const measured = measuredValues();
  for (const card of cards) {
    if (!card.visible && card.scale) continue;
    card.showHead(measured.get(`${card.series.kind} ${card.series.tag}`));
    card.draw();
  }
  showZoom();
}, 250);

function measuredValues() {
  const machine = state.machines.get(view.trend.machine);
  const found = new Map();
  for (const own of machine?.inputs ?? []) found.set(`input ${own.tag}`, own);
  for (const own of machine?.outputs ?? []) found.set(`output ${own.tag}`, own);
  for (const own of machine?.statistics ?? []) found.set(`statistic ${own.name}`, own);
  return found;
}

function marks() {
  const found = [];
  const known = new Map(past_alarms.map((alarm) => [alarm.id, alarm]));
  for (const alarm of state.alarms.values()) known.set(alarm.id, alarm);
  for (const alarm of known.values()) {
    if (alarm.machine !== view.trend.machine) continue;
    const active = alarm.state.startsWith("active");
    if (alarm.onset_ms !== null) {
      found.push({ kind: "onset", at: alarm.onset_ms, interval: alarm.onset_interval_ms, active });
    }
    found.push({ kind: "alarm", at: alarm.raised_ms, active });
  }
  return found;
}

/** Puts the cursor of all charts at a time; null takes it away. */
function setCursor(time_ms) {
  view.cursor_ms = time_ms;
  const { cursor } = view;
  const at = cursor === null ? null : view.trend.times[cursor];
  write(byId("cursor"), at === null ? "" : `at ${clock(at)} ${zone(at)}, ${age(at)}`);
  redraw();
}

/** Shows a part of the trend; null follows the samples again. */
function setZoom(times) {
  const { trend } = view;
  if (trend === null) return;
  if (times !== null) {
    const last = (trend.last_ms ?? 0) + trend.bucket_ms;
    const least = 5 * trend.bucket_ms;
    let [from, to] = [Math.max(Math.min(...times), trend.times[0] ?? 0), Math.min(Math.max(...times), last)];
    if (to - from < least) [from, to] = [(from + to - least) / 2, (from + to + least) / 2];
    if (to - from >= 0.98 * trend.span_ms) times = null;
    else times = [from, to];
  }
  view.zoom = times;
  redraw();
  showZoom();
}

function showZoom() {
  byId("held").hidden = view.zoom === null;
  if (view.zoom === null) return;
  write(byId("held-text"), `Held: ${clock(view.zoom[0])} to ${clock(view.zoom[1])} ${zone(view.zoom[1])}`);
}

byId("live").addEventListener("click", () => {
  setZoom(null);
  spansFocus();
});
const spansFocus = () => byId("spans").querySelector("[aria-pressed=true]").focus();
byId("find-tag").addEventListener("input", () => {
  filter();
  redraw();
});
byId("log-scale").addEventListener("change", (event) => {
  view.log = event.target.checked;
  redraw();
});
for (const query of ["(prefers-color-scheme: dark)", "(forced-colors: active)"]) {
  matchMedia(query).addEventListener("change", () => {
    view.colours = chartColours();
    redraw();
  });
}
addEventListener("resize", redraw);
on("selected", () => {
  [view.trend, view.zoom, view.cursor_ms, past_alarms] = [null, null, null, []];
  byId("charts").replaceChildren();
  byId("charts").shape = null;
  setCursor(null);
  readTrend();
});
on("alarms", () => redraw());
const charts = { view, setCursor, setZoom, shownCards };
followPointer(byId("charts"), charts);
followKeys(byId("charts"), charts);
