"""What is measured against the truth beyond `rali evaluate`: frames, loops, ranges."""

import csv
import json
import math
import pathlib
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cases"))

from cases import tum  # noqa: E402

# As in bench/fleet/score.cpp and truth.cpp.
WRONG_FRAME_M, WRONG_FRAME_DEG = 0.5, 5.0
WRONG_LOOP_M, WRONG_LOOP_DEG = 0.3, 3.0
KNOWN_M, KNOWN_RAD = 0.3, math.radians(3.0)
MOVING_MPS = 0.2
STAMP_S = 0.012  # stamps of ranges are up to 10 ms late: latency, jitter, clocks; half a period at 40 Hz


def csv_rows(path):
    with open(path, encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def rotation(q):
    x, y, z, w = q / np.linalg.norm(q)
    return np.array([[1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w)],
                     [2 * (x * y + z * w), 1 - 2 * (x * x + z * z), 2 * (y * z - x * w)],
                     [2 * (x * z - y * w), 2 * (y * z + x * w), 1 - 2 * (x * x + y * y)]])


def pose_of(numbers):
    """4x4 of x y z qx qy qz qw."""
    T = np.eye(4)
    T[:3, :3] = rotation(np.asarray(numbers[3:7], dtype=float))
    T[:3, 3] = numbers[:3]
    return T


def pose_at(track, stamp):
    """The pose at a stamp, linear between neighbours (10 ms apart); None outside the track."""
    if not track[0, 0] - 1e-6 <= stamp <= track[-1, 0] + 1e-6:
        return None
    i = int(np.clip(np.searchsorted(track[:, 0], stamp), 1, len(track) - 1))
    a, b = track[i - 1], track[i]
    f = float(np.clip((stamp - a[0]) / (b[0] - a[0]), 0.0, 1.0))
    q = b[4:8] if np.dot(a[4:8], b[4:8]) >= 0 else -b[4:8]
    return pose_of(np.concatenate([(1 - f) * a[1:4] + f * b[1:4], (1 - f) * a[4:8] + f * q]))


def rotation_vector(R):
    axis = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]])
    angle = math.atan2(0.5 * np.linalg.norm(axis), 0.5 * (np.trace(R) - 1))
    norm = np.linalg.norm(axis)
    return axis * (angle / norm) if norm > 1e-12 else 0.5 * axis


def wrong_frames(out, truth, group):
    """Vehicles of the group whose first pose relative to the first vehicle's is wrong."""
    tracks = {}
    for name in group:
        estimate = tum(out / "trajectory" / f"{name}.tum")
        if len(estimate):
            tracks[name] = estimate[0]
    wrong = 0
    names = [name for name in group if name in tracks]
    for name in names[1:]:
        a, b = tracks[names[0]], tracks[name]
        Q_a = pose_at(tum(truth / f"{names[0]}.tum"), a[0])
        Q_b = pose_at(tum(truth / f"{name}.tum"), b[0])
        if Q_a is None or Q_b is None:
            continue
        P = np.linalg.inv(pose_of(a[1:])) @ pose_of(b[1:])
        E = np.linalg.inv(np.linalg.inv(Q_a) @ Q_b) @ P
        angle = np.linalg.norm(rotation_vector(E[:3, :3]))
        if np.linalg.norm(E[:3, 3]) > WRONG_FRAME_M or math.degrees(angle) > WRONG_FRAME_DEG:
            wrong += 1
    return wrong


def known_part(error, covariance, sigma):
    """The part of an error along directions that the covariance calls known."""
    values, vectors = np.linalg.eigh(covariance)
    along = vectors.T @ error
    return float(np.linalg.norm(along[values <= sigma * sigma]))


def loop_edges(out, names):
    """(t_from, v_from, t_to, v_to) and T, covariance of the edges of graph.pyfg, loops or not."""
    vertices, edges = {}, []
    letters = {chr(ord("A") + i): name for i, name in enumerate(names)}
    for line in (out / "graph.pyfg").read_text().splitlines():
        words = line.split()
        if words[0] == "VERTEX_SE3:QUAT":
            vertices[words[2]] = (float(words[1]), letters[words[2][0]])
        elif words[0] == "EDGE_SE3:QUAT":
            covariance = np.zeros((6, 6))
            covariance[np.triu_indices(6)] = [float(w) for w in words[11:32]]
            covariance = np.triu(covariance) + np.triu(covariance, 1).T
            pose = pose_of([float(w) for w in words[4:11]])
            edges.append((vertices[words[2]] + vertices[words[3]], pose, covariance))
    return edges


def wrong_loops(out, truth, names):
    """Accepted loops, and how many of them are wrong where they claim to know."""
    accepted = set()
    for row in csv_rows(out / "loops.csv"):
        if row["accepted"] == "1":
            accepted.add((round(float(row["stamp_from_s"]), 3), row["vehicle_from"],
                          round(float(row["stamp_to_s"]), 3), row["vehicle_to"]))
    if not accepted:
        return 0, 0
    tracks = {name: tum(truth / f"{name}.tum") for name in names}
    wrong = 0
    for (t_from, v_from, t_to, v_to), T, covariance in loop_edges(out, names):
        if (round(t_from, 3), v_from, round(t_to, 3), v_to) not in accepted:
            continue
        Q_from, Q_to = pose_at(tracks[v_from], t_from), pose_at(tracks[v_to], t_to)
        if Q_from is None or Q_to is None:
            continue
        true = np.linalg.inv(Q_from) @ Q_to
        shift = known_part(T[:3, 3] - true[:3, 3], covariance[:3, :3], KNOWN_M)
        turn = known_part(rotation_vector(true[:3, :3].T @ T[:3, :3]), covariance[3:, 3:], KNOWN_RAD)
        wrong += shift > WRONG_LOOP_M or math.degrees(turn) > WRONG_LOOP_DEG
    return len(accepted), int(wrong)


def nis(out):
    """Mean squared residual over variance of the ranges that were used."""
    values = [(float(r["residual_m"]) / float(r["sigma_m"])) ** 2
              for r in csv_rows(out / "ranges.csv")
              if r["used"] == "1" and r["residual_m"] and r["sigma_m"] and float(r["sigma_m"]) > 0]
    return sum(values) / len(values) if values else None


def speed_at(track, stamps):
    p = [np.column_stack([np.interp(stamps + d, track[:, 0], track[:, k]) for k in (1, 2, 3)])
         for d in (-0.25, 0.25)]
    return np.linalg.norm(p[1] - p[0], axis=1) / 0.5


def degenerate_at(out, name, stamps):
    """Whether the scan that holds each stamp was degenerate by the vehicle's own word."""
    rows = csv_rows(out / "degeneracy" / f"{name}.csv")
    ends = np.array([float(r["stamp_s"]) for r in rows])
    flags = np.array([r["degenerate"] == "1" for r in rows] + [False])
    return flags[np.searchsorted(ends, stamps)]


def applied_ranges(out, truth, names):
    """Of the line-of-sight ranges that arrive while the one vehicle that drives is degenerate, the
    fraction that was applied; None if there are none."""
    clear = {}
    for r in csv_rows(truth / "ranges.csv"):
        if r["obstructed"] == "0":
            clear.setdefault((r["from"], r["to"]), []).append(float(r["stamp_s"]))
    clear = {pair: np.array(sorted(stamps)) for pair, stamps in clear.items()}
    by_pair = {}
    for r in csv_rows(out / "ranges.csv"):
        if r["reason"] not in ("duplicate", "unknown_id"):
            by_pair.setdefault((r["from"], r["to"]), []).append((float(r["stamp_s"]), r["used"] == "1"))
    tracks = {name: tum(truth / f"{name}.tum") for name in names}
    asked = applied = 0
    for pair, rows in by_pair.items():
        if pair not in clear or any(name not in tracks for name in pair):
            continue
        stamps, used = np.array([t for t, _ in rows]), np.array([u for _, u in rows])
        nearest = np.clip(np.searchsorted(clear[pair], stamps), 1, len(clear[pair]) - 1)
        gap = np.minimum(abs(clear[pair][nearest] - stamps), abs(clear[pair][nearest - 1] - stamps))
        moving = [speed_at(tracks[name], stamps) > MOVING_MPS for name in pair]
        degenerate = [degenerate_at(out, name, stamps) for name in pair]
        want = np.zeros(len(stamps), dtype=bool)
        for a, b in ((0, 1), (1, 0)):
            want |= moving[a] & ~moving[b] & degenerate[a]
        want &= gap < STAMP_S
        asked += int(want.sum())
        applied += int((want & used).sum())
    return applied / asked if asked else None


def findings(metrics):
    """Ids of warnings and errors with their number."""
    counts = {}
    for warning in metrics["warnings"]:
        counts[warning["id"]] = counts.get(warning["id"], 0) + 1
    return " ".join(f"{name}:{n}" for name, n in sorted(counts.items()))


def read_json(path):
    return json.loads(path.read_text(encoding="utf-8"))
