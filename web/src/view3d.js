// The map in 3-D: points coloured by height, expected error or vehicle, paths, degenerate stretches.
import {
  AxesHelper, Box3, BufferAttribute, BufferGeometry, Color, ColorManagement,
  LinearSRGBColorSpace, PerspectiveCamera, Plane, Points, PointsMaterial, Scene,
  Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {colour_choice, on_colour, rgb_of} from './cloud.js';
import {is_degenerate} from './page_data.js';

// The colours are those of the other drawings: as given, without light.
ColorManagement.enabled = false;

/** Colours for the points, r g b in 0..255. */
function colours_of(page, by) {
  const {cloud} = page;
  const rgb = rgb_of(cloud, page.vehicles, by);
  const out = new Uint8Array(3 * cloud.count);
  for (let i = 0; i < cloud.count; ++i) out.set(rgb[cloud.level[by][i] % rgb.length], 3 * i);
  return out;
}

function make_points(page) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(page.cloud.positions, 3));
  geometry.setAttribute('color', new BufferAttribute(colours_of(page, colour_choice()), 3, true));
  const material = new PointsMaterial({size: 1.7, sizeAttenuation: false, vertexColors: true});
  material.clippingPlanes = [new Plane(new Vector3(0, 0, -1), 0)];
  return new Points(geometry, material);
}

/** Positions of a vehicle around the cloud's centre, of the rows that `keep` names. */
function places_of(v, names, centre_m, keep) {
  const out = [];
  for (let k = 0; k < v.rows; ++k) {
    const point = names.map((name) => v[name]?.[k] ?? null);
    if (point[0] !== null && keep(v.state[k])) out.push(...point.map((p, n) => p - centre_m[n]));
  }
  return Float32Array.from(out);
}

/** Dots of one size along a path. Seen through walls: paths are what one looks for. */
function make_dots(values, colour, size, order) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(values, 3));
  const material = new PointsMaterial(
    {color: new Color(colour), size, sizeAttenuation: false, depthTest: false});
  const dots = new Points(geometry, material);
  dots.renderOrder = order;
  return dots;
}

/** A path with a white border; lines of WebGL are one pixel wide, so it is made of dots. */
function add_path(scene, v, centre_m) {
  const all = places_of(v, ['x', 'y', 'z'], centre_m, () => true);
  if (v.true_x) scene.add(make_dots(places_of(v, ['true_x', 'true_y', 'true_z'], centre_m, () => true), '#6e747e', 2, 1));
  scene.add(make_dots(all, '#ffffff', 6.5, 2));
  scene.add(make_dots(places_of(v, ['x', 'y', 'z'], centre_m, is_degenerate), '#d55e00', 8, 3));
  scene.add(make_dots(all, v.colour, 3.5, 4));
}

/** Distance at which all corners of the box are seen, looking along -direction at its centre. */
function distance_to_see(camera, box, direction) {
  const centre = box.getCenter(new Vector3());
  const right = new Vector3().crossVectors(camera.up, direction).normalize();
  const up = new Vector3().crossVectors(direction, right);
  const tan_up = Math.tan((camera.fov * Math.PI) / 360);
  const tan_right = tan_up * camera.aspect;
  let distance = 1;
  for (let i = 0; i < 8; ++i) {
    const corner = new Vector3(i & 1 ? box.max.x : box.min.x, i & 2 ? box.max.y : box.min.y,
      i & 4 ? box.max.z : box.min.z).sub(centre);
    const near = corner.dot(direction);
    distance = Math.max(distance, near + Math.abs(corner.dot(right)) / tan_right,
      near + Math.abs(corner.dot(up)) / tan_up);
  }
  return 1.06 * distance;
}

/** The whole map from above its longer side. */
function place_camera(camera, controls, box) {
  const centre = box.getCenter(new Vector3());
  const size = box.getSize(new Vector3());
  const direction = (size.x >= size.y ? new Vector3(-0.25, -0.6, 0.75) : new Vector3(0.6, -0.25, 0.75))
    .normalize();
  camera.up.set(0, 0, 1);
  const distance = distance_to_see(camera, box, direction);
  camera.near = distance / 1000;
  camera.far = distance * 20;
  camera.position.copy(centre).addScaledVector(direction, distance);
  camera.updateProjectionMatrix();
  controls.target.copy(centre);
  controls.update();
}

function bounds_of(scene) {
  const box = new Box3();
  scene.traverse((object) => {
    if (object.geometry?.attributes?.position?.count && !object.isAxes) box.expandByObject(object);
  });
  return box.isEmpty() ? new Box3(new Vector3(-1, -1, -1), new Vector3(1, 1, 1)) : box;
}

function fill(scene, page) {
  const points = make_points(page);
  scene.add(points);
  for (const v of page.vehicles) {
    if (v.group === 'map' && v.x) add_path(scene, v, page.cloud.centre_m);
  }
  const axes = new AxesHelper(2);
  axes.isAxes = true;
  scene.add(axes);
  return points;
}

function make_renderer(holder) {
  // The drawing is kept, or it would be empty on paper.
  const renderer = new WebGLRenderer({antialias: true, preserveDrawingBuffer: true});
  renderer.outputColorSpace = LinearSRGBColorSpace;
  renderer.localClippingEnabled = true;
  renderer.setPixelRatio(Math.min(window.devicePixelRatio, 2));
  holder.replaceChildren(renderer.domElement);
  return renderer;
}

/** Draws into `holder`; without WebGL one sentence stands there instead. */
export function start_view(holder, page) {
  let renderer;
  try {
    renderer = make_renderer(holder);
  } catch {
    holder.textContent = 'This browser shows no 3-D graphics (WebGL is off). map.ply opens in CloudCompare.';
    holder.dataset.state = 'no webgl';
    return;
  }
  const scene = new Scene();
  scene.background = new Color(0xffffff);
  const points = fill(scene, page);
  const camera = new PerspectiveCamera(45, 1, 0.1, 1000);
  const controls = new OrbitControls(camera, renderer.domElement);
  controls.enableZoom = false;  // the wheel belongs to the page until the view was clicked
  const draw = () => renderer.render(scene, camera);
  let touched = false;
  const resize = () => {
    const [width, height] = [holder.clientWidth, holder.clientHeight];
    renderer.setSize(width, height);
    camera.aspect = width / Math.max(height, 1);
    camera.updateProjectionMatrix();
    if (touched) draw();
    else home();
  };
  const home = () => { place_camera(camera, controls, bounds_of(scene)); draw(); };
  controls.addEventListener('change', draw);
  renderer.domElement.addEventListener('pointerdown', () => { touched = controls.enableZoom = true; });
  renderer.domElement.addEventListener('pointerleave', () => { controls.enableZoom = false; });
  window.addEventListener('resize', resize);
  document.getElementById('view3d-home')?.addEventListener('click', home);
  on_colour((by) => {
    points.geometry.setAttribute('color', new BufferAttribute(colours_of(page, by), 3, true));
    draw();
  });
  const cut = document.getElementById('view3d-cut');
  const half_height_m = 0.5 * (page.cloud.high_m[2] - page.cloud.low_m[2]);
  const lower = () => {
    const share = cut ? cut.valueAsNumber / 100 : 1;
    points.material.clippingPlanes[0].constant = share >= 1 ? 1e9 : half_height_m * (2 * share - 1);
    draw();
  };
  cut?.addEventListener('input', lower);
  resize();
  lower();
  holder.dataset.state = `${page.cloud.count} points drawn`;
}
