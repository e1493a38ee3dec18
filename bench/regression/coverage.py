"""How much of the floor that a vehicle can reach was in sight of one, by truth alone."""

import math
import pathlib
import sys
from collections import deque

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cases"))

from cases import tum  # noqa: E402

CELL_M = 0.1
VEHICLE_M = 0.35  # radius that planners keep free
SIGHT_M = 20.0
LIDAR_Z_M = 0.6
BODY_Z_M = (0.2, 0.4, 0.6, 0.85)  # what stands at one of these heights stops a vehicle
RAYS = 720
STEP_M = 1.0  # of the path


def read_triangles(path):
    """Corners of a binary PLY of triangles as the simulator writes it, (n, 3, 3)."""
    data = path.read_bytes()
    head, body = data.split(b"end_header\n", 1)
    counts = [int(line.split()[2]) for line in head.decode().splitlines() if line.startswith("element")]
    points = np.frombuffer(body, dtype="<f4", count=3 * counts[0]).reshape(-1, 3)
    face = np.dtype([("n", "u1"), ("index", "<i4", 3), ("reflectivity", "<f4")])
    faces = np.frombuffer(body, dtype=face, count=counts[1], offset=12 * counts[0])
    if len(faces) and not (faces["n"] == 3).all():
        raise ValueError(f"{path}: not only triangles")
    return points[faces["index"]].astype(float)


def cut(triangles, z):
    """Segments in the plane at height z, (n, 2, 2)."""
    segments = []
    for t in triangles:
        above = t[:, 2] > z
        if above.all() or not above.any():
            continue
        ends = []
        for i, j in ((0, 1), (1, 2), (2, 0)):
            if above[i] != above[j]:
                f = (z - t[i, 2]) / (t[j, 2] - t[i, 2])
                ends.append(t[i, :2] + f * (t[j, :2] - t[i, :2]))
        segments.append(ends)
    return np.array(segments).reshape(-1, 2, 2)


class Grid:
    """Cells of the plane; row by y, column by x."""

    def __init__(self, low, high):
        self.low = np.asarray(low) - 1.0
        size = np.ceil((np.asarray(high) + 1.0 - self.low) / CELL_M).astype(int)
        self.shape = (int(size[1]), int(size[0]))

    def cells(self, points):
        at = np.floor((points - self.low) / CELL_M).astype(int)
        return (np.clip(at[..., 1], 0, self.shape[0] - 1), np.clip(at[..., 0], 0, self.shape[1] - 1))

    def draw(self, segments):
        out = np.zeros(self.shape, dtype=bool)
        for a, b in segments:
            n = max(2, math.ceil(2 * np.linalg.norm(b - a) / CELL_M))
            out[self.cells(a + np.linspace(0, 1, n)[:, None] * (b - a))] = True
        return out


def grown(blocked, radius_m):
    """Cells nearer than the radius to a blocked one."""
    n = math.ceil(radius_m / CELL_M)
    padded = np.pad(blocked, n)
    out = np.zeros_like(blocked)
    for dy in range(-n, n + 1):
        for dx in range(-n, n + 1):
            if dx * dx + dy * dy <= (radius_m / CELL_M) ** 2:
                out |= padded[n + dy:n + dy + blocked.shape[0], n + dx:n + dx + blocked.shape[1]]
    return out


def reached(free, starts):
    """Free cells that are connected with one of the starts."""
    out = np.zeros_like(free)
    queue = deque()
    for cell in starts:
        out[cell] = True
        queue.append(cell)
    while queue:
        y, x = queue.popleft()
        for cell in ((y + 1, x), (y - 1, x), (y, x + 1), (y, x - 1)):
            if (0 <= cell[0] < free.shape[0] and 0 <= cell[1] < free.shape[1] and free[cell]
                    and not out[cell]):
                out[cell] = True
                queue.append(cell)
    return out


def in_sight(walls, grid, positions):
    """Cells that a ray from one of the positions crosses before it meets a wall."""
    angles = np.linspace(0, 2 * math.pi, RAYS, endpoint=False)
    steps = np.arange(0.0, SIGHT_M, CELL_M)
    rays = np.stack([np.cos(angles), np.sin(angles)], axis=-1)[:, None, :] * steps[None, :, None]
    out = np.zeros(grid.shape, dtype=bool)
    for position in positions:
        rows, columns = grid.cells(position + rays)
        clear = ~np.logical_or.accumulate(walls[rows, columns], axis=1)
        out[rows[clear], columns[clear]] = True
    return out


def positions_of(truth):
    """Start of each vehicle, and places along all paths."""
    starts, places = [], []
    for path in sorted(truth.glob("*.tum")):
        track = tum(path)[:, 1:3]
        starts.append(track[0])
        places.append(track[0])
        for point in track[::20]:
            if np.linalg.norm(point - places[-1]) >= STEP_M:
                places.append(point)
    return starts, places


def seen_fraction(truth):
    """Of the floor that a vehicle can reach from a start, the fraction that was in sight within
    20 m of a true position. The floor must be level at z = 0."""
    triangles = read_triangles(truth / "mesh.ply")
    starts, places = positions_of(truth)
    walls = cut(triangles, LIDAR_Z_M)
    grid = Grid(walls.min(axis=(0, 1)), walls.max(axis=(0, 1)))
    blocked = np.zeros(grid.shape, dtype=bool)
    for z in BODY_Z_M:
        blocked |= grid.draw(cut(triangles, z))
    cells = [tuple(int(c) for c in grid.cells(start)) for start in starts]
    floor = reached(~grown(blocked, VEHICLE_M), cells)
    seen = in_sight(grid.draw(walls), grid, places)
    return float((floor & seen).sum() / floor.sum())
