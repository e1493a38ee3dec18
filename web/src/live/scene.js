// Camera, light and drawing on demand: a page that shows nothing new costs nothing.
import {
  Color, ColorManagement, GridHelper, LinearSRGBColorSpace, PerspectiveCamera, Scene, Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';

ColorManagement.enabled = false;

const GROUND = '#0e1218';
const SMALLEST_M = 8;

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
    if (this.follows && this.box) this.fit(this.box);
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

  /** Moves the camera so that all corners of the box {low, high} are seen. */
  fit(box) {
    this.box = box;
    const low = new Vector3(...box.low);
    const high = new Vector3(...box.high);
    const centre = low.clone().add(high).multiplyScalar(0.5);
    const half = high.clone().sub(low).multiplyScalar(0.5);
    half.x = Math.max(half.x, SMALLEST_M);
    half.y = Math.max(half.y, SMALLEST_M);
    // The longer side of the map lies along the longer side of the window.
    const turned = (half.x >= half.y) === (this.camera.aspect >= 1);
    const d = this.direction;
    const direction = turned ? d.clone() : new Vector3(-d.y, d.x, d.z);
    const right = new Vector3().crossVectors(this.camera.up, direction).normalize();
    const up = new Vector3().crossVectors(direction, right);
    const tan_up = Math.tan((this.camera.fov * Math.PI) / 360);
    const tan_right = tan_up * this.camera.aspect;
    let distance = 5;
    for (let i = 0; i < 8; ++i) {
      const corner = new Vector3(i & 1 ? half.x : -half.x, i & 2 ? half.y : -half.y, i & 4 ? half.z : -half.z);
      const near = corner.dot(direction);
      distance = Math.max(distance, near + Math.abs(corner.dot(right)) / tan_right, near + Math.abs(corner.dot(up)) / tan_up);
    }
    this.camera.near = Math.max(distance / 500, 0.05);
    this.camera.far = distance * 30;
    this.camera.position.copy(centre).addScaledVector(direction, 1.04 * distance);
    this.camera.updateProjectionMatrix();
    this.controls.target.copy(centre);
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
