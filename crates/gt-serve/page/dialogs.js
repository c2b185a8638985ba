// The dialogs: acknowledge, shelve, unshelve, token. What was typed stays until it has arrived.

import { path, post, setToken } from "./api.js";
import { byId, say, write } from "./dom.js";
import { clock, headline, now, zone } from "./format.js";
import { changed, takeAlarm } from "./state.js";

const NAME = "gtfdi.operator";
const DONE = { acknowledge: "Acknowledged", shelve: "Shelved", unshelve: "Taken off the shelf" };
/** After so long without an answer the dialog says so. */
const SLOW_MS = 2000;

/** What was typed for an alarm and has not arrived. */
const drafts = new Map();
/** The alarm that a dialog is about. */
const subjects = new Map();

const fields = (dialog) => [...dialog.querySelector("form").elements].filter((field) => field.name);

/** Opens the dialog `action` for an alarm. */
export function ask(action, alarm) {
  const dialog = byId(action);
  subjects.set(action, alarm);
  write(dialog.querySelector(".subject"), `${headline(alarm)}, ${alarm.machine}`);
  fail(dialog, null);
  const draft = drafts.get(`${action} ${alarm.id}`) ?? {};
  dialog.querySelector("form").reset();
  for (const field of fields(dialog)) {
    field.setCustomValidity("");
    if (field.name in draft) field.value = draft[field.name];
    else if (field.name === "by") field.value = localStorage.getItem(NAME) ?? "";
    else if (field.tagName !== "SELECT") field.value = "";
  }
  dialog.showModal();
  const first = fields(dialog).find((field) => field.tagName !== "SELECT" && field.value === "");
  if (first && (first.required || action !== "acknowledge")) first.focus();
  else dialog.querySelector("button.main").focus();
  showUntil();
}

function fail(dialog, text) {
  const place = dialog.querySelector(".failure");
  place.hidden = text === null;
  write(place, text ?? "");
}

function busy(dialog, on) {
  const button = dialog.querySelector("button.main");
  button.dataset.label ??= button.textContent;
  button.setAttribute("aria-disabled", String(on));
  write(button, on ? "Sending…" : button.dataset.label);
}

const isBusy = (dialog) => dialog.querySelector("button.main").getAttribute("aria-disabled") === "true";

async function send(action) {
  const dialog = byId(action);
  const alarm = subjects.get(action);
  if (isBusy(dialog)) return;
  const body = Object.fromEntries(fields(dialog).map((field) => [field.name, field.value.trim()]));
  if ("minutes" in body) body.minutes = Number(body.minutes);
  localStorage.setItem(NAME, body.by);
  fail(dialog, null);
  busy(dialog, true);
  const about = () => dialog.open && subjects.get(action) === alarm;
  const slow = setTimeout(() => about() && fail(dialog, "No answer yet. Still waiting…"), SLOW_MS);
  try {
    const answer = await post(path(["alarms", alarm.id, action]), body);
    drafts.delete(`${action} ${alarm.id}`);
    takeAlarm(answer);
    if (about()) dialog.close();
    say("status", `${DONE[action]}: ${headline(alarm)}, ${alarm.machine}.`);
    changed("answered", alarm.id);
  } catch (error) {
    const text = `Not done: ${error.message}.`;
    if (error.status === 401) changed("unauthorized");
    if (about()) fail(dialog, `${text} ${error.status === null ? "It may have arrived all the same; to send it again does no harm." : ""}`.trim());
    else changed("unsent", `${headline(alarm)}, ${alarm.machine}: ${text} What you typed is kept.`);
  } finally {
    clearTimeout(slow);
    busy(dialog, false);
  }
}

function showUntil() {
  const dialog = byId("shelve");
  const until_ms = now() + 60_000 * Number(dialog.querySelector("select").value);
  write(dialog.querySelector(".until"), `until ${clock(until_ms)} ${zone(until_ms)}`);
}

for (const action of Object.keys(DONE)) {
  const dialog = byId(action);
  dialog.querySelector("form").addEventListener("submit", (event) => {
    event.preventDefault();
    send(action);
  });
  dialog.querySelector(".cancel").addEventListener("click", () => dialog.close());
  dialog.addEventListener("input", (event) => {
    const typed = Object.fromEntries(fields(dialog).map((field) => [field.name, field.value]));
    drafts.set(`${action} ${subjects.get(action).id}`, typed);
    // Blanks are no name and no reason.
    const blank = event.target.required && event.target.value.trim() === "";
    event.target.setCustomValidity(blank ? "Please fill in this field." : "");
  });
}
byId("shelve").querySelector("select").addEventListener("change", showUntil);

let asked = null;
let given = null;

/** Asks for a token; resolves once one was given. */
export function askToken(text = null) {
  const dialog = byId("token");
  fail(dialog, text);
  if (!dialog.open) dialog.showModal();
  dialog.querySelector("input").focus();
  asked ??= new Promise((resolve) => {
    given = resolve;
  });
  return asked;
}

byId("token").addEventListener("cancel", (event) => event.preventDefault());
byId("token").addEventListener("close", () => given !== null && byId("token").showModal());
byId("token").querySelector("form").addEventListener("submit", (event) => {
  event.preventDefault();
  const input = byId("token").querySelector("input");
  setToken(input.value.trim());
  input.value = "";
  const done = given;
  [asked, given] = [null, null];
  byId("token").close();
  done?.();
});
