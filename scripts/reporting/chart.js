// SPDX-License-Identifier: BSD-3-Clause
// A chart of curves in SVG: hide a curve, enlarge a range, read off values.
const COLOURS = ["#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#888888"];
const DASHES = ["", "6 3", "2 2"];
const STYLES = ["solid", "dashed", "dotted"]; // the same in a legend
const SVG = document.querySelector("svg").namespaceURI;

function element(name, attributes = {}, parent = null) {
  const made = document.createElementNS(SVG, name);
  for (const key in attributes) made.setAttribute(key, attributes[key]);
  if (parent) parent.appendChild(made);
  return made;
}

function html(name, attributes = {}, parent = null, text = "") {
  const made = document.createElement(name);
  Object.assign(made, attributes);
  if (text) made.textContent = text;
  if (parent) parent.appendChild(made);
  return made;
}

function save(name, text) {
  const link = html("a", {href: URL.createObjectURL(new Blob([text])), download: name});
  link.click();
  URL.revokeObjectURL(link.href);
}

const digits = (value) => value === null || value === undefined ? "–" : String(Number(value.toPrecision(4)));

function ticks(low, high, count) {
  const raw = (high - low) / count;
  const power = 10 ** Math.floor(Math.log10(raw));
  const step = [1, 2, 5, 10].map((k) => k * power).find((s) => s >= raw);
  const found = [];
  for (let k = Math.ceil(low / step - 1e-9); k * step <= high + 1e-9 * step; ++k) found.push(k * step);
  return found;
}

// Logarithms of what is marked: powers of ten, and 2 and 5 times these where few are seen.
function decades(low, high) {
  const step = Math.max(1, Math.ceil((high - low) / 6));
  const parts = high - low < 2 ? [1, 2, 5] : [1];
  const found = [];
  for (let k = Math.floor(low); k <= high; k += step) found.push(...parts.map((part) => k + Math.log10(part)));
  return found.filter((mark) => mark >= low && mark <= high);
}

class Chart {
  // spec: name, title, curves [{name, x, y, dots}], log, floor, label of the horizontal axis,
  // whole (numbers along it), followsTime
  constructor(host, spec) {
    this.spec = spec;
    this.width = 900;
    this.height = 240;
    const narrow = window.matchMedia("(max-width: 40rem)").matches; // the text is larger there
    this.left = narrow ? 130 : 70;
    this.bottom = narrow ? 60 : 34;
    this.marks = narrow ? 4 : 8;
    this.line = narrow ? 24 : 15; // of text below the axis
    this.hidden = new Set();
    this.range = null;
    const box = html("div", {className: "chart", id: "chart-" + spec.name}, host);
    const title = html("h3", {}, box, spec.title + " ");
    const button = html("button", {type: "button", className: "csv"}, title, "CSV");
    button.onclick = () => save(spec.name + ".csv", this.csv());
    if (spec.hint) html("p", {className: "hint"}, box, spec.hint);
    this.svg = element("svg", {viewBox: `0 0 ${this.width} ${this.height}`, role: "img"}, box);
    this.legend = html("div", {className: "legend"}, box);
    this.listen();
    this.draw();
  }

  set(curves) {
    this.spec.curves = curves;
    this.range = null;
    this.draw();
  }

  // A row a point: curves need not have the same places.
  csv() {
    const quoted = (text) => `"${text.replaceAll('"', '""')}"`;
    const rows = [["curve", quoted(this.spec.label || "time [s]"), quoted(this.spec.title)].join(",")];
    for (const curve of this.spec.curves) {
      curve.x.forEach((x, k) => rows.push([quoted(curve.name), x ?? "", curve.y[k] ?? ""].join(",")));
    }
    return rows.join("\n") + "\n";
  }

  shown() {
    return this.spec.curves.filter((curve) => !this.hidden.has(curve.name));
  }

  up(value) {
    return this.spec.log ? (value > 0 ? Math.log10(value) : null) : value;
  }

  scales() {
    let [x0, x1, y0, y1] = [Infinity, -Infinity, Infinity, -Infinity];
    for (const curve of this.shown()) {
      curve.x.forEach((x, k) => {
        if (x === null || (this.range && (x < this.range[0] || x > this.range[1]))) return;
        x0 = Math.min(x0, x);
        x1 = Math.max(x1, x);
        const y = curve.y[k] === null ? null : this.up(curve.y[k]);
        if (y === null) return;
        y0 = Math.min(y0, y);
        y1 = Math.max(y1, y);
      });
    }
    if (this.range) [x0, x1] = this.range;
    if (!(x1 >= x0)) [x0, x1] = [0, 1];
    if (!(y1 >= y0)) [y0, y1] = [0, 1];
    if (this.spec.floor !== undefined && !this.spec.log) y0 = Math.min(y0, this.spec.floor);
    if (x1 === x0) [x0, x1] = [x0 - 0.5, x1 + 0.5];
    const margin = y1 > y0 ? 0.05 * (y1 - y0) : (this.spec.log ? 0.5 : Math.abs(y0) * 0.1 || 1);
    [y0, y1] = [y0 - margin, y1 + margin];
    this.x = (x) => this.left + (x - x0) / (x1 - x0) * (this.width - this.left - 12);
    this.y = (y) => 10 + (y1 - y) / (y1 - y0) * (this.height - this.bottom - 10);
    this.back = (pixel) => x0 + (pixel - this.left) / (this.width - this.left - 12) * (x1 - x0);
    return [x0, x1, y0, y1];
  }

  draw() {
    const [x0, x1, y0, y1] = this.scales();
    this.svg.replaceChildren();
    const floor = this.height - this.bottom;
    for (const x of ticks(x0, x1, this.marks).filter((tick) => !this.spec.whole || Number.isInteger(tick))) {
      element("line", {class: "axis", x1: this.x(x), x2: this.x(x), y1: 10, y2: floor}, this.svg);
      element("text", {x: this.x(x), y: floor + this.line, "text-anchor": "middle"}, this.svg).textContent = digits(x);
    }
    const marks = this.spec.log ? decades(y0, y1) : ticks(y0, y1, 5);
    for (const y of marks) {
      element("line", {class: "axis", x1: this.left, x2: this.width - 12, y1: this.y(y), y2: this.y(y)}, this.svg);
      element("text", {x: this.left - 6, y: this.y(y) + 4, "text-anchor": "end"}, this.svg).textContent =
        this.spec.log ? (10 ** y).toExponential(0) : digits(y);
    }
    element("text", {x: this.width - 12, y: floor + 2 * this.line, "text-anchor": "end"}, this.svg).textContent =
      this.spec.label || "time [s]";
    this.spec.curves.forEach((curve, k) => this.drawCurve(curve, k));
    this.cursor = element("line", {class: "cursor", y1: 10, y2: floor, visibility: "hidden"}, this.svg);
    this.drawLegend();
  }

  drawCurve(curve, k) {
    if (this.hidden.has(curve.name)) return;
    const colour = COLOURS[k % COLOURS.length];
    let path = "";
    let pen = false;
    curve.x.forEach((x, n) => {
      const y = curve.y[n] === null || x === null ? null : this.up(curve.y[n]);
      const inside = y !== null && (!this.range || (x >= this.range[0] && x <= this.range[1]));
      if (inside) path += `${pen ? "L" : "M"}${this.x(x).toFixed(1)} ${this.y(y).toFixed(1)}`;
      if (inside && curve.dots) element("circle", {class: "dots", cx: this.x(x), cy: this.y(y), r: 3, fill: colour}, this.svg);
      pen = inside;
    });
    const dash = DASHES[Math.floor(k / COLOURS.length) % DASHES.length];
    element("path", {class: "curve", d: path || "M0 0", stroke: colour, "stroke-dasharray": dash, "data-curve": curve.name}, this.svg);
  }

  drawLegend(time = null) {
    this.legend.replaceChildren();
    this.spec.curves.forEach((curve, k) => {
      const button = html("button", {type: "button", className: this.hidden.has(curve.name) ? "off" : ""}, this.legend);
      const style = STYLES[Math.floor(k / COLOURS.length) % STYLES.length];
      html("i", {}, button).style.borderTop = `3px ${style} ${COLOURS[k % COLOURS.length]}`;
      const value = time === null ? "" : " " + digits(curve.y[nearest(curve.x, time)]);
      button.append(curve.name + value);
      button.onclick = () => {
        this.hidden.has(curve.name) ? this.hidden.delete(curve.name) : this.hidden.add(curve.name);
        this.draw();
      };
    });
    if (time !== null) html("span", {className: "readout"}, this.legend, `at ${digits(time)}`);
  }

  mark(time) {
    const pixel = this.x(time);
    const inside = pixel >= this.left && pixel <= this.width - 12;
    this.cursor.setAttribute("visibility", inside ? "visible" : "hidden");
    for (const end of ["x1", "x2"]) this.cursor.setAttribute(end, pixel);
    this.drawLegend(time);
  }

  listen() {
    const place = (event) => {
      const box = this.svg.getBoundingClientRect();
      return this.back((event.clientX - box.left) / box.width * this.width);
    };
    let from = null;
    let shade = null;
    this.svg.addEventListener("pointerdown", (event) => {
      from = place(event);
      shade = element("rect", {class: "drag", y: 10, height: this.height - this.bottom - 10, width: 0}, this.svg);
    });
    this.svg.addEventListener("pointermove", (event) => {
      const here = place(event);
      this.mark(here);
      if (this.spec.followsTime) document.dispatchEvent(new CustomEvent("time", {detail: here}));
      if (from === null) return;
      shade.setAttribute("x", Math.min(this.x(from), this.x(here)));
      shade.setAttribute("width", Math.abs(this.x(here) - this.x(from)));
    });
    window.addEventListener("pointerup", (event) => {
      if (from === null) return;
      const ends = [from, place(event)].sort((a, b) => a - b);
      from = null;
      shade.remove();
      if (this.x(ends[1]) - this.x(ends[0]) < 6) return;
      this.range = ends;
      this.draw();
    });
    this.svg.addEventListener("dblclick", () => {
      this.range = null;
      this.draw();
    });
  }
}

function nearest(sorted, value) {
  let best = 0;
  sorted.forEach((x, k) => {
    if (x !== null && Math.abs(x - value) < Math.abs(sorted[best] - value)) best = k;
  });
  return best;
}
