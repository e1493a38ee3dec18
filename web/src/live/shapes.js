// Lines of some pixels' width, discs and arrows, of which the fleet is drawn.
import {
  AdditiveBlending, BufferAttribute, BufferGeometry, ConeGeometry, CylinderGeometry, DoubleSide, Group, Mesh,
  MeshBasicMaterial, RingGeometry, SphereGeometry,
} from 'three';
import {LineMaterial} from 'three/addons/lines/LineMaterial.js';
import {LineSegments2} from 'three/addons/lines/LineSegments2.js';
import {LineSegmentsGeometry} from 'three/addons/lines/LineSegmentsGeometry.js';

/** Segments [x y z x y z ...] that are made anew at each state. */
export class Lines {
  constructor(width, options = {}) {
    this.material = new LineMaterial({linewidth: width, vertexColors: true, transparent: true, ...options});
    this.object = new LineSegments2(new LineSegmentsGeometry(), this.material);
    this.object.frustumCulled = false;
    this.object.visible = false;
  }

  /** @param segments list of [a, b, Color, Color of b or nothing] */
  set(segments) {
    this.object.visible = segments.length > 0;
    if (!segments.length) return;
    const positions = new Float32Array(6 * segments.length);
    const colours = new Float32Array(6 * segments.length);
    segments.forEach(([a, b, colour, colour_b], i) => {
      positions.set(a, 6 * i);
      positions.set(b, 6 * i + 3);
      colour.toArray(colours, 6 * i);
      (colour_b ?? colour).toArray(colours, 6 * i + 3);
    });
    this.object.geometry.dispose();
    const geometry = new LineSegmentsGeometry();
    geometry.setPositions(positions);
    geometry.setColors(colours);
    this.object.geometry = geometry;
    if (this.material.dashed) this.object.computeLineDistances();
  }
}

/** An arrow on the ground: where a vehicle looks. */
export function make_vehicle(colour) {
  const group = new Group();
  const shape = new BufferGeometry();
  shape.setAttribute('position', new BufferAttribute(Float32Array.from(
    [0.9, 0, 0.05, -0.6, 0.5, 0.05, -0.35, 0, 0.05, 0.9, 0, 0.05, -0.35, 0, 0.05, -0.6, -0.5, 0.05]), 3));
  const body = new Mesh(shape, new MeshBasicMaterial({color: colour, side: DoubleSide, transparent: true, depthTest: false}));
  body.renderOrder = 20;
  const dot = new Mesh(new SphereGeometry(0.16, 16, 12), new MeshBasicMaterial({color: '#ffffff', transparent: true, depthTest: false}));
  dot.renderOrder = 21;
  group.add(body, dot);
  group.userData = {body, dot};
  return group;
}

/** Disc and border of an ellipse with half axes 1; scaled to 2 sigma. */
export function make_ellipse(colour) {
  const group = new Group();
  const material = (opacity) => new MeshBasicMaterial({color: colour, transparent: true, opacity, side: DoubleSide, depthWrite: false, depthTest: false});
  const disc = new Mesh(new RingGeometry(0, 1, 48), material(0.18));
  const border = new Mesh(new RingGeometry(0.94, 1, 48), material(0.9));
  disc.renderOrder = 10;
  border.renderOrder = 11;
  group.add(disc, border);
  return group;
}

/** A beam above the anchor. */
export function make_beacon() {
  const group = new Group();
  const beam = new Mesh(new CylinderGeometry(0.09, 0.09, 6, 12, 1, true), new MeshBasicMaterial(
    {color: '#ffffff', transparent: true, opacity: 0.65, depthWrite: false, blending: AdditiveBlending}));
  beam.rotation.x = Math.PI / 2;
  beam.position.z = 3;
  const ring = new Mesh(new RingGeometry(1.25, 1.45, 48), new MeshBasicMaterial(
    {color: '#ffffff', transparent: true, opacity: 0.9, side: DoubleSide, depthTest: false}));
  ring.renderOrder = 12;
  group.add(beam, ring);
  group.userData = {beam, ring};
  return group;
}

/** A pin where somebody is to go, or a diamond where the map is open. */
export function make_mark(colour, kind) {
  const shape = kind === 'goal' ? new ConeGeometry(0.35, 0.9, 4) : new SphereGeometry(0.28, 4, 2);
  const mark = new Mesh(shape, new MeshBasicMaterial({color: colour, transparent: true, opacity: 0.95}));
  if (kind === 'goal') {
    mark.rotation.x = -Math.PI / 2;
    mark.position.z = 0.55;
  }
  const group = new Group();
  group.add(mark);
  return group;
}
