// SPDX-License-Identifier: BSD-3-Clause
// The scene on a flat canvas: soil points coloured by a field, structures as they deform, rigid walls, boulders; it
// holds the controls of the view that turns too.
function bytes(text) {
  return Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0)).buffer;
}

// A few colours of the map "viridis" (van der Walt and Smith, 2015), and what lies between.
const MAP = [[68, 1, 84], [59, 82, 139], [33, 145, 140], [94, 201, 98], [253, 231, 37]];
// Those of ColorBrewer's "YlOrRd" (Brewer, 2002), for structures.
const SOLID_MAP = [[255, 255, 204], [254, 217, 118], [253, 141, 60], [227, 26, 28], [128, 0, 38]];
const between = (map) => Array.from({length: 256}, (_, k) => {
  const place = k / 255 * (map.length - 1);
  const first = Math.min(Math.floor(place), map.length - 2);
  return map[first].map((c, n) => Math.round(c + (map[first + 1][n] - c) * (place - first)));
});
const inWords = (mix) => `rgb(${mix.join(",")})`;
const PALETTE = between(MAP).map(inWords);
const SOLID_MIXES = between(SOLID_MAP);
const SOLID_PALETTE = SOLID_MIXES.map(inWords);

const FLOOR = [0.80, 0.77, 0.72];  // colour of walls in scripts/plotting/ground.py

class Scene {
  constructor(section, data) {
    this.data = data;
    this.frame = 0;
    this.field = 0;
    this.solid = data.solids.length ? 0 : -1;  // field of the structures; -1: none, they are grey
    this.timer = null;
    section.hidden = false;
    this.canvas = section.querySelector("canvas.flat");
    const extent = data.high.map((high, k) => high - data.low[k]);
    this.scale = Math.min(1120 / extent[0], 640 / extent[1]);
    this.canvas.width = 1200;
    this.canvas.height = Math.ceil(extent[1] * this.scale) + 90;
    this.soil = data.soil.map((frame) => ({points: new Uint16Array(bytes(frame.points)),
      values: frame.values.map((values) => new Uint8Array(bytes(values)))}));
    this.structures = data.structures.map((each) => ({corners: each.corners, faces: new Uint32Array(bytes(each.faces)),
      front: each.front && new Uint32Array(bytes(each.front)),
      values: (each.values || []).map((fields) => fields.map((text) => text && new Uint8Array(bytes(text)))),
      frames: each.frames.map((frame) => new Uint16Array(bytes(frame)))}));
    this.boulders = data.boulders.map((boulder) => new Boulder(boulder, !data.space));
    this.walls = data.walls.map((wall) => [new Float32Array(bytes(wall.line)), new Float32Array(bytes(wall.strokes))]);
    this.addControls(section.querySelector(".controls"));
    if (data.shown < data.points) {
      html("p", {className: "hint"}, section, `${data.shown} of ${data.points} points are drawn, larger than they are.`);
    }
    this.ground = data.ground ? this.paintGround(data.ground) : null;
    this.space = data.space ? openSpace(this, section) : null;
    document.addEventListener("time", (event) => this.show(nearest(data.times, event.detail), false));
    this.show(data.times.length - 1, false);
  }

  addControls(controls) {
    this.play = html("button", {type: "button", onclick: () => this.toggle()}, controls, "play");
    this.slider = html("input", {type: "range", min: 0, max: this.data.times.length - 1}, controls);
    this.slider.setAttribute("aria-label", "time");
    this.slider.addEventListener("input", () => this.show(Number(this.slider.value), true));
    this.text = html("span", {className: "readout"}, controls);
    this.addChoice(controls, "soil", this.data.fields, (k) => { this.field = k; });
    const choice = this.addChoice(controls, "structure", this.data.solids, (k) => { this.solid = k; });
    if (choice) html("option", {value: -1}, choice, "structure in grey");
  }

  // What colours the soil or the structures; null where there is nothing to choose.
  addChoice(controls, name, fields, choose) {
    if (!fields.length) return null;
    const choice = html("select", {id: `colour-${name}`}, controls);
    choice.setAttribute("aria-label", `colour of the ${name}`);
    fields.forEach((field, k) => html("option", {value: k}, choice, field.label));
    choice.addEventListener("change", () => {
      choose(Number(choice.value));
      this.draw();
    });
    return choice;
  }

  // Numbers from 0 to 255 of the faces of a structure; null: it is grey.
  valuesOf(structure) {
    return this.solid >= 0 && structure.values.length ? structure.values[this.frame][this.solid] : null;
  }

  toggle() {
    if (this.timer) {
      clearInterval(this.timer);
      this.timer = null;
    } else {
      this.timer = setInterval(() => this.show((this.frame + 1) % this.data.times.length, true), 90);
    }
    this.play.textContent = this.timer ? "stop" : "play";
  }

  show(frame, tell) {
    this.frame = frame;
    this.slider.value = frame;
    this.text.textContent = `t = ${digits(this.data.times[frame])} s`;
    if (tell) for (const chart of Scene.charts) chart.mark(this.data.times[frame]);
    this.draw();
  }

  pixel(across, up) {
    const y = up * this.scale;
    return [40 + across * this.scale, this.data.inverted ? 10 + y : this.canvas.height - 80 - y];
  }

  // Pixel of place k of points in the box of the data, which have as many coordinates as it has.
  place(points, k) {
    const {box: [low, high], low: corner} = this.data;
    const at = (axis) => low[axis] + points[low.length * k + axis] / 65535 * (high[axis] - low[axis]);
    return this.pixel(at(this.data.across) - corner[0], at(this.data.up) - corner[1]);
  }

  draw() {
    if (this.space && this.space.shown) {
      this.space.draw();
      return;
    }
    const pen = this.canvas.getContext("2d");
    pen.clearRect(0, 0, this.canvas.width, this.canvas.height);
    if (this.ground) pen.drawImage(this.ground, 0, 0);
    this.drawSoil(pen);
    for (const structure of this.structures) this.drawStructure(pen, structure);
    for (const number of this.data.standing[this.frame]) this.drawWall(pen, ...this.walls[number]);
    this.drawBoulders(pen);
    this.drawScales(pen);
    this.canvas.dataset.drawn = this.frame;
  }

  // The ground does not move: it is painted once.
  paintGround(ground) {
    const canvas = document.createElement("canvas");
    [canvas.width, canvas.height] = [this.canvas.width, this.canvas.height];
    const pen = canvas.getContext("2d");
    const corners = new Int32Array(bytes(ground.corners));
    const span = this.data.high.map((high, k) => (high - this.data.low[k]) / 65535);
    new Uint8Array(bytes(ground.bright)).forEach((bright, k) => {
      pen.fillStyle = pen.strokeStyle = colourText(FLOOR, bright / 255);
      pen.beginPath();
      for (let c = 0; c < 3; ++c) {
        pen.lineTo(...this.pixel(corners[6 * k + 2 * c] * span[0], corners[6 * k + 2 * c + 1] * span[1]));
      }
      pen.closePath();
      pen.fill();
      pen.stroke();
    });
    const [left, top] = this.pixel(0, this.data.inverted ? 0 : this.data.high[1] - this.data.low[1]);
    const window = document.createElement("canvas");
    [window.width, window.height] = [canvas.width, canvas.height];
    const size = this.data.high.map((high, k) => (high - this.data.low[k]) * this.scale);
    window.getContext("2d").drawImage(canvas, left, top, ...size, left, top, ...size);
    return window;
  }

  drawSoil(pen) {
    const frame = this.soil[this.frame];
    if (!frame) return;
    const size = Math.max(1.5, 1.05 * this.data.size * this.scale);
    const values = frame.values[this.field];
    for (let k = 0; this.data.box[0].length * k < frame.points.length; ++k) {
      const [x, y] = this.place(frame.points, k);
      pen.fillStyle = PALETTE[values ? values[k] : 128];
      pen.fillRect(x - size / 2, y - size / 2, size, size);
    }
  }

  drawStructure(pen, structure) {
    const points = structure.frames[this.frame];
    pen.fillStyle = "#bdbdbd";
    pen.strokeStyle = "#4d4d4d";
    pen.lineWidth = 0.5;
    const values = this.valuesOf(structure);
    const count = structure.front ? structure.front.length : structure.faces.length / structure.corners;
    for (let k = 0; k < count; ++k) {
      const face = structure.front ? structure.front[k] : k;
      const f = structure.corners * face;
      if (values) pen.fillStyle = SOLID_PALETTE[values[face]];
      pen.beginPath();
      for (let c = 0; c < structure.corners; ++c) pen.lineTo(...this.place(points, structure.faces[f + c]));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
  }

  drawBoulders(pen) {
    const [left, low] = this.data.low;
    pen.lineWidth = 0.5;
    for (const face of facesOf(this.boulders, this.frame, [this.data.across, this.data.up], this.data.inverted)) {
      pen.fillStyle = colourText(BOULDER, face.bright);
      pen.strokeStyle = face.edge || pen.fillStyle;
      pen.beginPath();
      for (const [across, up] of face.corners) pen.lineTo(...this.pixel(across - left, up - low));
      pen.closePath();
      pen.fill();
      pen.stroke();
    }
  }

  drawWall(pen, line, strokes) {
    const [low, high] = [this.data.low, this.data.high];
    pen.save();
    pen.beginPath();
    const [left, floor] = this.pixel(0, this.data.inverted ? high[1] - low[1] : 0);
    const height = (high[1] - low[1]) * this.scale;
    pen.rect(left, floor - height, (high[0] - low[0]) * this.scale, height);
    pen.clip();  // beds are longer than the picture
    pen.strokeStyle = getComputedStyle(document.body).color;
    for (const [ends, width] of [[line, 2], [strokes, 0.8]]) {
      pen.lineWidth = width;
      pen.beginPath();
      for (let k = 0; k < ends.length; k += 4) {
        pen.moveTo(...this.pixel(ends[k] - low[0], ends[k + 1] - low[1]));
        pen.lineTo(...this.pixel(ends[k + 2] - low[0], ends[k + 3] - low[1]));
      }
      pen.stroke();
    }
    pen.restore();
  }

  drawScales(pen) {
    const ink = getComputedStyle(document.body).color;
    const floor = this.canvas.height - 80;
    pen.fillStyle = pen.strokeStyle = ink;
    pen.lineWidth = 1;
    pen.font = "15px system-ui, sans-serif";
    for (const x of ticks(this.data.low[0], this.data.high[0], 8)) {
      const pixel = 40 + (x - this.data.low[0]) * this.scale;
      if (pixel > 1100) continue;  // the name of the axis stands there
      pen.fillRect(pixel, floor, 1, 6);
      pen.fillText(digits(x), pixel - 8, floor + 22);
    }
    pen.fillText(this.data.labels[0], 1140, floor + 22);
    this.drawColours(pen, 40, floor + 34, 24);
  }

  // The bars of colours with their fields, from a pixel to the right; that of structures `below` it.
  drawColours(pen, x, y, below) {
    this.drawBar(pen, x, y, PALETTE, this.data.fields[this.field]);
    this.drawBar(pen, x, y + below, SOLID_PALETTE, this.data.solids[this.solid]);
  }

  drawBar(pen, x, y, palette, field) {
    if (!field) return;
    palette.forEach((colour, k) => {
      pen.fillStyle = colour;
      pen.fillRect(x + k, y, Math.min(2, palette.length - k), 12);  // no seams where it is drawn smaller
    });
    pen.fillStyle = getComputedStyle(document.body).color;
    pen.fillText(`${digits(field.low)} to ${digits(field.high)}: ${field.label}`, x + 270, y + 12);
  }
}
Scene.charts = [];
