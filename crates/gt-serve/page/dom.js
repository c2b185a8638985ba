// Elements without markup from strings: whatever comes from the service becomes text, never HTML.

const SVG = "http://www.w3.org/2000/svg";

/** The element of an id that the page has. */
export const byId = (id) => document.getElementById(id);

/**
 * A new element. Attributes that are null or false are left out, true ones are empty; functions
 * listen; children that are null are left out, strings become text.
 */
export function el(tag, attributes = {}, ...children) {
  const element = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (value === null || value === undefined || value === false) continue;
    if (typeof value === "function") element.addEventListener(name, value);
    else element.setAttribute(name, value === true ? "" : value);
  }
  element.append(...children.flat().filter((child) => child !== null && child !== undefined));
  return element;
}

/** One of the drawings at the top of the page; it says nothing to a screen reader. */
export function icon(name) {
  const svg = document.createElementNS(SVG, "svg");
  svg.setAttribute("class", "icon");
  svg.setAttribute("aria-hidden", "true");
  const use = document.createElementNS(SVG, "use");
  use.setAttribute("href", `#icon-${name}`);
  svg.append(use);
  return svg;
}

/** Text that is written only where it differs, so that a selection in it survives. */
export function write(element, text) {
  if (element.textContent !== text) element.textContent = text;
}

/** A bar of a share between 0 and 1; the text beside it says the number. */
export function bar(share, className = "") {
  const fill = el("span");
  fill.style.width = `${Math.round(100 * Math.min(Math.max(share || 0, 0), 1))}%`;
  return el("span", { class: `share ${className}`, "aria-hidden": "true" }, fill);
}

/** Puts the children of a parent in the given order; what has the focus keeps it. */
export function arrange(parent, children) {
  const focused = document.activeElement;
  let place = parent.firstChild;
  for (const child of children) {
    if (child === place) place = place.nextSibling;
    else parent.insertBefore(child, place);
  }
  while (place) {
    const next = place.nextSibling;
    place.remove();
    place = next;
  }
  if (focused && focused !== document.activeElement && focused.isConnected) {
    focused.focus({ preventScroll: true });
  }
}

/** A group of buttons of which one is pressed; `choose` is told which. */
export function choice(group, entries, choose) {
  const buttons = entries.map(([key, label]) =>
    el("button", { type: "button", "aria-pressed": "false", click: () => choose(key) }, label),
  );
  group.replaceChildren(...buttons);
  return {
    press(key) {
      entries.forEach(([own], place) =>
        buttons[place].setAttribute("aria-pressed", String(own === key)),
      );
    },
    label: (key, text) => write(buttons[entries.findIndex(([own]) => own === key)], text),
  };
}

/** Runs `work` soon, and at most once in `pause_ms`; calls in between are one. */
export function throttled(work, pause_ms) {
  let timer = null;
  let last = -Infinity;
  return () => {
    if (timer !== null) return;
    timer = setTimeout(
      () => {
        timer = null;
        last = performance.now();
        work();
      },
      Math.max(0, last + pause_ms - performance.now()),
    );
  };
}

/** Says something to screen readers: `alert` at once, `status` when they are quiet. */
export function say(where, text) {
  const region = byId(where);
  region.append(el("p", {}, text));
  while (region.childElementCount > 20) region.firstElementChild.remove();
}

/** A message with a button, in the notes of a panel; one of each key at a time. */
export function note(panel, key, text, action = null) {
  const notes = byId(panel);
  const old = [...notes.children].find((child) => child.dataset.key === key);
  if (text === null) {
    old?.remove();
    return;
  }
  if (old?.firstElementChild?.textContent === text) return;
  const button = action && el("button", { type: "button", click: action.run }, action.label);
  const fresh = el("p", { role: "status", "data-key": key }, el("span", {}, text), button);
  if (old) old.replaceWith(fresh);
  else notes.append(fresh);
}
