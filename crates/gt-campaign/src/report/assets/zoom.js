// Charts that zoom. The page is whole without this script: each chart is an SVG, and beside it lie
// the numbers behind it. Charts over the same abscissa zoom together.
'use strict';

(() => {
  const SVG = 'http://www.w3.org/2000/svg';
  const SYMBOL = 4;            // half the size of a cross or ring, px
  const CHARACTER = 6.6;       // about the width of a character, px
  const CLICK = 6;             // what moves less is a click, px
  const groups = new Map();

  const element = (name, attributes, text) => {
    const made = document.createElementNS(SVG, name);
    for (const [key, value] of Object.entries(attributes)) made.setAttribute(key, value);
    if (text !== undefined) made.textContent = text;
    return made;
  };

  // ---- numbers

  const decode = (numbers) => {
    if (Array.isArray(numbers)) return Float64Array.from(numbers, (own) => (own === null ? NaN : own));
    if (numbers.code === undefined) {
      return Float64Array.from({ length: numbers.count }, (_, k) => numbers.from + k * numbers.step);
    }
    const bytes = Uint8Array.from(atob(numbers.code), (own) => own.charCodeAt(0));
    const view = new DataView(bytes.buffer);
    return Float64Array.from({ length: bytes.length / 2 }, (_, k) => {
      const own = view.getUint16(2 * k, true);
      return own === 65535 ? NaN : numbers.low + (own / 65534) * (numbers.high - numbers.low);
    });
  };

  const digits = (value) => {
    if (!Number.isFinite(value)) return '-';
    const size = Math.abs(value);
    if (value !== 0 && (size < 1e-3 || size >= 1e7)) return value.toExponential(3);
    return String(Number(value.toPrecision(6)));
  };

  // ---- axes: [from, to] of values on [a, b] of pixels

  const even = (value, logarithmic) => (logarithmic ? Math.log(value) : value);
  const back = (value, logarithmic) => (logarithmic ? Math.exp(value) : value);

  class Axis {
    constructor([low, high], [a, b], logarithmic) {
      Object.assign(this, { low, high, a, b, logarithmic });
      this.from = even(low, logarithmic);
      this.span = even(high, logarithmic) - this.from;
    }

    pixel(value) {
      return this.a + ((even(value, this.logarithmic) - this.from) / this.span) * (this.b - this.a);
    }

    value(pixel) {
      return back(this.from + ((pixel - this.a) / (this.b - this.a)) * this.span, this.logarithmic);
    }

    // The window after a move by a share of its length, and a stretch by a factor about its middle.
    moved(share, factor) {
      const middle = this.from + this.span * (0.5 + share);
      const half = (this.span * factor) / 2;
      return [middle - half, middle + half].map((own) => back(own, this.logarithmic));
    }

    ticks() {
      if (this.logarithmic && this.high / this.low > 3) return this.decades();
      const raw = (this.high - this.low) / 6;
      const power = 10 ** Math.floor(Math.log10(raw));
      const step = [1, 2, 5, 10].map((own) => own * power).find((own) => own >= raw) || raw;
      const ticks = [];
      for (let k = Math.ceil(this.low / step); k * step <= this.high + 1e-9 * step && ticks.length < 50; k += 1) {
        ticks.push([k * step, label(k * step, step)]);
      }
      return ticks;
    }

    decades() {
      const factors = Math.log10(this.high / this.low) > 2.5 ? [1] : [1, 2, 5];
      const ticks = [];
      for (let k = Math.floor(Math.log10(this.low)); 10 ** k <= this.high && ticks.length < 50; k += 1) {
        for (const factor of factors) {
          const tick = factor * 10 ** k;
          if (tick >= this.low && tick <= this.high) ticks.push([tick, label(tick, 10 ** k)]);
        }
      }
      return ticks;
    }
  }

  const label = (value, step) => {
    const size = Math.max(Math.abs(value), step);
    if (Math.abs(value) < 1e-9 * step) return '0';
    if (size < 1e-3 || size >= 1e6) {
      const places = Math.floor(Math.log10(Math.abs(value))) - Math.floor(Math.log10(step));
      return value.toExponential(Math.min(Math.max(places, 0), 12)).replace('e+', 'e');
    }
    return value.toFixed(Math.min(Math.max(-Math.floor(Math.log10(step) + 1e-9), 0), 12));
  };

  // ---- paths

  const symbol = (x, y, rings) => {
    const size = 2 * SYMBOL;
    return rings
      ? `M${x - SYMBOL} ${y}a${SYMBOL} ${SYMBOL} 0 1 0 ${size} 0a${SYMBOL} ${SYMBOL} 0 1 0 -${size} 0`
      : `M${x - SYMBOL} ${y - SYMBOL}l${size} ${size}m0 -${size}l-${size} ${size}`;
  };

  // The samples in the window and one on either side, where the abscissa grows; else all.
  const inside = (x, [low, high]) => {
    let first = 0;
    let end = x.length;
    for (let k = 1; k < x.length; k += 1) if (!(x[k] >= x[k - 1])) return [first, end];
    while (first + 1 < end && x[first + 1] < low) first += 1;
    while (end - 2 > first && x[end - 2] > high) end -= 1;
    return [first, end];
  };

  class Chart {
    constructor(figure, data) {
      this.svg = figure.querySelector('svg');
      this.view = this.svg.querySelector('.view');
      this.data = data;
      this.curves = data.curves.map((own) => ({
        ...own, x: decode(own.x), y: decode(own.y), band: own.band && own.band.map(decode),
      }));
      this.window = data.axes[0];
      this.heights = null;
      const key = data.square ? `square ${groups.size}` : JSON.stringify([data.x_label, data.axes[0]]);
      if (!groups.has(key)) groups.set(key, []);
      this.group = groups.get(key);
      this.group.push(this);
      this.clip = `clip${document.querySelectorAll('clipPath').length}`;
      const [left, right, top, bottom] = data.frame;
      const clip = element('clipPath', { id: this.clip });
      clip.append(element('rect', { x: left, y: top, width: right - left, height: bottom - top }));
      this.svg.prepend(clip);
      this.over = element('g', {});
      this.svg.append(this.over);
      this.controls(figure);
      this.listen();
    }

    controls(figure) {
      const line = document.createElement('div');
      line.className = 'script';
      this.readout = document.createElement('output');
      this.readout.className = 'readout';
      const buttons = document.createElement('span');
      buttons.className = 'zoom';
      for (const [text, what, act] of [
        ['+', 'zoom in', () => this.zoom(0, 0.5)], ['\u2212', 'zoom out', () => this.zoom(0, 2)],
        ['\u2190', 'earlier', () => this.zoom(-0.25, 1)], ['\u2192', 'later', () => this.zoom(0.25, 1)],
        ['all', 'show all', () => this.reset()],
      ]) {
        const button = document.createElement('button');
        button.type = 'button';
        button.textContent = text;
        button.title = what;
        button.setAttribute('aria-label', `${what}: ${this.svg.getAttribute('aria-label')}`);
        button.addEventListener('click', act);
        buttons.append(button);
      }
      line.append(this.readout);
      figure.querySelector('figcaption').append(buttons);
      figure.querySelector('figcaption').before(line);
      this.svg.classList.add('live');
      this.svg.setAttribute('tabindex', '0');
    }

    // ---- what the reader does

    listen() {
      this.svg.addEventListener('pointerdown', (event) => {
        if (event.pointerType === 'touch' || event.button !== 0) return;
        this.start = this.place(event);
        this.svg.setPointerCapture(event.pointerId);
      });
      this.svg.addEventListener('pointermove', (event) => {
        this.point(this.place(event));
      });
      this.svg.addEventListener('pointerup', (event) => {
        if (!this.start) return;
        const [start, end] = [this.start, this.place(event)];
        this.start = null;
        this.choose(start, end);
      });
      this.svg.addEventListener('pointercancel', () => { this.start = null; this.leave(); });
      this.svg.addEventListener('pointerleave', () => this.leave());
      this.svg.addEventListener('dblclick', () => this.reset());
      this.svg.addEventListener('keydown', (event) => {
        const act = {
          '+': () => this.zoom(0, 0.5), '=': () => this.zoom(0, 0.5), '-': () => this.zoom(0, 2),
          ArrowLeft: () => this.zoom(-0.25, 1), ArrowRight: () => this.zoom(0.25, 1),
          0: () => this.reset(), Escape: () => this.reset(),
        }[event.key];
        if (!act || event.ctrlKey || event.metaKey || event.altKey) return;
        event.preventDefault();
        act();
      });
    }

    place(event) {
      const box = this.svg.getBoundingClientRect();
      const { width, height } = this.svg.viewBox.baseVal;
      return [(event.clientX - box.left) * (width / box.width), (event.clientY - box.top) * (height / box.height)];
    }

    clamped([x, y]) {
      const [left, right, top, bottom] = this.data.frame;
      return [Math.min(Math.max(x, left), right), Math.min(Math.max(y, top), bottom)];
    }

    choose(start, end) {
      const [[x0, y0], [x1, y1]] = [this.clamped(start), this.clamped(end)];
      this.leave();
      if (Math.abs(x1 - x0) < CLICK) return;
      const [x, y] = this.axes();
      const window = [x.value(Math.min(x0, x1)), x.value(Math.max(x0, x1))];
      // A drag along the abscissa leaves the ordinate to what is there.
      const flat = Math.abs(y1 - y0) < 3 * CLICK && !this.data.square;
      const heights = flat ? null : [y.value(Math.max(y0, y1)), y.value(Math.min(y0, y1))];
      this.show(window, heights);
    }

    zoom(share, factor) {
      const [x, y] = this.axes();
      let window = x.moved(share, factor);
      if (!this.data.square) {
        const [low, high] = this.data.axes[0];
        if (factor > 1) window = [Math.max(window[0], low), Math.min(window[1], high)];
        if (window[0] < low || window[1] > high) return;
      }
      this.show(window, this.data.square ? y.moved(0, factor) : null);
    }

    reset() {
      this.show(this.data.axes[0], null);
    }

    show(window, heights) {
      if (!(window[1] > window[0])) return;
      for (const chart of this.group) {
        chart.window = window;
        chart.heights = chart === this ? heights : null;
        chart.draw();
      }
    }

    // ---- what is drawn

    axes() {
      const { frame: [left, right, top, bottom], logarithmic } = this.data;
      return [
        new Axis(this.window, [left, right], logarithmic[0]),
        new Axis(this.heights || this.extent(), [bottom, top], logarithmic[1]),
      ];
    }

    // The ordinates of what the window shows.
    extent() {
      const { axes, logarithmic } = this.data;
      if (this.window.every((own, k) => own === axes[0][k])) return axes[1];
      let [low, high] = [Infinity, -Infinity];
      const take = (value) => {
        const own = even(value, logarithmic[1]);
        if (Number.isFinite(own)) { low = Math.min(low, own); high = Math.max(high, own); }
      };
      for (const { x, y, band } of this.curves) {
        for (let k = 0; k < x.length; k += 1) {
          if (x[k] < this.window[0] || x[k] > this.window[1]) continue;
          take(y[k]);
          if (band) band.forEach((edge) => take(edge[k]));
        }
      }
      this.data.limits.forEach(take);
      if (!(low < high)) return axes[1];
      const margin = 0.06 * (high - low);
      return [low - margin, high + margin].map((own) => back(own, logarithmic[1]));
    }

    draw() {
      const [x, y] = this.axes();
      const [left, right, top, bottom] = this.data.frame;
      this.view.replaceChildren();
      for (const [tick, text] of y.ticks()) {
        const at = y.pixel(tick);
        this.view.append(
          element('line', { class: 'grid', x1: left, x2: right, y1: at, y2: at }),
          element('text', { x: left - 6, y: at + 4, 'text-anchor': 'end' }, text),
        );
      }
      for (const [tick, text] of x.ticks()) {
        const at = x.pixel(tick);
        this.view.append(
          element('line', { class: 'grid', x1: at, x2: at, y1: top, y2: bottom }),
          element('text', { x: at, y: bottom + 16, 'text-anchor': 'middle' }, text),
        );
      }
      const clipped = element('g', { 'clip-path': `url(#${this.clip})` });
      this.view.append(clipped);
      for (const curve of this.curves) clipped.append(...this.paths(curve, x, y));
      for (const limit of this.data.limits) {
        const at = y.pixel(limit);
        clipped.append(element('line', { class: 'limit', x1: left, x2: right, y1: at, y2: at }));
      }
      this.marks(clipped, x);
    }

    paths(curve, x, y) {
      const [first, end] = inside(curve.x, this.window);
      const at = (k, values) => [x.pixel(curve.x[k]), y.pixel(values[k])];
      const drawn = [];
      if (curve.band) {
        const edge = (values, order) => order.map((k) => at(k, values)).filter((own) => own.every(Number.isFinite));
        const order = Array.from({ length: end - first }, (_, k) => first + k);
        const corners = [...edge(curve.band[1], order), ...edge(curve.band[0], order.reverse())];
        const d = corners.map(([a, b], k) => `${k ? 'L' : 'M'}${a.toFixed(1)} ${b.toFixed(1)}`).join('');
        if (d) drawn.push(element('path', { class: `band ${curve.class}`, d: `${d}Z` }));
      }
      let d = '';
      let down = false;
      for (let k = first; k < end; k += 1) {
        const [a, b] = at(k, curve.y);
        if (!Number.isFinite(a) || !Number.isFinite(b)) { down = false; continue; }
        if (curve.stroke === 'crosses' || curve.stroke === 'rings') d += symbol(a, b, curve.stroke === 'rings');
        else d += `${down ? 'L' : 'M'}${a.toFixed(1)} ${b.toFixed(1)}`;
        down = true;
      }
      const dashed = curve.stroke === 'dashed' ? ' dashed' : '';
      drawn.push(element('path', { class: `line ${curve.class}${dashed}`, d }));
      return drawn;
    }

    marks(into, x) {
      const [left, right, top, bottom] = this.data.frame;
      const taken = [-Infinity, -Infinity];
      for (const [at, text] of this.data.marks) {
        const place = x.pixel(at);
        if (!(place >= left && place <= right)) continue;
        into.append(element('line', { class: 'mark', x1: place, x2: place, y1: top, y2: bottom }));
        const length = CHARACTER * text.length;
        const ends = place + length > right;
        const row = taken.findIndex((own) => (ends ? place - 4 - length : place) >= own);
        if (row < 0) continue;
        taken[row] = ends ? place : place + 4 + length;
        into.append(element('text', {
          class: 'marktext', x: place + (ends ? -4 : 4), y: top + 12 + 14 * row, 'text-anchor': ends ? 'end' : 'start',
        }, text));
      }
    }

    // ---- what lies under the pointer

    point(place) {
      const [left, right, top, bottom] = this.data.frame;
      const [px, py] = this.clamped(place);
      const [x] = this.axes();
      this.over.replaceChildren(element('line', { class: 'cursor', x1: px, x2: px, y1: top, y2: bottom }));
      if (this.start) {
        const [sx, sy] = this.clamped(this.start);
        const flat = Math.abs(py - sy) < 3 * CLICK && !this.data.square;
        this.over.append(element('rect', {
          class: 'chosen', x: Math.min(sx, px), width: Math.abs(px - sx),
          y: flat ? top : Math.min(sy, py), height: flat ? bottom - top : Math.abs(py - sy),
        }));
      }
      if (place[0] < left || place[0] > right) { this.leave(); return; }
      this.readout.textContent = this.data.square ? this.nearest(px, py) : this.values(x.value(px));
    }

    values(at) {
      const parts = [`${this.data.x_label} ${digits(at)}`];
      for (const curve of this.curves) {
        let best = -1;
        for (let k = 0; k < curve.x.length; k += 1) {
          if (best < 0 || Math.abs(curve.x[k] - at) < Math.abs(curve.x[best] - at)) best = k;
        }
        if (best < 0) continue;
        const edges = curve.band ? ` (${curve.band.map((edge) => digits(edge[best])).join(' .. ')})` : '';
        parts.push(`${curve.label || 'value'} ${digits(curve.y[best])}${edges}`);
      }
      return parts.join('   ');
    }

    // The point of a map that is closest to the pointer.
    nearest(px, py) {
      const [x, y] = this.axes();
      let [best, text] = [20, ''];
      for (const curve of this.curves.filter((own) => own.stroke === 'crosses' || own.stroke === 'rings')) {
        for (let k = 0; k < curve.x.length; k += 1) {
          const far = Math.hypot(x.pixel(curve.x[k]) - px, y.pixel(curve.y[k]) - py);
          if (far >= best) continue;
          best = far;
          const [re, im] = [curve.x[k], curve.y[k]];
          text = `${curve.label}: ${digits(re)} ${im < 0 ? '\u2212' : '+'} ${digits(Math.abs(im))}i, modulus ${digits(Math.hypot(re, im))}`;
        }
      }
      return text;
    }

    leave() {
      if (this.start) return;
      this.over.replaceChildren();
      this.readout.textContent = '';
    }
  }

  const begin = () => {
    for (const figure of document.querySelectorAll('figure')) {
      const numbers = figure.querySelector('script[type="application/json"]');
      if (numbers && figure.querySelector('svg .view')) new Chart(figure, JSON.parse(numbers.textContent));
    }
    for (const hint of document.querySelectorAll('.script[hidden]')) hint.hidden = false;
  };

  // What is printed is the whole, as the page has it without this script.
  addEventListener('beforeprint', () => {
    for (const group of groups.values()) group[0].reset();
    for (const fold of document.querySelectorAll('details')) fold.open = true;
  });
  if (document.readyState === 'loading') addEventListener('DOMContentLoaded', begin);
  else begin();
})();
