// All that is known of one alarm: the hypotheses, what happened to it, where it came from.

import { get, path } from "./api.js";
import { bar, el } from "./dom.js";
import { clock, fullTime, interval, number, percent, plainName, quantity, zone } from "./format.js";

const EVENTS = {
  raised: "Raised",
  named: "Fault named",
  changed: "Name changed",
  acknowledged: "Acknowledged",
  shelved: "Shelved",
  unshelved: "Unshelved",
  returned: "Returned to normal",
  cleared: "Cleared",
};

const head = (...names) =>
  el("thead", { role: "rowgroup" }, el("tr", { role: "row" }, names.map((name) => el("th", { role: "columnheader", scope: "col" }, name))));
const line = (...cells) =>
  el("tr", { role: "row" }, cells.map((cell) => el("td", { role: "cell" }, cell ?? "")));

/** Fills a cell with an alarm's details; reads what happened to it. */
export function showDetails(cell, alarm) {
  const events = el("div", { class: "events" }, cell.querySelector(".events")?.firstChild ?? "Reading…");
  cell.replaceChildren(
    el("div", { class: "columns" }, hypotheses(alarm), events, el("dl", { class: "facts" }, facts(alarm))),
  );
  readEvents(events, alarm);
}

function hypotheses(alarm) {
  const sure = (probability) => el("span", { class: "sure" }, percent(probability), bar(probability));
  const own = [...(alarm.hypotheses ?? [])].sort((one, two) => two.probability - one.probability);
  const lines = own.map((each) =>
    line(
      plainName(each.fault),
      sure(each.probability),
      el("span", {}, quantity(each.magnitude, each.unit), second(interval(each.magnitude_interval, each.unit))),
      el("time", { title: fullTime(each.onset_ms) }, clock(each.onset_ms)),
    ),
  );
  if (alarm.none_of_these !== null) lines.push(line("None of these", sure(alarm.none_of_these)));
  if (lines.length === 0) return el("p", { class: "none" }, "No hypotheses: this detector only sees that something changed.");
  const table = el(
    "table",
    { role: "table" },
    el("caption", {}, "If there is a fault, it is"),
    head("Fault", "How sure", "How large", `Since (${zone(alarm.raised_ms)})`),
    el("tbody", { role: "rowgroup" }, lines),
  );
  return el("div", {}, table);
}

const second = (text) => (text ? el("span", { class: "second" }, text) : "");

function facts(alarm) {
  const seen = alarm.acknowledged;
  const shelf = alarm.shelved;
  const stamp = (ms) => (ms === null ? null : fullTime(ms));
  const found = [
    ["Raised", stamp(alarm.raised_ms)],
    ["Named", stamp(alarm.named_ms)],
    ["Ended", stamp(alarm.ended_ms)],
    ["Raised by", alarm.source === null ? null : plainName(alarm.source)],
    ["Statistic", alarm.statistic === null ? null : `${number(alarm.statistic)}, limit ${number(alarm.threshold)}`],
    ["Detector", alarm.detector],
    ["Acknowledged", seen && `${seen.by}, ${fullTime(seen.at_ms)}${seen.comment ? `: ${seen.comment}` : ""}`],
    ["Shelved", shelf && `${shelf.by}, until ${fullTime(shelf.until_ms)}: ${shelf.reason}`],
    ["Number", String(alarm.id)],
  ];
  return found
    .filter(([, value]) => value !== null && value !== undefined)
    .map(([name, value]) => el("div", {}, el("dt", {}, name), el("dd", {}, String(value))));
}

/** A text that is only a fault's name reads as one. */
const told = (text) => (text && /^[a-z0-9]+(_[a-z0-9]+)+$/.test(text) ? plainName(text) : text);

async function readEvents(place, alarm) {
  try {
    const { events } = await get(path(["alarms", alarm.id, "events"]));
    const lines = events.map((own) =>
      line(
        el("time", { title: fullTime(own.time_ms) }, clock(own.time_ms)),
        EVENTS[own.event] ?? plainName(String(own.event)),
        [own.by, told(own.text)].filter(Boolean).join(": "),
      ),
    );
    place.replaceChildren(
      el(
        "table",
        { role: "table" },
        el("caption", {}, "What happened"),
        head(`Time (${zone(alarm.raised_ms)})`, "Event", "By whom, and what was said"),
        el("tbody", { role: "rowgroup" }, lines),
      ),
    );
  } catch (error) {
    place.replaceChildren(
      el("p", { role: "status" }, `What happened could not be read: ${error.message}. `, el("button", { type: "button", click: () => readEvents(place, alarm) }, "Try again")),
    );
  }
}
