// The ground plan (OccupancyGrid) as a picture on the floor.
import {DataTexture, Group, Mesh, MeshBasicMaterial, NearestFilter, PlaneGeometry} from 'three';

const FREE = [46, 58, 74, 150];
const OCCUPIED = [190, 200, 214, 210];

export function make_plan(grid) {
  const pixels = new Uint8Array(4 * grid.width * grid.height);
  for (let i = 0; i < grid.cells.length; ++i) {
    const value = grid.cells[i];
    if (value <= 100) pixels.set(value >= 50 ? OCCUPIED : FREE, 4 * i);  // 255 is -1: not known
  }
  const texture = new DataTexture(pixels, grid.width, grid.height);
  texture.magFilter = NearestFilter;
  texture.needsUpdate = true;
  const [w, h] = [grid.width * grid.resolution_m, grid.height * grid.resolution_m];
  const plane = new Mesh(new PlaneGeometry(w, h), new MeshBasicMaterial({map: texture, transparent: true, depthWrite: false}));
  plane.position.set(0.5 * w, 0.5 * h, 0);
  const group = new Group();
  group.add(plane);
  group.position.set(grid.x_m, grid.y_m, 0);
  group.rotation.z = grid.yaw_rad;
  return group;
}
