// The list of alarms: open ones, those on the shelf, and history.

import { ask } from "./dialogs.js";
import { showDetails } from "./alarm_details.js";
import { arrange, bar, byId, choice, el, icon, note, throttled, write } from "./dom.js";
import {
  age, clock, fullTime, headline, interval, now, number, percent, plainName, priority, quantity, zone,
} from "./format.js";
import { get, path } from "./api.js";
import { isUnseen, may, on, select, state } from "./state.js";

const STATES = {
  active_unacknowledged: "Active, not acknowledged",
  active_acknowledged: "Active, acknowledged",
  returned_unacknowledged: "Returned, not acknowledged",
  normal: "Cleared",
};
const EMPTY = {
  open: "No open alarm.",
  shelf: "No alarm is shelved.",
  history: "No alarm in this time.",
};
/** Most alarms that are read of the past. */
const PAST = 200;

let list = "open";
let past = [];
const rows = new Map();

const onShelf = (alarm) => Boolean(alarm.shelved);
const isActive = (alarm) => alarm.state.startsWith("active");

/** Unacknowledged first, then the severe, then the new. */
function order(one, two) {
  return (
    isUnseen(two) - isUnseen(one) ||
    isActive(two) - isActive(one) ||
    two.severity - one.severity ||
    two.raised_ms - one.raised_ms
  );
}

/** A time that ages. */
export function time(ms, { ages = true } = {}) {
  return el(
    "time",
    { title: fullTime(ms), "data-age": ages && ms !== null ? String(ms) : null },
    clock(ms),
    ages ? el("span", { class: "age" }, ` ${age(ms)}`) : null,
  );
}

class Row {
  constructor(id) {
    this.id = id;
    const cell = (label) => el("td", { role: "cell", "data-label": label });
    this.cells = [cell("State"), cell("Fault"), cell("Since"), cell("How large"), cell("How sure")];
    this.fault = el("strong");
    this.more = el("button", { type: "button", class: "more", "aria-expanded": "false", click: () => this.toggle() }, this.fault);
    this.machine = el("a", { click: (event) => this.goToMachine(event) });
    this.about = el("span");
    this.cells[1].append(this.more, el("span", { class: "second" }, this.machine, this.about));
    const button = (label, click) => el("button", { type: "button", click }, label);
    this.buttons = {
      acknowledge: button("Acknowledge", () => ask("acknowledge", this.alarm)),
      shelve: button("Shelve…", () => ask("shelve", this.alarm)),
      unshelve: button("Unshelve…", () => ask("unshelve", this.alarm)),
    };
    const all = el("td", { role: "cell", class: "actions" });
    all.append(...Object.values(this.buttons));
    this.element = el("tr", { role: "row" }, ...this.cells, all);
    this.inside = el("td", { role: "cell", colspan: "6" });
    this.details = el("tr", { role: "row", class: "details", hidden: true }, this.inside);
  }

  goToMachine(event) {
    event.preventDefault();
    select(this.alarm.machine);
    byId("machine").scrollIntoView({ block: "start" });
    byId("machine").focus({ preventScroll: true });
  }

  toggle() {
    const open = this.details.hidden;
    this.details.hidden = !open;
    this.more.setAttribute("aria-expanded", String(open));
    if (open) showDetails(this.inside, this.alarm);
  }

  show(alarm) {
    const text = JSON.stringify(alarm);
    if (this.text === text) return;
    this.text = text;
    this.alarm = alarm;
    const unseen = isUnseen(alarm);
    const band = priority(alarm.severity);
    const tone = alarm.state === "normal" ? "past" : onShelf(alarm) ? "shelved" : band;
    this.element.className = `${tone} ${unseen ? "unseen" : "seen"} ${isActive(alarm) ? "active" : "returned"}`;
    this.element.dataset.alarm = alarm.id;
    this.showState(alarm, band, unseen);
    write(this.fault, headline(alarm));
    this.more.title = `${alarm.fault ?? alarm.finding}: show or hide the details`;
    write(this.machine, alarm.machine);
    this.machine.href = `#machine=${encodeURIComponent(alarm.machine)}`;
    write(this.about, statistic(alarm));
    this.showSince(alarm);
    this.cells[3].replaceChildren(
      el("span", { class: "figure" }, quantity(alarm.magnitude, alarm.unit)),
      second(interval(alarm.magnitude_interval, alarm.unit)),
    );
    this.cells[4].replaceChildren(
      el("span", { class: "figure" }, percent(alarm.probability)),
      alarm.probability === null || alarm.probability === undefined ? "" : bar(alarm.probability),
    );
    this.showButtons(alarm, unseen);
    if (!this.details.hidden) showDetails(this.inside, alarm);
  }

  showState(alarm, band, unseen) {
    const words = STATES[alarm.state] ?? plainName(String(alarm.state));
    const drawing = alarm.state === "normal" ? icon("ok") : icon(unseen ? band : `${band}-seen`);
    this.cells[0].replaceChildren(
      el("span", { class: "mark" }, drawing, el("span", { class: "words" }, words)),
      second(`severity ${alarm.severity}, ${band}`),
      onShelf(alarm)
        ? second(`shelved until ${clock(alarm.shelved.until_ms)} ${zone(alarm.shelved.until_ms)}`)
        : "",
    );
  }

  showSince(alarm) {
    const ends = alarm.onset_interval_ms;
    const after = alarm.ended_ms === null ? [] : [", ended ", time(alarm.ended_ms, { ages: false })];
    this.cells[2].replaceChildren(
      el("span", { class: "figure" }, alarm.onset_ms === null ? "–" : time(alarm.onset_ms)),
      second(ends ? `between ${clock(ends[0])} and ${clock(ends[1])}` : null),
      el("span", { class: "second" }, "alarm ", time(alarm.raised_ms, { ages: alarm.onset_ms === null }), ...after),
    );
  }

  showButtons(alarm, unseen) {
    const open = alarm.state !== "normal" && may("operate");
    const shelf = onShelf(alarm);
    const wanted = {
      acknowledge: open && unseen,
      shelve: open && !shelf,
      unshelve: open && shelf,
    };
    for (const [name, button] of Object.entries(this.buttons)) {
      const focused = document.activeElement === button;
      button.hidden = !wanted[name];
      button.setAttribute("aria-label", `${button.textContent} ${headline(alarm)}, ${alarm.machine}`);
      if (focused && button.hidden) this.more.focus();
    }
  }
}

const second = (text) => (text ? el("span", { class: "second" }, text) : "");

/** Which statistic raised the alarm, and how far above its limit. */
function statistic(alarm) {
  const other = alarm.source && alarm.source !== alarm.fault ? alarm.source.replaceAll("_", " ") : null;
  if (alarm.statistic === null || alarm.threshold === null) return other ? `: ${other}` : "";
  const values = `${number(alarm.statistic, 3)}, limit ${number(alarm.threshold, 3)}`;
  return `: ${other ?? "statistic"} ${values}`;
}

function listed() {
  const open = [...state.alarms.values()].sort(order);
  if (list === "open") return open.filter((alarm) => !onShelf(alarm));
  if (list === "shelf") return open.filter(onShelf);
  return past;
}

const lists = choice(
  byId("alarm-lists"),
  [["open", "Open"], ["shelf", "Shelved"], ["history", "History"]],
  (key) => {
    list = key;
    showAlarms();
    if (key === "history") readHistory();
  },
);

/** Shows the list that is chosen. */
export function showAlarms() {
  const alarms = listed();
  const wanted = new Set(alarms.map((alarm) => alarm.id));
  const children = [];
  for (const alarm of alarms) {
    if (!rows.has(alarm.id)) rows.set(alarm.id, new Row(alarm.id));
    const row = rows.get(alarm.id);
    try {
      row.show(alarm);
    } catch (error) {
      // One alarm that is not as it should be must not hide the others.
      note("alarm-notes", `alarm ${alarm.id}`, `Alarm ${alarm.id} of ${alarm.machine} cannot be shown whole: ${error.message}.`);
    }
    children.push(row.element, row.details);
  }
  arrange(byId("alarm-rows"), children);
  for (const id of rows.keys()) if (!wanted.has(id)) rows.delete(id);
  const open = [...state.alarms.values()];
  const shelf = open.filter(onShelf).length;
  lists.press(list);
  lists.label("open", `Open (${open.length - shelf})`);
  lists.label("shelf", `Shelved (${shelf})`);
  byId("history-filter").hidden = list !== "history";
  byId("alarm-table").hidden = alarms.length === 0;
  byId("alarm-none").hidden = alarms.length > 0;
  write(byId("alarm-none"), state.info === null ? "Not read yet." : EMPTY[list]);
}

/** Focus for somebody whose button is gone with what it did. */
export function focusAlarm(id) {
  const row = rows.get(id);
  if (row?.element.isConnected) row.more.focus();
  else byId("alarms").focus();
}

async function readHistory() {
  const span = byId("history-span").value;
  const machine = byId("history-machine").value;
  const since_ms = span === "" ? "" : now() - Number(span);
  try {
    const answer = await get(path(["alarms"], { open: false, machine, since_ms, limit: PAST }));
    past = answer.alarms.toSorted((one, two) => two.raised_ms - one.raised_ms);
    note("alarm-notes", "history", past.length < PAST ? null : `The last ${PAST} are shown: choose a machine or a shorter time for others.`);
  } catch (error) {
    note("alarm-notes", "history", `The history could not be read: ${error.message}.`, {
      label: "Try again",
      run: readHistory,
    });
  }
  showAlarms();
}

/** The machines that the history can be narrowed to. */
export function offerMachines() {
  const box = byId("history-machine");
  const names = ["", ...state.machines.keys()];
  if (names.length === box.options.length) return;
  const chosen = box.value;
  box.replaceChildren(...names.map((name) => el("option", { value: name }, name || "all")));
  box.value = chosen;
}

for (const id of ["history-machine", "history-span"]) byId(id).addEventListener("change", readHistory);
const readSoon = throttled(readHistory, 1000);
on("alarms", () => list === "history" && readSoon());
