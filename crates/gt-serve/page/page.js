// The operator's page: connects, keeps what the service tells, and shows it.

import { focusAlarm, offerMachines, showAlarms } from "./alarms.js";
import { get, hasToken, listen, setToken } from "./api.js";
import { askToken } from "./dialogs.js";
import { byId, el, icon, note, say, throttled, write } from "./dom.js";
import { showFaults } from "./faults.js";
import { age, clock, clockOffset, duration, fullTime, headline, now, setClock, zone } from "./format.js";
import { showMachines, tickMachines } from "./machines.js";
import { changed, isOpen, isUnseen, on, select, state, takeAlarm } from "./state.js";
import { readSoon, readTrend, takeSample } from "./trends.js";

/** Pauses between tries to connect. */
const PAUSES_MS = [500, 1000, 2000, 4000, 8000];
/** Pause before another try to read the machines and alarms. */
const RETRY_MS = 5000;
/** A clock that is further off than this is worth a word. */
const CLOCK_OFF_MS = 5000;

let version = null;
/** The connection that stands, if any. */
let stream = null;
/** Why there is no connection. */
let why = "";
let wake = () => {};

const sleep = (ms) =>
  new Promise((resolve) => {
    const timer = setTimeout(resolve, ms);
    wake = () => {
      clearTimeout(timer);
      resolve();
    };
  });

async function readInfo() {
  state.info = await get("info");
  setClock(state.info.now_ms);
  version ??= state.info.version;
  note(
    "machine-notes",
    "version",
    version === state.info.version ? null : `The service is now version ${state.info.version}: load the page again.`,
    { label: "Load again", run: () => location.reload() },
  );
  byId("sign-out").hidden = !hasToken();
  showFaults();
  showAbout();
}

/** Machines and open alarms; once more where an alarm changed on the way. */
async function readAll(changes) {
  for (let tries = 0; tries < 3; tries++) {
    const before = changes.alarms;
    const [{ machines }, { alarms }] = await Promise.all([get("machines"), get("alarms?open=true")]);
    state.machines = new Map(machines.map((machine) => [machine.name, machine]));
    const known = state.alarms;
    state.alarms = new Map(alarms.filter(isOpen).map((alarm) => [alarm.id, alarm]));
    announceMissed(known);
    if (changes.alarms === before) break;
  }
  chooseMachine();
  showMachines();
  changed("alarms");
  await readTrend();
}

/** Alarms that came while there was no connection are told like any other. */
function announceMissed(known) {
  if (state.lost_ms === null) return;
  for (const alarm of state.alarms.values()) if (!known.has(alarm.id)) announce(alarm, null);
}

function fromAddress() {
  const found = /^#machine=(.*)$/.exec(location.hash);
  try {
    return found && decodeURIComponent(found[1]);
  } catch {
    return null;
  }
}

function chooseMachine() {
  const asked = fromAddress();
  if (asked !== null && state.machines.has(asked)) return select(asked);
  if (state.machines.has(state.selected)) return;
  const all = [...state.machines.values()];
  const first = all.find((machine) => machine.state === "alarm") ?? all[0];
  if (first) select(first.name, false);
}

const takes = {
  machine(machine) {
    const fresh = !state.machines.has(machine.name);
    state.machines.set(machine.name, machine);
    if (fresh) chooseMachine();
    changed("machines");
  },
  alarm(alarm) {
    announce(alarm, takeAlarm(alarm));
  },
  sample: takeSample,
  dropped({ count }) {
    state.dropped += count;
    readSoon();
  },
};

/** Tells screen readers what is new about an alarm. */
function announce(alarm, before) {
  const about = `${headline(alarm)}, ${alarm.machine}`;
  if (before === null) {
    if (isOpen(alarm)) say("alert", `New alarm: ${about}, severity ${alarm.severity}.`);
  } else if (!isOpen(alarm)) say("status", `Alarm cleared: ${about}.`);
  else if (before.fault !== alarm.fault || before.finding !== alarm.finding) {
    say("alert", `Alarm of ${alarm.machine} is now: ${headline(alarm)}.`);
  } else if (before.state.startsWith("active") && !alarm.state.startsWith("active")) {
    say("status", `Returned to normal, not acknowledged: ${about}.`);
  }
}

async function connect() {
  const changes = { alarms: 0 };
  await readInfo();
  try {
    await listen({
      opened() {
        stream = changes;
        catchUp(changes);
      },
      event(name, data) {
        if (name === "alarm") changes.alarms += 1;
        // A name such as `constructor` is no event.
        if (Object.hasOwn(takes, name)) takes[name](data);
      },
    });
  } finally {
    stream = null;
  }
}

/** Reads what happened before the stream stood; again and again until it is read or the stream ends. */
async function catchUp(changes) {
  try {
    await readAll(changes);
  } catch (error) {
    if (stream !== changes) return;
    const text = `Alarms and machines could not be read: ${error.message}. The next try is in ${RETRY_MS / 1000} s.`;
    note("alarm-notes", "all", text);
    setTimeout(() => stream === changes && catchUp(changes), RETRY_MS);
    return;
  }
  if (stream !== changes) return;
  const { lost_ms } = state;
  setLive(true);
  say("status", lost_ms === null ? `Connected. ${byId("summary").textContent}.` : `Connected again after ${duration(now() - lost_ms)}.`);
  state.lost_ms = null;
}

async function run() {
  for (let tries = 0; ; tries++) {
    let unauthorized = null;
    try {
      await connect();
    } catch (error) {
      if (error.status === 401) unauthorized = error;
      else why = error.message;
    }
    if (state.live) tries = 0;
    setLive(false);
    if (unauthorized) {
      await askToken(hasToken() ? `The service refused the token: ${unauthorized.message}.` : null);
      continue;
    }
    await sleep(PAUSES_MS[Math.min(tries, PAUSES_MS.length - 1)]);
  }
}

function setLive(live) {
  if (live) {
    why = "";
    note("alarm-notes", "all", null);
    showSummary();
  }
  if (state.live && !live) {
    state.lost_ms = now();
    say("alert", `No connection since ${clock(state.lost_ms)} ${zone(state.lost_ms)}.`);
  }
  state.live = live;
  showConnection();
}

function showConnection() {
  const { live, lost_ms, info } = state;
  const never = lost_ms === null && !live;
  document.body.dataset.connection = live ? "live" : never ? "none" : "lost";
  const chip = byId("connection");
  const text = live ? "Live" : never ? (why ? "No connection" : "Connecting…") : "No connection";
  if (chip.dataset.text !== text) {
    chip.dataset.text = text;
    chip.className = `connection ${live ? "live" : why || !never ? "lost" : ""}`;
    chip.replaceChildren(icon(live ? "ok" : why || !never ? "failed" : "wait"), text);
  }
  const banner = byId("banner");
  banner.hidden = live || (never && !why);
  if (banner.hidden) return;
  const since = never ? "No connection yet" : `No connection since ${clock(lost_ms)} ${zone(lost_ms)} (${age(lost_ms)})`;
  const told = why ? `: ${why}` : "";
  if (!banner.firstChild) {
    banner.append(el("span"), el("button", { type: "button", click: () => wake() }, "Try now"));
  }
  const stale = info === null || never ? "" : " What is shown is as it was then.";
  write(banner.firstChild, `${since}${told}.${stale}`);
}

function showSummary() {
  const open = [...state.alarms.values()];
  const unseen = open.filter((alarm) => isUnseen(alarm) && !alarm.shelved).length;
  const shelved = open.filter((alarm) => alarm.shelved).length;
  const summary = byId("summary");
  const text =
    open.length === 0
      ? "No open alarm"
      : `${open.length - shelved} open, ${unseen} not acknowledged${shelved ? `, ${shelved} shelved` : ""}`;
  if (summary.dataset.text !== text) {
    summary.dataset.text = text;
    summary.className = `summary ${unseen > 0 ? "unseen" : ""}`;
    summary.replaceChildren(...(unseen > 0 ? [icon("high")] : []), text);
  }
  const lost = state.live || state.lost_ms === null ? "" : "No connection – ";
  document.title = `${lost}${unseen > 0 ? `(${unseen}) ` : ""}gtfdi monitor`;
}

function showAbout() {
  const { info, dropped } = state;
  if (info === null) return;
  const parts = [
    `gtfdi ${info.version}, up since ${fullTime(info.started_ms)}`,
    `role: ${info.role}`,
    `times in ${Intl.DateTimeFormat().resolvedOptions().timeZone} (${zone()})`,
  ];
  const off = clockOffset();
  if (Math.abs(off) > CLOCK_OFF_MS) {
    parts.push(`this computer's clock is ${duration(Math.abs(off))} ${off > 0 ? "behind" : "ahead of"} the service's`);
  }
  if (dropped > 0) parts.push(`${dropped} updates left out on a slow line; the trends were read again`);
  write(byId("about"), parts.join(" · "));
}

function tick() {
  write(byId("clock"), `${clock(now())} ${zone()}`);
  for (const element of document.querySelectorAll("[data-age]")) {
    write(element.querySelector(".age"), ` ${age(Number(element.dataset.age))}`);
  }
  for (const element of document.querySelectorAll("[data-zone]")) write(element, `(${zone()})`);
  tickMachines();
  showConnection();
  showSummary();
  showAbout();
}

const showAlarmsSoon = throttled(() => {
  showAlarms();
  showSummary();
}, 100);
const showMachinesSoon = throttled(() => {
  showMachines();
  offerMachines();
}, 250);

on("alarms", showAlarmsSoon);
// Timers of a tab in the background are slow; its title is what is seen of it.
on("alarms", showSummary);
on("alarms", showMachinesSoon);
on("machines", showMachinesSoon);
on("answered", (id) => {
  showAlarms();
  focusAlarm(id);
});
on("unsent", (text) => note("alarm-notes", "unsent", text, {
  label: "Dismiss",
  run: () => note("alarm-notes", "unsent", null),
}));
on("unauthorized", () => askToken("The service no longer takes this token.").then(() => wake()));
// A page that no longer does its work must say so.
const broken = (reason) => note("alarm-notes", "broken", `This page met an error: ${reason}. What it shows may be wrong.`, {
  label: "Load again",
  run: () => location.reload(),
});
addEventListener("error", (event) => broken(event.message));
addEventListener("unhandledrejection", (event) => broken(String(event.reason?.message ?? event.reason)));
addEventListener("hashchange", chooseMachine);
addEventListener("online", () => wake());
byId("sign-out").addEventListener("click", () => {
  setToken(null);
  location.reload();
});

showAlarms();
tick();
setInterval(tick, 1000);
run();
