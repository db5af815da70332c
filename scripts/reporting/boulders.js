// SPDX-License-Identifier: BSD-3-Clause
// Boulders, as scripts/reporting/rigid.py packs them, and their picture on the flat canvas.
const BOULDER = [0.55, 0.5, 0.46];

class Boulder {
  constructor(packed, flat) {
    this.flat = flat;
    this.corners = packed.corners;
    this.faces = new (packed.wide ? Uint32Array : Uint16Array)(bytes(packed.faces));
    this.points = Float32Array.from(new Int16Array(bytes(packed.points)), (part) => part / 32767 * packed.radius);
    this.poses = new Float32Array(bytes(packed.poses));
  }

  // Three coordinates of each node in a frame.
  at(frame) {
    const pose = this.poses.subarray(12 * frame, 12 * frame + 12);
    const places = new Float64Array(this.points.length);
    for (let k = 0; k < places.length; k += 3) {
      for (let r = 0; r < 3; ++r) {
        places[k + r] = pose[9 + r];
        for (let c = 0; c < 3; ++c) places[k + r] += pose[3 * r + c] * this.points[k + c];
      }
    }
    return places;
  }
}

// Faces of all boulders, those behind first, without those that are turned away; axes: numbers of the axes to the right and upwards.
// Each face: its corners, [across, up] in metres, the colour of its edge, null as inside, and how bright it is.
function facesOf(boulders, frame, axes, inverted) {
  const [across, up] = axes;
  const depth = 3 - across - up;
  const towards = ((up - across + 3) % 3 === 1 ? 1 : -1) * (inverted ? -1 : 1);
  const faces = [];
  for (const boulder of boulders) {
    const places = boulder.at(frame);
    for (let f = 0; f < boulder.faces.length; f += boulder.corners) {
      const nodes = [...boulder.faces.subarray(f, f + boulder.corners)];
      const corner = (k) => [0, 1, 2].map((axis) => places[3 * nodes[k] + axis]);
      const [a, b, c] = [corner(0), corner(1), corner(2)];
      const normal = cross(b.map((x, k) => x - a[k]), c.map((x, k) => x - a[k]));
      if (!boulder.flat && towards * normal[depth] <= 0) continue;
      faces.push({corners: nodes.map((node) => [places[3 * node + across], places[3 * node + up]]),
        depth: towards * nodes.reduce((sum, node) => sum + places[3 * node + depth], 0) / nodes.length,
        edge: boulder.flat ? "#4d4d4d" : null, bright: 0.6 + 0.4 * Math.abs(normal[depth]) / (Math.hypot(...normal) || 1)});
    }
  }
  return faces.sort((one, other) => one.depth - other.depth);
}

function cross(a, b) {
  return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
}

function colourText(colour, bright) {
  return `rgb(${colour.map((c) => Math.round(255 * c * bright)).join(",")})`;
}
