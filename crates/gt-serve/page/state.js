// What is known of the plant, and who wants to hear of a change.

const listeners = new Map();

/** The facts, as the service told them last. */
export const state = {
  /** The answer of /info; null before the first. */
  info: null,
  /** Machines by name, in the service's order. */
  machines: new Map(),
  /** Open alarms by id. */
  alarms: new Map(),
  /** Name of the machine that is shown. */
  selected: null,
  /** Whether the event stream stands. */
  live: false,
  /** When it was lost; null before it ever stood. */
  lost_ms: null,
  /** Updates that the service left out because the line was slow. */
  dropped: 0,
};

/** Calls `work` whenever `topic` changes. */
export function on(topic, work) {
  if (!listeners.has(topic)) listeners.set(topic, []);
  listeners.get(topic).push(work);
}

/** Tells of a change. */
export function changed(topic, ...facts) {
  for (const work of listeners.get(topic) ?? []) work(...facts);
}

/** Whether the role suffices. */
export function may(role) {
  const roles = ["read", "operate", "administer"];
  return roles.indexOf(state.info?.role) >= roles.indexOf(role);
}

/** Whether an alarm still wants something: it is up, or it went before anybody saw it. */
export const isOpen = (alarm) => alarm.state !== "normal";

/** Whether nobody has acknowledged an alarm. */
export const isUnseen = (alarm) => alarm.state.endsWith("unacknowledged");

/** Takes an alarm as the service tells it; says what was known of it before. */
export function takeAlarm(alarm) {
  const before = state.alarms.get(alarm.id) ?? null;
  if (isOpen(alarm)) state.alarms.set(alarm.id, alarm);
  else state.alarms.delete(alarm.id);
  changed("alarms", alarm);
  return before;
}

/** Shows a machine; `asked` is false where nobody chose it. */
export function select(name, asked = true) {
  if (asked) history.replaceState(null, "", `#machine=${encodeURIComponent(name)}`);
  if (state.selected === name) return;
  state.selected = name;
  changed("selected");
}
