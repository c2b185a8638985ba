// One chart with its tag, value, quality and limit.

import { draw } from "./chart.js";
import { el, icon, write } from "./dom.js";
import { axisTime, fullTime, number, plainName, scaleFor } from "./format.js";

/** Qualities that say nothing is wrong. */
const GOOD = new Set(["good", null, undefined]);

/** A number of an axis, with as many decimals as tell its neighbours apart. */
function axisLabel(value, all) {
  if (value === 0) return "0";
  // On a logarithmic axis each has its own decimals.
  if (all.length > 2 && all[0] > 0 && all[2] - all[1] > 1.2 * (all[1] - all[0])) all = [value];
  const step = all.length > 1 ? Math.abs(all[1] - all[0]) : Math.abs(value);
  const largest = Math.max(...all.map(Math.abs));
  if (largest >= 1e5 || largest < 1e-3) return value.toExponential(1).replace("-", "−");
  const decimals = Math.max(0, Math.min(6, -Math.floor(Math.log10(step) + 1e-9)));
  const kept = Number.isInteger(Number((step * 10 ** decimals).toPrecision(6))) ? decimals : decimals + 1;
  return value.toFixed(kept).replace("-", "−");
}

/** A card: what is drawn comes from `view`, which all cards share. */
export class Card {
  constructor(series, row, view) {
    Object.assign(this, { series, row, view, visible: false });
    this.name = series.kind === "statistic" ? plainName(series.tag) : series.tag;
    this.value = el("span", { class: "value" });
    this.unit = el("span", { class: "unit" });
    this.quality = el("span", { class: "quality", hidden: true });
    this.limit = el("span", { class: "limit" });
    this.canvas = el("canvas", { "aria-hidden": "true" });
    this.plot = el("div", {
      class: "plot", role: "slider", tabindex: "-1", "aria-orientation": "horizontal",
      "aria-label": `${this.name}, ${series.kind}`, "aria-describedby": "chart-keys",
    }, this.canvas);
    const head = el("figcaption", {}, el("span", { class: "tag", title: series.tag }, this.name), this.quality, this.limit, el("span", { class: "reading" }, this.value, this.unit));
    this.element = el("figure", { class: `card ${series.kind}` }, head, this.plot);
    this.plot.card = this;
  }

  /** The limits to draw: residuals have one on either side. */
  limits() {
    const { kind, limit } = this.series;
    if (limit === null || limit === undefined) return [];
    return kind === "residual" ? [limit, -limit] : [limit];
  }

  /** The pair under the cursor, or the last. */
  reading() {
    const { trend, cursor } = this.view;
    if (cursor === null) return trend.last(this.series);
    return { min: this.series.min[cursor], max: this.series.max[cursor] };
  }

  /** Whether a pair is outside the limit. */
  isOver(pair) {
    const { kind, limit } = this.series;
    if (pair === null || limit === null || limit === undefined) return false;
    return pair.max > limit || (kind === "residual" && pair.min < -limit);
  }

  /** Writes the head: value, unit, quality, limit. */
  showHead(measured) {
    const pair = this.reading();
    const from_cursor = this.view.cursor !== null;
    let values = pair === null ? [] : [pair.min, pair.max];
    if (!from_cursor && Number.isFinite(measured?.value)) values = [measured.value, measured.value];
    values = values.filter(Number.isFinite);
    const largest = Math.max(0, ...values.map(Math.abs), ...this.limits().map(Math.abs));
    this.scale = scaleFor(this.series.unit, largest);
    const digits = this.series.kind === "input" || this.series.kind === "output" ? 5 : 3;
    const text = (value) => number(value / this.scale.factor, digits);
    const shown = values.map(text);
    const both = from_cursor && shown.length === 2 && shown[0] !== shown[1];
    write(this.value, shown.length === 0 ? "–" : both ? `${shown[0]} to ${shown[1]}` : text((values[0] + values.at(-1)) / 2));
    write(this.unit, this.scale.unit);
    const over = this.isOver(pair) && (from_cursor || this.isOver({ min: values[0], max: values.at(-1) }));
    this.showLimit(over);
    const quality = from_cursor ? null : measured?.quality?.toLowerCase?.();
    this.quality.hidden = GOOD.has(quality);
    write(this.quality, this.quality.hidden ? "" : quality);
    const spoken = `${this.value.textContent} ${this.scale.unit}${over ? ", beyond the limit" : ""}`;
    const at = this.view.cursor;
    const when = at === null ? "latest" : fullTime(this.view.trend.times[at]);
    this.plot.setAttribute("aria-valuemin", "0");
    this.plot.setAttribute("aria-valuemax", String(Math.max(0, this.view.trend.times.length - 1)));
    this.plot.setAttribute("aria-valuenow", String(at ?? Math.max(0, this.view.trend.times.length - 1)));
    this.plot.setAttribute("aria-valuetext", `${when}: ${spoken}`);
  }

  showLimit(over) {
    const limit = this.series.limit;
    this.element.classList.toggle("over", over);
    if (limit === null || limit === undefined) return;
    const text = `limit ${this.series.kind === "residual" ? "±" : ""}${number(limit / this.scale.factor, 3)}`;
    const key = `${text} ${over}`;
    if (this.limit.dataset.key === key) return;
    this.limit.dataset.key = key;
    const beyond = over ? [icon("high"), el("span", { class: "heard" }, "beyond the ")] : [];
    this.limit.replaceChildren(...beyond, text);
  }

  /** Draws the chart, if it can be seen. */
  draw() {
    if (!this.visible) return;
    const { trend, from, to, cursor, marks, log, colours } = this.view;
    const statistic = this.series.kind === "statistic";
    this.geometry = draw(
      this.canvas,
      {
        times: trend.times,
        min: this.series.min,
        max: this.series.max,
        first: Math.max(0, trend.firstAfter(from) - 1),
        last: Math.min(trend.times.length, trend.firstAfter(to) + 1),
        from,
        to,
        bucket_ms: trend.bucket_ms,
        gap_ms: trend.gap_ms,
        limits: this.limits(),
        from_zero: statistic,
        log: statistic && log,
        scale: this.scale ?? { factor: 1, unit: "" },
        marks,
        cursor,
        label: axisLabel,
        timeLabel: axisTime,
      },
      colours,
    );
  }
}
