// The list of machines, and the facts of the one that is shown.

import { arrange, bar, byId, el, icon, write } from "./dom.js";
import { age, clock, count, now, number, plainName, roughDuration, zone } from "./format.js";
import { isUnseen, on, select, state } from "./state.js";

/** How a state reads, its drawing, and whether it wants somebody. */
const STATES = {
  no_data: ["No data", "none", "quiet"],
  settling: ["Settling", "wait", "quiet"],
  healthy: ["Healthy", "ok", "quiet"],
  alarm: ["Alarm", "high", "alarm"],
  stale: ["Stale data", "stale", "warn"],
  failed: ["Failed", "failed", "warn"],
};
/** Data are called old after so long, whatever the state says. */
const OLD_MS = 10_000;

const describe = (name) => STATES[name] ?? [plainName(String(name)), "none", "quiet"];

/** A state's drawing and word. */
export function showState(element, name) {
  if (element.dataset.state === name) return;
  const [word, drawing, tone] = describe(name);
  element.dataset.state = name;
  element.className = `state ${tone}`;
  element.replaceChildren(icon(drawing), word);
}

const rows = new Map();

function newRow(name) {
  const mark = el("span", { class: "state" });
  const link = el("a", { href: `#machine=${encodeURIComponent(name)}` }, name);
  link.addEventListener("click", (event) => {
    event.preventDefault();
    select(name);
  });
  const cell = (label, ...children) => el("td", { role: "cell", "data-label": label }, ...children);
  const row = {
    mark,
    link,
    worst: cell("Worst/limit"),
    alarms: cell("Alarms"),
    age: cell("Data age"),
  };
  const head = el("th", { role: "rowheader", scope: "row" }, link, mark);
  row.element = el("tr", { role: "row" }, head, row.worst, row.alarms, row.age);
  return row;
}

function showRow(row, machine) {
  showState(row.mark, machine.state);
  const worst = machine.worst_ratio;
  const ratio = el("span", { class: worst > 1 ? "over" : "" }, number(worst, 3));
  row.worst.replaceChildren(bar((worst ?? 0) / 2, worst > 1 ? "over limit" : "limit"), ratio);
  const unseen = [...state.alarms.values()].filter(
    (alarm) => alarm.machine === machine.name && isUnseen(alarm) && !alarm.shelved,
  ).length;
  write(row.alarms, machine.open_alarms ? String(machine.open_alarms) : "0");
  row.alarms.className = unseen > 0 ? "unseen" : machine.open_alarms ? "some" : "zero";
  const chosen = machine.name === state.selected;
  row.element.className = chosen ? "chosen" : "";
  if (chosen) row.link.setAttribute("aria-current", "true");
  else row.link.removeAttribute("aria-current");
  showAge(row, machine);
}

function showAge(row, machine) {
  const known = machine.last_time_ms !== null;
  write(row.age, known ? roughDuration(now() - machine.last_time_ms) : "–");
  const old = known && now() - machine.last_time_ms > OLD_MS && machine.state !== "no_data";
  row.age.className = old ? "old" : "";
}

/** Shows all machines. */
export function showMachines() {
  for (const name of rows.keys()) if (!state.machines.has(name)) rows.delete(name);
  for (const machine of state.machines.values()) {
    if (!rows.has(machine.name)) rows.set(machine.name, newRow(machine.name));
    showRow(rows.get(machine.name), machine);
  }
  arrange(
    byId("machine-rows"),
    [...state.machines.keys()].map((name) => rows.get(name).element),
  );
  byId("machine-none").hidden = state.machines.size > 0;
  showFacts();
}

const facts = new Map();

function fact(name) {
  if (!facts.has(name)) {
    const value = el("dd");
    facts.set(name, value);
    byId("machine-facts").append(el("div", {}, el("dt", {}, name), value));
  }
  return facts.get(name);
}

function showModel(detector) {
  const key = JSON.stringify(detector);
  const value = fact("Model in use");
  if (value.dataset.key === key) return;
  value.dataset.key = key;
  if (detector === null) {
    value.replaceChildren("none yet");
    return;
  }
  const sum = String(detector.sha256 ?? "");
  value.replaceChildren(
    `${detector.name} (${detector.kind}) `,
    el("details", {}, el("summary", {}, `sha256 ${sum.slice(0, 12)}…`), el("code", {}, sum)),
  );
}

function showFacts() {
  const machine = state.machines.get(state.selected);
  byId("machine").hidden = machine === undefined;
  if (machine === undefined) return;
  write(byId("machine-title"), machine.name);
  showState(byId("machine-state"), machine.state);
  write(byId("machine-reason"), machine.reason ?? "");
  showModel(machine.detector);
  const worst = (machine.statistics ?? []).filter((own) => own.value !== null && own.limit > 0);
  worst.sort((one, two) => two.value / two.limit - one.value / one.limit);
  write(
    fact("Worst statistic"),
    worst.length === 0
      ? "–"
      : `${plainName(worst[0].name)}: ${number(worst[0].value, 3)}, limit ${number(worst[0].limit, 3)}`,
  );
  const missing = machine.missing_samples ?? 0;
  const share = machine.samples > 0 ? ` (${number((100 * missing) / (machine.samples + missing), 2)} %)` : "";
  write(fact("Samples"), `${count(machine.samples)}, missing ${count(missing)}${missing ? share : ""}`);
  showLast(machine);
}

function showLast(machine) {
  const last = machine.last_time_ms;
  const text = last === null ? "none yet" : `${clock(last)} ${zone(last)}, ${age(last)}`;
  write(fact("Last sample"), text);
}

/** Lets the ages go on. */
export function tickMachines() {
  for (const machine of state.machines.values()) {
    const row = rows.get(machine.name);
    if (row) showAge(row, machine);
  }
  const machine = state.machines.get(state.selected);
  if (machine) showLast(machine);
}

on("selected", showMachines);
