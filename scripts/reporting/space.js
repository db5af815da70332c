// SPDX-License-Identifier: BSD-3-Clause
// The scene in space, drawn by three.js: soil points as spheres, structures, boulders and rigid walls as shaded surfaces.
const FIELD_OF_VIEW = 30;  // degrees
const STEEL = [0.45, 0.52, 0.60];
const HINT = "Drag to turn, with Shift, the right button or two fingers to move, pinch or use the wheel after a click "
  + "to zoom; arrow keys turn, with Shift they move, + and - zoom, 0 goes back.";

const BALL_VERTEX = `
  attribute float value;
  uniform float size;
  uniform float pixels;
  varying float share;
  void main() {
    vec4 place = modelViewMatrix * vec4(position, 1.0);
    gl_Position = projectionMatrix * place;
    gl_PointSize = max(1.5, size * pixels / -place.z);
    share = value;
  }`;
const BALL_FRAGMENT = `
  uniform vec3 palette[${MAP.length}];
  varying float share;
  void main() {
    vec2 at = 2.0 * gl_PointCoord - 1.0;
    float beyond = 1.0 - dot(at, at);
    if (beyond < 0.0) discard;
    vec3 colour = palette[0];
    for (int k = 1; k < ${MAP.length}; ++k) {
      colour = mix(colour, palette[k], clamp(share * ${MAP.length - 1}.0 - float(k - 1), 0.0, 1.0));
    }
    float light = dot(vec3(at.x, -at.y, sqrt(beyond)), normalize(vec3(-0.5, 0.8, 0.8)));
    gl_FragColor = vec4(colour * (0.72 + 0.28 * max(light, 0.0)), 1.0);
  }`;

function hasWebGL() {
  try {
    return Boolean(document.createElement("canvas").getContext("webgl"));
  } catch {
    return false;
  }
}

// The view that turns; null, with a sentence on the page, where it cannot be drawn.
function openSpace(scene, section) {
  let lacking = "";
  if (typeof THREE === "undefined") {
    lacking = "A view that turns comes with Debian's package libjs-three: install it and write this page once more.";
  } else if (!hasWebGL()) {
    lacking = "The view that turns needs WebGL, which this browser does not have; the flat view is shown.";
  } else {
    return new Space(scene, section);
  }
  html("p", {className: "hint", id: "space-lacking"}, section, lacking);
  return null;
}

class Space {
  constructor(scene, section) {
    this.scene = scene;
    this.data = scene.data.space;
    this.shown = true;
    const {low, high} = this.data;
    this.sphere = {centre: low.map((x, k) => (x + high[k]) / 2),
      radius: 0.5 * Math.hypot(...low.map((x, k) => high[k] - x)) || 1};
    this.addElements(section);
    this.renderer = new THREE.WebGLRenderer({canvas: this.canvas, antialias: true, alpha: true});
    this.canvas.addEventListener("webglcontextlost", () => this.toggle(false));
    this.camera = new THREE.PerspectiveCamera(FIELD_OF_VIEW, 1, 0.01 * this.sphere.radius, 1000 * this.sphere.radius);
    this.root = new THREE.Scene();
    this.addLights();
    this.addSoil();
    this.structures = scene.structures.map((each) => this.addStructure(each));
    this.boulders = scene.boulders.map((each) => this.addBoulder(each));
    this.undersides = [];
    this.walls = this.data.walls.map((each) => this.addWall(each));
    this.orbit = new Orbit(this.canvas, this.data, this.sphere, () => this.orbit && this.draw());
    window.addEventListener("resize", () => this.draw());
    this.toggle(true);
  }

  addElements(section) {
    this.holder = html("div", {className: "space"});
    this.scene.canvas.after(this.holder);
    this.canvas = html("canvas", {tabIndex: 0, id: "space"}, this.holder);
    this.canvas.setAttribute("aria-label", "scene in space");
    this.over = html("canvas", {className: "over"}, this.holder);
    const controls = section.querySelector(".controls");
    this.button = html("button", {type: "button", id: "space-toggle", onclick: () => this.toggle(!this.shown)},
      controls);
    this.back = html("button", {type: "button", id: "space-reset", onclick: () => this.orbit.reset()}, controls,
      "reset view");
    this.hint = html("p", {className: "hint"}, section, HINT);
  }

  toggle(shown) {
    this.shown = shown;
    this.button.textContent = shown ? "flat view" : "view that turns";
    this.scene.canvas.hidden = shown;
    for (const element of [this.holder, this.back, this.hint]) element.hidden = !shown;
    if (this.scene.slider) this.scene.draw();
  }

  addLights() {
    this.root.add(new THREE.AmbientLight(0xffffff, 0.55));
    this.lamp = new THREE.DirectionalLight(0xffffff, 0.6);
    this.root.add(this.lamp, this.lamp.target);
  }

  // Places of the data stay 16-bit numbers: the object has the box as its scale. All is drawn about the sphere's centre.
  inBox(object, low, high) {
    object.scale.set(...low.map((x, k) => high[k] - x || 1e-12));
    object.position.set(...low.map((x, k) => x - this.sphere.centre[k]));
    object.frustumCulled = false;
    this.root.add(object);
    return object;
  }

  addSoil() {
    const frames = this.scene.soil;
    if (!frames.length) return;
    const most = Math.max(...frames.map((frame) => frame.points.length / 3));
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Uint16Array(3 * most), 3, true));
    geometry.setAttribute("value", new THREE.BufferAttribute(new Uint8Array(most).fill(128), 1, true));
    const palette = MAP.map((colour) => new THREE.Vector3(...colour.map((c) => c / 255)));
    const material = new THREE.ShaderMaterial({vertexShader: BALL_VERTEX, fragmentShader: BALL_FRAGMENT,
      uniforms: {size: {value: 1.25 * this.data.size}, pixels: {value: 1}, palette: {value: palette}}});
    this.soil = this.inBox(new THREE.Points(geometry, material), ...this.scene.data.box);
  }

  surface(geometry, colour, side) {
    return new THREE.Mesh(geometry, new THREE.MeshPhongMaterial({color: new THREE.Color(...colour), flatShading: true,
      shininess: 0, side}));
  }

  // A structure with values on its faces has corners of its own for each triangle: a face has one colour.
  addColoured(structure) {
    const corners = fans(structure.faces, structure.corners);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Uint16Array(3 * corners.length), 3, true));
    geometry.setAttribute("color", new THREE.BufferAttribute(new Uint8Array(3 * corners.length), 3, true));
    const object = this.surface(geometry, [1, 1, 1], THREE.DoubleSide);
    object.material.vertexColors = THREE.VertexColors || true;  // a number in releases before 114
    this.inBox(object, ...this.scene.data.box);
    return Object.assign(object, {corners, trianglesOfFace: structure.corners - 2});
  }

  setColoured(object, structure, frame) {
    const {position, color} = object.geometry.attributes;
    const places = structure.frames[frame];
    const values = this.scene.valuesOf(structure);
    const steel = STEEL.map((c) => 255 * c);
    object.corners.forEach((node, k) => {
      const face = Math.floor(k / (3 * object.trianglesOfFace));
      const mix = values ? SOLID_MIXES[values[face]] : steel;
      for (let n = 0; n < 3; ++n) {
        position.array[3 * k + n] = places[3 * node + n];
        color.array[3 * k + n] = mix[n];
      }
    });
    position.needsUpdate = color.needsUpdate = true;
  }

  addStructure(structure) {
    if (structure.values.length && structure.corners > 2) return this.addColoured(structure);
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(structure.frames[0].slice(), 3, true));
    const lines = structure.corners === 2;  // ropes and beams
    geometry.setIndex(lines ? [...structure.faces] : fans(structure.faces, structure.corners));
    const object = lines ? new THREE.LineSegments(geometry, new THREE.LineBasicMaterial({color: 0x4d4d4d}))
      : this.surface(geometry, STEEL, THREE.DoubleSide);
    return this.inBox(object, ...this.scene.data.box);
  }

  addBoulder(boulder) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(boulder.points, 3));
    geometry.setIndex(fans(boulder.faces, boulder.corners));
    const object = this.surface(geometry, BOULDER, THREE.DoubleSide);
    object.frustumCulled = false;
    object.matrixAutoUpdate = false;
    this.root.add(object);
    return {object, poses: boulder.poses};
  }

  // Walls are seen from the side of the soil alone: one between the eye and the soil does not hide it. Ground does.
  addWall(packed) {
    const geometry = new THREE.BufferGeometry();
    geometry.setAttribute("position", new THREE.BufferAttribute(new Uint16Array(bytes(packed.corners)), 3, true));
    const object = this.surface(geometry, FLOOR, THREE.FrontSide);
    if (packed.ground) object.add(this.underside(geometry));
    this.inBox(object, packed.low, packed.high);
    if (!packed.poses) return {object, until: packed.until};
    const group = new THREE.Group();
    object.position.set(...packed.low);
    group.matrixAutoUpdate = false;
    group.add(object);
    this.root.add(group);
    return {object: group, poses: new Float32Array(bytes(packed.poses)), until: packed.until};
  }

  // The ground from below. Spheres of the lowest points reach through it: it is drawn nearer by their size, see setCamera.
  underside(geometry) {
    const object = this.surface(geometry, FLOOR, THREE.BackSide);
    object.material.polygonOffset = true;
    object.frustumCulled = false;
    this.undersides.push(object.material);
    return object;
  }

  setPose({object, poses}, frame) {
    const p = poses.subarray(12 * frame, 12 * frame + 12);
    const c = this.sphere.centre;
    object.matrix.set(p[0], p[1], p[2], p[9] - c[0], p[3], p[4], p[5], p[10] - c[1],
      p[6], p[7], p[8], p[11] - c[2], 0, 0, 0, 1);
    object.matrixWorldNeedsUpdate = true;
  }

  setFrame(frame) {
    const soil = this.scene.soil[frame];
    if (soil) {
      const {position, value} = this.soil.geometry.attributes;
      position.array.set(soil.points);
      const values = soil.values[this.scene.field];
      if (values) value.array.set(values);
      position.needsUpdate = value.needsUpdate = true;
      this.soil.geometry.setDrawRange(0, soil.points.length / 3);
    }
    this.structures.forEach((object, k) => {
      if (object.corners) {
        this.setColoured(object, this.scene.structures[k], frame);
        return;
      }
      object.geometry.attributes.position.array.set(this.scene.structures[k].frames[frame]);
      object.geometry.attributes.position.needsUpdate = true;
    });
    for (const boulder of this.boulders) this.setPose(boulder, frame);
    for (const wall of this.walls) {
      wall.object.visible = wall.until === null || this.scene.data.times[frame] <= wall.until;
      if (wall.poses) this.setPose(wall, frame);
    }
  }

  setCamera(width, height) {
    const {right, up, eye} = this.orbit.look();
    const half = Math.tan(FIELD_OF_VIEW * Math.PI / 360);
    const distance = 1.02 * this.sphere.radius / (half * Math.min(1, width / height) * this.orbit.zoom);
    const target = this.orbit.target.map((x, k) => x - this.sphere.centre[k]);
    this.camera.position.set(...target.map((x, k) => x + distance * eye[k]));
    this.camera.up.set(...up);
    this.camera.lookAt(...target);
    [this.camera.aspect, this.camera.near] = [width / height, 0.01 * distance];
    this.camera.far = distance + 50 * this.sphere.radius;
    this.camera.updateProjectionMatrix();
    const lamp = eye.map((x, k) => x + 1.2 * up[k] - 0.7 * right[k]);
    this.lamp.position.set(...lamp);
    if (!this.soil) return;
    const {size, pixels} = this.soil.material.uniforms;
    pixels.value = this.canvas.height / (2 * half);
    for (const material of this.undersides) material.polygonOffsetFactor = -size.value * pixels.value / distance;
  }

  draw() {
    if (!this.shown) return;
    const width = this.holder.clientWidth || 600;
    const height = Math.round(width * (width < 600 ? 1 : 0.6));
    if (this.size !== `${width} ${height}`) {
      this.size = `${width} ${height}`;
      this.renderer.setPixelRatio(Math.min(2, window.devicePixelRatio || 1));
      this.renderer.setSize(width, height);
    }
    this.setFrame(this.scene.frame);
    this.setCamera(width, height);
    this.renderer.render(this.root, this.camera);
    this.drawOver(width, height);
    this.canvas.dataset.drawn = this.scene.frame;
  }

  // Directions of the axes, and the bar of colours, over the picture.
  drawOver(width, height) {
    const ratio = Math.min(2, window.devicePixelRatio || 1);
    [this.over.width, this.over.height] = [width * ratio, height * ratio];
    const pen = this.over.getContext("2d");
    pen.scale(ratio, ratio);
    pen.font = "14px system-ui, sans-serif";
    const {right, up, eye} = this.orbit.look();
    const axes = ["x", "y", "z"].map((name, k) => ({name, colour: ["#d55e00", "#009e73", "#0072b2"][k],
      across: 34 * right[k], up: 34 * up[k], depth: eye[k]})).sort((one, other) => one.depth - other.depth);
    const [x, y] = [50, height - 74];
    pen.lineWidth = 2;
    for (const axis of axes) {
      pen.strokeStyle = pen.fillStyle = axis.colour;
      pen.beginPath();
      pen.moveTo(x, y);
      pen.lineTo(x + axis.across, y - axis.up);
      pen.stroke();
      pen.fillText(axis.name, x + 1.3 * axis.across - 4, y - 1.3 * axis.up + 4);
    }
    pen.save();
    const share = Math.min(1, (width - 20) / 560);  // of a phone
    pen.translate(12, height - 22);
    pen.scale(share, share);
    this.scene.drawColours(pen, 0, 0, -24);
    pen.restore();
  }
}

// Triangles of faces with any number of corners.
function fans(faces, corners) {
  const triangles = [];
  for (let f = 0; f < faces.length; f += corners) {
    for (let k = 1; k + 1 < corners; ++k) triangles.push(faces[f], faces[f + k], faces[f + k + 1]);
  }
  return triangles;
}
