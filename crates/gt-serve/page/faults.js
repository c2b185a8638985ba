// The embedded turbine: faults to try on it.

import { get, post, remove } from "./api.js";
import { byId, el, note, say, write } from "./dom.js";
import { age, clock, plainName, quantity, zone } from "./format.js";
import { may, state } from "./state.js";

/** Each case with its unit, and the rate per hour and the limit to begin with. */
const CASES = {
  compressor_fouling: ["%", 60, 3],
  thermocouple_drift: ["%", 60, 2],
  turbine_damage: ["%", 60, 3],
  fuel_actuator_lag: ["s", 60, 1],
};
const PERIOD_MS = 3000;

let built = null;
let timer = null;

/** Shows the panel where there is a plant inside and the role may change it. */
export function showFaults() {
  const wanted = state.info?.embedded_plant === true && may("administer");
  byId("faults").hidden = !wanted;
  clearInterval(timer);
  if (!wanted) return;
  built ??= build();
  read();
  timer = setInterval(() => state.live && !document.hidden && read(), PERIOD_MS);
}

function build() {
  const cases = el("select", { name: "case" }, Object.keys(CASES).map((name) => el("option", { value: name }, plainName(name))));
  const field = (name) => el("input", { name, type: "number", min: "0.001", max: "10000", step: "any", required: true });
  const [rate, limit] = [field("rate_per_h"), field("limit")];
  const [rate_unit, limit_unit] = [el("span", { class: "unit" }), el("span", { class: "unit" })];
  const failure = el("p", { class: "failure", role: "alert", hidden: true });
  const form = el(
    "form",
    {},
    el("label", {}, "Fault ", cases),
    el("label", {}, "Grows by ", el("span", { class: "with-unit" }, rate, rate_unit)),
    el("label", {}, "Up to ", el("span", { class: "with-unit" }, limit, limit_unit)),
    failure,
    el("div", { class: "buttons" }, el("button", { type: "submit" }, "Start the fault")),
  );
  const choose = () => {
    const [unit, per_hour, most] = CASES[cases.value];
    [rate.value, limit.value] = [per_hour, most];
    write(rate_unit, `${unit} an hour`);
    write(limit_unit, unit);
  };
  const tell = (text) => {
    failure.hidden = text === null;
    write(failure, text ?? "");
  };
  cases.addEventListener("change", choose);
  choose();
  form.addEventListener("submit", async (event) => {
    event.preventDefault();
    tell(null);
    try {
      await post("faults", { case: cases.value, rate_per_h: Number(rate.value), limit: Number(limit.value) });
      say("status", `Started: ${plainName(cases.value)}.`);
      read();
    } catch (error) {
      tell(`Not started: ${error.message}.`);
    }
  });
  const list = el("ul", { class: "running" });
  const clear = el("button", { type: "button", hidden: true }, "Remove all faults");
  clear.addEventListener("click", async () => {
    tell(null);
    try {
      await remove("faults");
      say("status", "All faults are removed.");
      cases.focus();
      read();
    } catch (error) {
      tell(`Not removed: ${error.message}.`);
    }
  });
  byId("faults").replaceChildren(
    el("h2", {}, "Embedded turbine: try a fault"),
    form,
    list,
    clear,
  );
  return { list, clear };
}

async function read() {
  try {
    const { faults } = await get("faults");
    note("machine-notes", "faults", null);
    built.clear.hidden = faults.length === 0;
    built.list.replaceChildren(
      ...faults.map((fault) =>
        el(
          "li",
          {},
          el("strong", {}, plainName(fault.case)),
          ` ${quantity(fault.size, fault.unit)}, since ${clock(fault.onset_ms)} ${zone(fault.onset_ms)} (${age(fault.onset_ms)})`,
        ),
      ),
    );
  } catch (error) {
    // Without a connection the page says so already.
    if (error.status !== null) {
      note("machine-notes", "faults", `The faults could not be read: ${error.message}.`);
    }
  }
}
