// Pointer and keys on the charts.

/** A drag shorter than this is a click. */
const DRAG_PX = 6;

const cardOf = (target) => target.closest?.(".plot")?.card ?? null;

function timeAt(view, card, client_x) {
  if (!card.geometry) return null;
  const { left, right } = card.geometry;
  const share = (client_x - card.canvas.getBoundingClientRect().left - left) / (right - left);
  return view.from + Math.min(Math.max(share, 0), 1) * (view.to - view.from);
}

function zoomBy({ view, setZoom }, factor, about_ms) {
  setZoom([about_ms - (about_ms - view.from) * factor, about_ms + (view.to - about_ms) * factor]);
}

/** Hover reads, a drag zooms, a double click shows all; a finger reads and leaves scrolling alone. */
export function followPointer(place, charts) {
  const { view, setCursor, setZoom } = charts;
  let drag = null;
  const box = document.createElement("div");
  box.className = "drag";
  place.addEventListener("pointerdown", (event) => {
    const card = cardOf(event.target);
    if (card === null || event.button !== 0) return;
    focusCard(card);
    if (event.pointerType === "mouse") {
      drag = { card, start: event.clientX };
      card.plot.setPointerCapture(event.pointerId);
    }
    setCursor(timeAt(view, card, event.clientX));
  });
  place.addEventListener("pointermove", (event) => {
    const card = drag?.card ?? cardOf(event.target);
    if (card === null) return;
    setCursor(timeAt(view, card, event.clientX));
    if (drag === null || Math.abs(event.clientX - drag.start) < DRAG_PX) return;
    const left = card.plot.getBoundingClientRect().left;
    card.plot.append(box);
    box.style.left = `${Math.min(drag.start, event.clientX) - left}px`;
    box.style.width = `${Math.abs(event.clientX - drag.start)}px`;
  });
  const end = (event) => {
    if (drag === null) return;
    const { card, start } = drag;
    drag = null;
    box.remove();
    if (event.type === "pointerup" && Math.abs(event.clientX - start) >= DRAG_PX) {
      setZoom([timeAt(view, card, start), timeAt(view, card, event.clientX)]);
    }
  };
  place.addEventListener("pointerup", end);
  place.addEventListener("pointercancel", end);
  place.addEventListener("pointerleave", () => drag === null && setCursor(null));
  place.addEventListener("dblclick", (event) => cardOf(event.target) && setZoom(null));
  place.addEventListener(
    "wheel",
    (event) => {
      const card = cardOf(event.target);
      // The wheel alone scrolls the page.
      if (card === null || !event.ctrlKey || !card.geometry) return;
      event.preventDefault();
      zoomBy(charts, Math.exp(Math.max(-50, Math.min(50, event.deltaY)) / 150), timeAt(view, card, event.clientX));
    },
    { passive: false },
  );
}

/** One chart at a time is in the order of Tab; arrows reach the others. */
function focusCard(card) {
  for (const own of card.plot.closest("#charts").querySelectorAll(".plot")) own.tabIndex = -1;
  card.plot.tabIndex = 0;
  card.plot.focus({ preventScroll: true });
}

function goTo({ shownCards }, card, step) {
  const all = shownCards();
  const next = all[all.indexOf(card) + step];
  if (next === undefined) return;
  focusCard(next);
  next.plot.scrollIntoView({ block: "nearest" });
}

function move({ view, setCursor }, steps) {
  const { trend } = view;
  const last = trend.times.length - 1;
  if (last < 0) return;
  const first = Math.max(0, trend.firstAfter(view.from) - 1);
  const end = Math.min(last, trend.firstAfter(view.to) - 1);
  const at = view.cursor === null && Number.isFinite(steps) ? end : (view.cursor ?? end) + steps;
  setCursor(trend.times[Math.min(Math.max(at, first), end)]);
}

const zoomKey = (factor) => (charts) =>
  zoomBy(charts, factor, charts.view.cursor_ms ?? charts.view.to);

const KEYS = {
  ArrowLeft: (charts) => move(charts, -1),
  ArrowRight: (charts) => move(charts, 1),
  PageUp: (charts) => move(charts, -20),
  PageDown: (charts) => move(charts, 20),
  Home: (charts) => move(charts, -Infinity),
  End: (charts) => move(charts, Infinity),
  ArrowUp: (charts, card) => goTo(charts, card, -1),
  ArrowDown: (charts, card) => goTo(charts, card, 1),
  "+": zoomKey(0.5),
  "=": zoomKey(0.5),
  "-": zoomKey(2),
  0: (charts) => charts.setZoom(null),
  Escape: (charts) => charts.setCursor(null),
};

/** Keys on a chart that has the focus. */
export function followKeys(place, charts) {
  place.addEventListener("keydown", (event) => {
    const card = cardOf(event.target);
    const work = KEYS[event.key];
    if (card === null || work === undefined || charts.view.trend === null) return;
    if (event.ctrlKey || event.metaKey || event.altKey) return;
    event.preventDefault();
    work(charts, card);
  });
  // The chart that Tab reaches has to be one that is shown.
  place.addEventListener("toggle", () => {
    const all = charts.shownCards();
    if (all.length > 0 && !all.some((card) => card.plot.tabIndex === 0)) all[0].plot.tabIndex = 0;
  }, true);
}
