// SPDX-License-Identifier: BSD-3-Clause
// Turns, zooms and moves a camera about a place, by mouse, touch and keys.
const TURN = 0.008;  // radians a pixel
const STEEPEST = 1.55;  // radians above or below the horizon

class Orbit {
  // axes: unit vectors (right, up, eye) of the first look; centre and radius of the sphere that it shows.
  // moved: called after each change.
  constructor(canvas, axes, sphere, moved) {
    Object.assign(this, {canvas, axes, sphere, moved});
    this.pointers = new Map();
    this.reset();
    canvas.addEventListener("pointerdown", (event) => this.press(event));
    canvas.addEventListener("pointermove", (event) => this.drag(event));
    for (const end of ["pointerup", "pointercancel"]) {
      canvas.addEventListener(end, (event) => this.pointers.delete(event.pointerId));
    }
    canvas.addEventListener("contextmenu", (event) => event.preventDefault());
    canvas.addEventListener("wheel", (event) => this.wheel(event), {passive: false});
    canvas.addEventListener("keydown", (event) => this.key(event));
  }

  reset() {
    [this.azimuth, this.elevation, this.zoom] = [0.5, 0.6, 1];
    this.target = [...this.sphere.centre];
    this.moved();
  }

  // Unit vectors of the present look, and the place of the eye at a distance [m].
  look() {
    const {right: along, up: vertical, eye: level} = this.axes;
    const [a, e] = [this.azimuth, this.elevation];
    const eye = along.map((x, k) => Math.cos(e) * (Math.cos(a) * level[k] - Math.sin(a) * x)
      + Math.sin(e) * vertical[k]);
    const right = along.map((x, k) => Math.cos(a) * x + Math.sin(a) * level[k]);
    return {right, eye, up: cross(eye, right)};
  }

  turn(across, up) {
    this.azimuth += TURN * across;
    this.elevation = Math.max(-STEEPEST, Math.min(STEEPEST, this.elevation + TURN * up));
    this.moved();
  }

  // Moves the scene by pixels to the right and downwards.
  pan(across, down) {
    const {right, up} = this.look();
    const metres = 2 * this.sphere.radius / this.zoom / Math.max(1, this.canvas.clientHeight);
    this.target = this.target.map((x, k) => x + metres * (down * up[k] - across * right[k]));
    this.moved();
  }

  enlarge(factor) {
    this.zoom = Math.max(0.1, Math.min(100, this.zoom * factor));
    this.moved();
  }

  press(event) {
    this.pointers.set(event.pointerId, [event.clientX, event.clientY]);
    if (event.isTrusted) this.canvas.setPointerCapture(event.pointerId);
    this.canvas.focus({preventScroll: true});
  }

  drag(event) {
    const before = this.pointers.get(event.pointerId);
    if (!before) return;
    const now = [event.clientX, event.clientY];
    const [across, down] = now.map((x, k) => x - before[k]);
    const other = [...this.pointers].find(([id]) => id !== event.pointerId);
    this.pointers.set(event.pointerId, now);
    if (other) {
      const apart = (place) => Math.max(1, Math.hypot(place[0] - other[1][0], place[1] - other[1][1]));
      this.enlarge(apart(now) / apart(before));
      this.pan(across / 2, down / 2);  // each of two fingers moves the middle by half
    } else if (event.shiftKey || event.buttons & 6) {
      this.pan(across, down);
    } else {
      this.turn(across, down);
    }
  }

  // A wheel scrolls the page until the picture has been pressed.
  wheel(event) {
    if (document.activeElement !== this.canvas) return;
    event.preventDefault();
    this.enlarge(Math.exp(-0.0015 * event.deltaY * (event.deltaMode ? 30 : 1)));
  }

  key(event) {
    if (event.ctrlKey || event.altKey || event.metaKey) return;
    const arrows = {ArrowLeft: [-15, 0], ArrowRight: [15, 0], ArrowUp: [0, -15], ArrowDown: [0, 15]};
    const arrow = arrows[event.key];
    if (arrow) event.shiftKey ? this.pan(...arrow) : this.turn(...arrow);
    else if (event.key === "+" || event.key === "=") this.enlarge(1.15);
    else if (event.key === "-") this.enlarge(1 / 1.15);
    else if (event.key === "0" || event.key === "Home") this.reset();
    else return;
    event.preventDefault();
  }
}
