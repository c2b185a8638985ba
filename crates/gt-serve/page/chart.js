// A small chart on a canvas: a band from the least to the most of each bucket, limits, marks.

const FONT = "11px system-ui, -apple-system, 'Segoe UI', Roboto, sans-serif";
const MARGIN = { left: 50, right: 8, top: 8, bottom: 18 };
/** Steps of an axis of time. */
const TIME_STEPS_MS = [
  1, 2, 5, 10, 15, 30, 60, 120, 300, 600, 900, 1800, 3600, 7200, 14_400, 21_600, 43_200, 86_400,
].map((seconds) => 1000 * seconds);

/** The colours that the style sheet gives the charts. */
export function chartColours() {
  const style = getComputedStyle(document.documentElement);
  const names = ["ink", "soft", "grid", "line", "band", "limit", "alarm", "mark", "plot"];
  return Object.fromEntries(
    names.map((name) => [name, style.getPropertyValue(`--chart-${name}`).trim()]),
  );
}

/** Round values between two numbers, about as many as wanted. */
export function ticks(low, high, wanted) {
  const span = high - low;
  if (!(span > 0) || !Number.isFinite(span)) return [];
  const rough = span / wanted;
  const power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 2.5, 5, 10].map((part) => part * power).find((own) => own >= rough);
  const first = Math.ceil(low / step - 1e-9);
  const last = Math.floor(high / step + 1e-9);
  return Array.from({ length: Math.max(0, last - first + 1) }, (_, place) => (first + place) * step);
}

/** Round values of a logarithmic axis: 1, 2 and 5 of each decade, or as many decades as wanted. */
export function decades(low, high, wanted) {
  const fine = [];
  for (let power = Math.floor(Math.log10(low)); power <= Math.log10(high); power++) {
    for (const part of [1, 2, 5]) fine.push(Number(`${part}e${power}`));
  }
  const within = fine.filter((value) => value >= low && value <= high);
  if (within.length <= wanted) return within;
  const first = Math.ceil(Math.log10(low) - 1e-9);
  const last = Math.floor(Math.log10(high) + 1e-9);
  const stride = Math.max(1, Math.ceil((last - first + 1) / wanted));
  const found = [];
  for (let power = first; power <= last; power += stride) found.push(Number(`1e${power}`));
  return found;
}

function timeTicks(from, to, width) {
  // Seconds make longer labels.
  const room = (step) => (width * step) / (to - from) >= (step < 60_000 ? 62 : 42);
  const step = TIME_STEPS_MS.find(room) ?? 86_400_000;
  // Whole steps of local time: no step is longer than a day.
  const shift = new Date(to).getTimezoneOffset() * 60_000;
  const found = [];
  for (let at = Math.ceil((from - shift) / step) * step + shift; at <= to; at += step) found.push(at);
  return { step, found };
}

/** The least and the most that a chart has to show, with the limits. */
function range(plot) {
  let [low, high] = [Infinity, -Infinity];
  for (let at = plot.first; at < plot.last; at++) {
    if (plot.min[at] < low) low = plot.min[at];
    if (plot.max[at] > high) high = plot.max[at];
  }
  if (low > high) [low, high] = [0, plot.limits.length ? 0 : 1];
  for (const limit of plot.limits) [low, high] = [Math.min(low, limit), Math.max(high, limit)];
  if (plot.from_zero && !plot.log) low = Math.min(low, 0);
  if (plot.log) {
    high = Math.max(high, 1e-12);
    return [Math.max(low, high * 1e-6) / 1.5, high * 1.5];
  }
  const span = Math.max(high - low, 1e-9 * Math.max(Math.abs(low), Math.abs(high)), 1e-12);
  return [plot.from_zero && low === 0 ? 0 : low - 0.06 * span, high + 0.1 * span];
}

/**
 * Draws a plot and says where its times lie: {left, right}, in pixels.
 *
 * plot: times, min, max, first, last (places that are in view, half open), from, to, bucket_ms,
 * limits, from_zero, log, scale {factor, unit}, marks [{kind, at, interval, active}], cursor (a place
 * or null), label (of a number on the axis).
 */
export function draw(canvas, plot, colours) {
  const width = canvas.clientWidth;
  const height = canvas.clientHeight;
  const ratio = window.devicePixelRatio || 1;
  if (width === 0 || height === 0) return null;
  const [own, high_px] = [Math.round(width * ratio), Math.round(height * ratio)];
  if (canvas.width !== own) canvas.width = own;
  if (canvas.height !== high_px) canvas.height = high_px;
  const context = canvas.getContext("2d");
  context.setTransform(ratio, 0, 0, ratio, 0, 0);
  context.clearRect(0, 0, width, height);
  context.font = FONT;
  context.lineJoin = "round";

  const box = {
    left: MARGIN.left, right: width - MARGIN.right, top: MARGIN.top, bottom: height - MARGIN.bottom,
  };
  const [low, high] = range(plot);
  const bent = plot.log ? (value) => Math.log10(Math.max(value, low)) : (value) => value;
  const x = (time) =>
    box.left + ((time - plot.from) / (plot.to - plot.from)) * (box.right - box.left);
  const y = (value) =>
    box.bottom - ((bent(value) - bent(low)) / (bent(high) - bent(low))) * (box.bottom - box.top);
  const pen = { context, box, x, y, colours, plot };

  axes(pen, low, high);
  context.save();
  context.beginPath();
  context.rect(box.left, box.top - MARGIN.top, box.right - box.left, box.bottom - box.top + MARGIN.top);
  context.clip();
  for (const mark of plot.marks) shade(pen, mark);
  for (const limit of plot.limits) limitLine(pen, limit);
  if (plot.first < plot.last && !curve(pen)) nothing(pen);
  for (const mark of plot.marks) markLine(pen, mark);
  cursorLine(pen);
  context.restore();
  return { left: box.left, right: box.right };
}

function axes({ context, box, x, y, colours, plot }, low, high) {
  context.fillStyle = colours.plot;
  context.fillRect(box.left, box.top, box.right - box.left, box.bottom - box.top);
  context.strokeStyle = colours.grid;
  context.fillStyle = colours.soft;
  context.lineWidth = 1;
  context.textAlign = "right";
  context.textBaseline = "middle";
  const { factor } = plot.scale;
  const values = plot.log
    ? decades(low / factor, high / factor, 5).map((value) => value * factor)
    : ticks(low / factor, high / factor, 4).map((value) => value * factor);
  for (const value of values) {
    const at = Math.round(y(value)) + 0.5;
    line(context, box.left, at, box.right, at);
    context.fillText(plot.label(value / factor, values.map((own) => own / factor)), box.left - 5, at);
  }
  context.textAlign = "center";
  context.textBaseline = "top";
  const { step, found } = timeTicks(plot.from, plot.to, box.right - box.left);
  for (const time of found) {
    const at = Math.round(x(time)) + 0.5;
    line(context, at, box.bottom, at, box.bottom + 3);
    const text = plot.timeLabel(time, step);
    const half = context.measureText(text).width / 2;
    if (at - half < box.left - 20 || at + half > box.right + MARGIN.right) continue;
    context.fillText(text, at, box.bottom + 5);
  }
}

function line(context, x0, y0, x1, y1) {
  context.beginPath();
  context.moveTo(x0, y0);
  context.lineTo(x1, y1);
  context.stroke();
}

function shade({ context, box, x, colours }, mark) {
  if (mark.kind !== "onset" || !mark.interval) return;
  const [from, to] = mark.interval.map(x);
  context.globalAlpha = 0.2;
  context.fillStyle = colours.mark;
  context.fillRect(from, box.top, Math.max(1, to - from), box.bottom - box.top);
  context.globalAlpha = 1;
}

function limitLine({ context, box, y, colours }, limit) {
  context.strokeStyle = colours.limit;
  context.lineWidth = 1.2;
  context.setLineDash([5, 4]);
  const at = Math.round(y(limit)) + 0.5;
  line(context, box.left, at, box.right, at);
  context.setLineDash([]);
}

/** Pieces without a gap: where several buckets are empty nothing is drawn, and nothing invented. */
function pieces({ first, last, times, min, gap_ms }) {
  const found = [];
  let piece = null;
  let before = null;
  for (let at = first; at < last; at++) {
    if (!Number.isFinite(min[at])) continue;
    if (piece === null || times[at] - before > gap_ms) found.push((piece = []));
    piece.push(at);
    before = times[at];
  }
  return found;
}

function curve({ context, x, y, colours, plot }) {
  const middle = plot.bucket_ms / 2;
  context.lineWidth = 1.3;
  const all = pieces(plot);
  for (const piece of all) {
    const across = piece.map((at) => x(plot.times[at] + middle));
    context.fillStyle = colours.band;
    context.strokeStyle = colours.line;
    context.beginPath();
    piece.forEach((at, place) => context.lineTo(across[place], y(plot.max[at])));
    for (let place = piece.length - 1; place >= 0; place--) {
      context.lineTo(across[place], y(plot.min[piece[place]]));
    }
    context.closePath();
    context.fill();
    context.beginPath();
    piece.forEach((at, place) => {
      context.lineTo(across[place], y((plot.min[at] + plot.max[at]) / 2));
    });
    context.stroke();
    if (piece.length === 1) {
      context.fillStyle = colours.line;
      context.fillRect(across[0] - 1, y(plot.max[piece[0]]) - 1, 2, 2);
    }
  }
  return all.length > 0;
}

function nothing({ context, box, colours }) {
  context.fillStyle = colours.soft;
  context.textAlign = "center";
  context.textBaseline = "middle";
  context.fillText("no value in this time", (box.left + box.right) / 2, (box.top + box.bottom) / 2);
}

function markLine({ context, box, x, colours }, mark) {
  const at = Math.round(x(mark.at)) + 0.5;
  context.strokeStyle = colours.mark;
  context.lineWidth = 1.2;
  context.setLineDash(mark.kind === "onset" ? [2, 2] : []);
  line(context, at, box.top, at, box.bottom);
  context.setLineDash([]);
  if (mark.kind !== "alarm") return;
  context.fillStyle = mark.active ? colours.alarm : colours.mark;
  context.beginPath();
  context.moveTo(at - 4.5, box.top - 6);
  context.lineTo(at + 4.5, box.top - 6);
  context.lineTo(at, box.top + 1);
  context.fill();
}

function cursorLine({ context, box, x, y, colours, plot }) {
  const at = plot.cursor;
  if (at === null || !(at >= plot.first && at < plot.last)) return;
  const across = Math.round(x(plot.times[at] + plot.bucket_ms / 2)) + 0.5;
  context.strokeStyle = colours.ink;
  context.lineWidth = 1;
  line(context, across, box.top, across, box.bottom);
  if (!Number.isFinite(plot.min[at])) return;
  context.fillStyle = colours.ink;
  for (const value of new Set([plot.min[at], plot.max[at]])) {
    context.beginPath();
    context.arc(across, y(value), 2.5, 0, 7);
    context.fill();
  }
}
