// The map to turn: points coloured by height, expected error or vehicle, ways, blind stretches.
import {
  AxesHelper, Box3, BufferAttribute, BufferGeometry, Color, ColorManagement,
  LinearSRGBColorSpace, PerspectiveCamera, Plane, Points, PointsMaterial, Scene,
  Vector3, WebGLRenderer,
} from 'three';
import {OrbitControls} from 'three/addons/controls/OrbitControls.js';
import {float32_of, positions_of, uint8_of} from './packed.js';

// The colours are those of the other drawings: as given, without light.
ColorManagement.enabled = false;

/** Colours for the points, r g b in 0..255. */
function colours_of(data, by) {
  const count = data.level[by].length;
  const out = new Uint8Array(3 * count);
  const palette = by === 'vehicle' ? data.vehicle_colours : data.colours;
  for (let i = 0; i < count; ++i) {
    const colour = palette[data.level[by][i] % palette.length];
    out.set(colour, 3 * i);
  }
  return out;
}

function make_points(data) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(data.positions, 3));
  geometry.setAttribute('color', new BufferAttribute(colours_of(data, 'height'), 3, true));
  const material = new PointsMaterial({size: 1.7, sizeAttenuation: false, vertexColors: true});
  material.clippingPlanes = [new Plane(new Vector3(0, 0, -1), 0)];
  return new Points(geometry, material);
}

/** Dots of one size along a way. Seen through walls: ways are what one looks for. */
function make_dots(values, colour, size, order) {
  const geometry = new BufferGeometry();
  geometry.setAttribute('position', new BufferAttribute(values, 3));
  const material = new PointsMaterial(
    {color: new Color(colour), size, sizeAttenuation: false, depthTest: false});
  const dots = new Points(geometry, material);
  dots.renderOrder = order;
  return dots;
}

/** A way with a white border; lines of WebGL are one pixel wide, so it is made of dots. */
function add_way(scene, way) {
  const values = float32_of(way.points);
  if (way.truth) {
    scene.add(make_dots(values, way.colour, 2, 1));
    return;
  }
  scene.add(make_dots(values, '#ffffff', 6.5, 2));
  if (way.blind) scene.add(make_dots(float32_of(way.blind), '#d55e00', 8, 3));
  scene.add(make_dots(values, way.colour, 3.5, 4));
}

function unpack(json) {
  const count = json.count;
  return {
    positions: positions_of(json.points, json.step_m),
    level: {height: uint8_of(json.height), sigma: uint8_of(json.sigma), vehicle: uint8_of(json.vehicle)},
    colours: json.colours, vehicle_colours: json.vehicle_colours, count,
  };
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

function fill(scene, json) {
  const data = unpack(json);
  const points = make_points(data);
  if (data.count > 0) scene.add(points);
  for (const way of json.ways) add_way(scene, way);
  const axes = new AxesHelper(2);
  axes.isAxes = true;
  scene.add(axes);
  return {data, points};
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
export function start_view(holder) {
  const json = JSON.parse(document.getElementById('view3d-data').textContent);
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
  const {data, points} = fill(scene, json);
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
  document.getElementById('view3d-colour')?.addEventListener('change', (event) => {
    points.geometry.setAttribute('color',
      new BufferAttribute(colours_of(data, event.target.value), 3, true));
    for (const key of document.querySelectorAll('.keys [data-colour]')) {
      key.hidden = key.dataset.colour !== event.target.value;
    }
    draw();
  });
  const cut = document.getElementById('view3d-cut');
  const lower = () => {
    const share = cut ? cut.valueAsNumber / 100 : 1;
    points.material.clippingPlanes[0].constant = share >= 1 ? 1e9 : json.half_height_m * (2 * share - 1);
    draw();
  };
  cut?.addEventListener('input', lower);
  resize();
  lower();
  holder.dataset.state = `${data.count} points drawn`;
}
