// Camera, light and drawing on demand: a page that shows nothing new costs nothing.
import {
  Color, ColorManagement, GridHelper, LinearSRGBColorSpace, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

ColorManagement.enabled = false;

const GROUND = '#0e1218';
const SMALLEST_M = 18;

function bounds_of(places) {
  const low = [Infinity, Infinity, Infinity];
  const high = [-Infinity, -Infinity, -Infinity];
  for (let i = 0; i < places.length; ++i) {
    low[i % 3] = Math.min(low[i % 3], places[i]);
    high[i % 3] = Math.max(high[i % 3], places[i]);
  }
  return [low, high];
}

/** Calls f(right, up, near) for each place, from `target` along the axes of the picture. */
function for_places(places, target, right, up, direction, f) {
  const v = new Vector3();
  for (let i = 0; i + 2 < places.length; i += 3) {
    v.set(places[i], places[i + 1], places[i + 2]).sub(target);
    f(v.dot(right), v.dot(up), v.dot(direction));
  }
}

/** What the picture spans, as tangents seen from `distance`. */
function extent_of(places, target, right, up, direction, distance) {
  const out = {right: [Infinity, -Infinity], up: [Infinity, -Infinity]};
  for_places(places, target, right, up, direction, (r, u, near) => {
    const away = Math.max(distance - near, 1);
    out.right = [Math.min(out.right[0], r / away), Math.max(out.right[1], r / away)];
    out.up = [Math.min(out.up[0], u / away), Math.max(out.up[1], u / away)];
  });
  return out;
}

function distance_for(places, target, right, up, direction, tan_right, tan_up) {
  let distance = 0;
  for_places(places, target, right, up, direction, (r, u, near) => {
    distance = Math.max(distance, near + Math.abs(r) / tan_right, near + Math.abs(u) / tan_up);
  });
  return distance;
}

export class View {
  constructor(holder) {
    this.holder = holder;
    this.renderer = new WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
    holder.prepend(this.renderer.domElement);
    this.scene = new Scene();
    this.scene.background = new Color(GROUND);
    this.camera = new PerspectiveCamera(42, 1, 0.1, 5000);
    this.camera.up.set(0, 0, 1);
    this.controls = new OrbitControls(this.camera, this.renderer.domElement);
    this.controls.enableDamping = false;
    this.controls.maxPolarAngle = 0.497 * Math.PI;
    this.controls.addEventListener('change', () => this.draw());
    this.renderer.domElement.addEventListener('pointerdown', () => this.let_go());
    this.renderer.domElement.addEventListener('wheel', () => this.let_go(), {passive: true});
    this.drawn = [];     // called after each drawing
    this.direction = new Vector3(-0.35, -0.72, 0.95).normalize();
    this.follows = true;  // the camera fits the map until somebody moves it
    this.waits = false;
    new ResizeObserver(() => this.resize()).observe(holder);
    this.resize();
  }

  let_go() {
    this.follows = false;
    this.on_let_go?.();
  }

  resize() {
    const [width, height] = [Math.max(this.holder.clientWidth, 1), Math.max(this.holder.clientHeight, 1)];
    this.renderer.setSize(width, height);
    this.camera.aspect = width / height;
    this.camera.updateProjectionMatrix();
    if (this.follows && this.places) this.fit(this.places);
    this.draw();
  }

  /** Pixels per metre at one metre's distance. */
  get scale() {
    return this.holder.clientHeight / (2 * Math.tan((this.camera.fov * Math.PI) / 360)) * this.renderer.getPixelRatio();
  }

  draw() {
    if (this.waits) return;
    this.waits = true;
    requestAnimationFrame(() => {
      this.waits = false;
      for (const f of this.before ?? []) f();
      this.renderer.render(this.scene, this.camera);
      for (const f of this.drawn) f();
    });
  }

  /** Moves the camera so that all places [x y z x y z ...] are seen. */
  fit(places) {
    this.places = places;
    const [low, high] = bounds_of(places);
    // The longer side of the map lies along the longer side of the window.
    const turned = (high[0] - low[0] >= high[1] - low[1]) === (this.camera.aspect >= 1);
    const d = this.direction;
    const direction = turned ? d.clone() : new Vector3(-d.y, d.x, d.z);
    const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const tan_up = Math.tan((this.camera.fov * Math.PI) / 360);
    const tan_right = tan_up * this.camera.aspect;
    const target = new Vector3(...low.map((value, i) => 0.5 * (value + high[i])));
    let distance = SMALLEST_M;
    // Perspective moves the middle of the picture; two rounds find it well enough.
    for (let round = 0; round < 3; ++round) {
      const seen = extent_of(places, target, right, up, direction, distance);
      target.addScaledVector(right, 0.5 * (seen.right[0] + seen.right[1]) * distance);
      target.addScaledVector(up, 0.5 * (seen.up[0] + seen.up[1]) * distance);
      distance = Math.max(distance_for(places, target, right, up, direction, tan_right, tan_up), SMALLEST_M);
    }
    distance *= 1.07;
    this.camera.near = Math.max(distance / 500, 0.05);
    this.camera.far = distance * 30;
    this.camera.position.copy(target).addScaledVector(direction, distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(target);
    this.controls.update();
  }

  /** Looks at a place from where the camera stands now, nearer. */
  look_at(p) {
    this.let_go();
    const offset = this.camera.position.clone().sub(this.controls.target).setLength(22);
    this.controls.target.set(...p);
    this.camera.position.copy(this.controls.target).add(offset);
    this.controls.update();
    this.draw();
  }

  /** Where a place is on the holder, in pixels; null: behind the camera. */
  pixel_of(p) {
    const v = new Vector3(...p).project(this.camera);
    if (v.z > 1 || Math.abs(v.x) > 1.1 || Math.abs(v.y) > 1.1) return null;
    return [(0.5 + 0.5 * v.x) * this.holder.clientWidth, (0.5 - 0.5 * v.y) * this.holder.clientHeight];
  }
}

/** Lines of 10 m on the ground. */
export function make_grid() {
  const grid = new GridHelper(400, 40, '#2a3340', '#1a212b');
  grid.rotation.x = Math.PI / 2;
  return grid;
}
