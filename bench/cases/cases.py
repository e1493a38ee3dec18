#!/usr/bin/env python3
"""The named cases of docs/results: each is simulated from its description, mapped and evaluated.

One row per case: median and worst over the seeds. Needs python3-numpy. Recordings are kept in the
folder and used again; --forget removes each after its run. Usage:
    cases.py --rali build/release/bin/rali --folder /tmp/cases --cases corridor,portal --seeds 1-20
    cases.py ... --cases portal --preset paper --set odometry.paper.literal=true
    cases.py --list
"""

import argparse
import json
import math
import pathlib
import random
import shutil
import subprocess
import sys

import numpy as np

SHAKEN = """\
imu: {accel_mps2_rthz: 6e-4, gyro_radps_rthz: 5e-4, resonance_accel_mps2: 0.15, resonance_gyro_radps: 0.01,
  resonance_low_hz: 11, resonance_high_hz: 38, vibration_accel_mps2: 0, vibration_gyro_radps: 0}
motion: {speed_mps: 1.0, standstill_s: 10,
  jolts: {joint_every_m: 0.6, joint_m: 0.002, slip_every_m: 0.2, slip_m: 0.002, step_s: 0.01, measured_ratio: 0.2}}
"""
DATA_SHEET = "noise: {accel_mps2_rthz: 6e-4, gyro_radps_rthz: 5e-4}, "


def corridor_scene(_seed):
    """2.4 m wide, one bend, 81 m, then 80 s of standing."""
    return "schema: 1\nscene: corridor\nvehicles: 1\n" + SHAKEN


def portal_scene(_seed):
    """A straight tunnel: v1 stands at the portal, v2 beside it (2.9 m) drives 200 m."""
    return """\
schema: 1
tunnel: {length_m: 215, width_m: 6, wall_height_m: 1.5, roughness_m: 0.008}
vehicles:
  - {start: [0.0, 1.0], yaw_deg: 0}
  - {start: [0.0, -1.9], yaw_deg: 0}
rounds:
  - {anchor: v1, routes: {v2: [[2, -1.2], [8, -0.3], [200, 0]]}}
uwb: {rate_hz: 40, max_range_m: 400}
motion: {speed_mps: 1.0, standstill_s: 6}
"""


def middle_scene(_seed):
    """A straight tunnel: v1 stands at its middle, v2 drives past it from the portal."""
    return """\
schema: 1
tunnel: {length_m: 215, width_m: 6, wall_height_m: 1.5, roughness_m: 0.008}
vehicles:
  - {start: [100.0, 1.6], yaw_deg: 0}
  - {start: [2.0, -1.2], yaw_deg: 0}
rounds:
  - {anchor: v1, routes: {v2: [[2, -1.2], [8, -1.2], [200, -1.2]]}}
uwb: {max_range_m: 400}
motion: {speed_mps: 1.0, rest_s: 6}
"""


def kilometre_scene(_seed):
    """Four vehicles in rounds through a kilometre without anything along the axis."""
    return (pathlib.Path(__file__).parent.parent / "fleet" / "tunnel_1000.yaml").read_text()


def shipped(scene, vehicles=1):
    """One of the scenes of `rali simulate` by its name."""
    return lambda _seed: f"schema: 1\nscene: {scene}\nvehicles: {vehicles}\n"


def pair_corridor_scene(_seed):
    """Two vehicles that take turns in the corridor, an honest inertial sensor."""
    return "schema: 1\nscene: corridor\nvehicles: 2\nuwb: {rate_hz: 40}\nmotion: {standstill_s: 6}\n"


def on_arc(curvature_per_m, s, side=0.0):
    """The point `side` to the left of an arc from the origin along x, after s metres."""
    if curvature_per_m == 0:
        return s, side
    yaw = curvature_per_m * s
    return (math.sin(yaw) / curvature_per_m - side * math.sin(yaw),
            (1 - math.cos(yaw)) / curvature_per_m + side * math.cos(yaw))


def route_on_arc(curvature_per_m, along, side=0.0):
    """A route of a scene through the points after these metres."""
    return "[" + ", ".join("[%.3f, %.3f]" % on_arc(curvature_per_m, s, side) for s in along) + "]"


def start_on_arc(curvature_per_m, s, side=0.0):
    """A vehicle of a scene that starts there, along the arc."""
    x, y = on_arc(curvature_per_m, s, side)
    return f"  - {{start: [{x:.3f}, {y:.3f}], yaw_deg: {math.degrees(curvature_per_m * s):.3f}}}\n"


def steps_of_4_m(begin, end):
    n = max(1, math.ceil((end - begin) / 4))
    return [begin + (end - begin) * i / n for i in range(n + 1)]


def leap_frog_scene(seed):
    """Four vehicles in 600 m of a bent, inclined tunnel; pairs leap 60 to 75 m beyond each other."""
    rng = random.Random(seed)
    k = rng.choice([-1, 1]) / rng.uniform(260, 500)
    gradient = rng.choice([-1, 1]) * rng.uniform(0.01, 0.035)
    cabinet_m = rng.uniform(120, 180)
    lanes = {"v1": 0.8, "v2": 1.9, "v3": -0.8, "v4": -1.9}

    at = {"v1": 4.0, "v2": 7.0, "v3": 4.0, "v4": 7.0}
    starts = "".join(start_on_arc(k, at[v], lanes[v]) for v in at)
    rounds, ahead, behind = "", ("v1", "v2"), ("v3", "v4")
    while True:
        target = max(at[v] for v in behind) + rng.uniform(60, 75)
        if target > 590:
            break
        ahead, behind = behind, ahead
        routes = []
        for v in ahead:
            to = target - (3.0 if v in ("v1", "v3") else 0.0)
            routes.append(f"{v}: {route_on_arc(k, steps_of_4_m(at[v], to), lanes[v])}")
            at[v] = to
        rounds += f"  - {{anchor: {behind[0]}, pause_s: 3, routes: {{{', '.join(routes)}}}}}\n"
    return f"""\
schema: 1
tunnel: {{length_m: 620, width_m: 7, wall_height_m: 1.5, roughness_m: 0.01, curvature_per_m: {k:.6f},
  gradient: {gradient:.4f}, cabinet_every_m: {cabinet_m:.0f}}}
vehicles:
{starts}rounds:
{rounds}uwb: {{max_range_m: 200}}
motion: {{speed_mps: 1.2, standstill_s: 6}}
"""


def bent_return_scene(seed):
    """A bent tunnel: v1 stands at the portal, v2 drives 140 m, out of sight for half of it, and back."""
    rng = random.Random(seed)
    k = rng.choice([-1, 1]) / rng.uniform(220, 450)

    way = [*range(8, 148, 4), *range(144, 16, -4)]
    return f"""\
schema: 1
tunnel: {{length_m: 200, width_m: 7, wall_height_m: 1.5, roughness_m: 0.01, curvature_per_m: {k:.6f}, gradient: 0.01}}
vehicles:
{start_on_arc(k, 4, 1.2)}{start_on_arc(k, 4, -1.2)}rounds:
  - {{anchor: v1, routes: {{v2: {route_on_arc(k, way, -1.2)}}}}}
uwb: {{max_range_m: 200}}
motion: {{speed_mps: 1.2, standstill_s: 6}}
"""


def pipe_scene(seed):
    """A round pipe, straight or bent: two vehicles, one behind the other, in three rounds."""
    rng = random.Random(seed)
    width_m = rng.uniform(1.6, 5)
    k = rng.choice([-1, 0, 1]) / rng.uniform(80, 300)
    length_m = 80 if width_m < 2 else 150

    def route(begin, end):
        return route_on_arc(k, steps_of_4_m(begin, end))

    half = 0.55 * length_m
    return f"""\
schema: 1
tunnel: {{length_m: {length_m + 10}, width_m: {width_m:.2f}, round: true, roughness_m: 0, curvature_per_m: {k:.6f},
  gradient: {rng.uniform(-0.02, 0.02):.4f}, closed_ends: true}}
vehicles:
{start_on_arc(k, 6)}{start_on_arc(k, 9)}rounds:
  - {{anchor: v1, routes: {{v2: {route(9, half)}}}}}
  - {{anchor: v2, routes: {{v1: {route(6, half - 4)}}}}}
  - {{anchor: v1, routes: {{v2: {route(half, length_m)}}}}}
uwb: {{max_range_m: 400}}
motion: {{speed_mps: 1.0, standstill_s: 6}}
"""


def bend_scene(seed):
    """A bare tunnel or pipe with a tight bend: two vehicles, one behind the other, in three rounds."""
    rng = random.Random(seed)
    k = rng.choice([-1, 1]) / rng.uniform(60, 200)
    shape = rng.choice(["round: true, roughness_m: 0", "wall_height_m: 1.5, roughness_m: 0.006"])
    ends = rng.choice(["true", "false"])
    side = rng.uniform(-0.6, 0.6)

    def route(begin, end):
        return route_on_arc(k, steps_of_4_m(begin, end), side)

    return f"""\
schema: 1
tunnel: {{length_m: 160, width_m: {rng.uniform(3.5, 7):.2f}, {shape}, curvature_per_m: {k:.6f},
  gradient: {rng.uniform(-0.03, 0.03):.4f}, closed_ends: {ends}}}
vehicles:
{start_on_arc(k, 6, side)}{start_on_arc(k, 9, side)}rounds:
  - {{anchor: v1, routes: {{v2: {route(9, 50)}}}}}
  - {{anchor: v2, routes: {{v1: {route(6, 46)}}}}}
  - {{anchor: v1, routes: {{v2: {route(50, 90)}}}}}
  - {{anchor: v2, routes: {{v1: {route(46, 86)}}}}}
uwb: {{max_range_m: 400}}
motion: {{speed_mps: 1.0, standstill_s: 6}}
"""


# scene, seconds of data (0: all), whether the map is compared unfiltered with the mesh
CASES = {
    "corridor": (corridor_scene, 171, False),
    "portal": (portal_scene, 0, False),
    "leap_frog": (leap_frog_scene, 1050, False),
    "bent_return": (bent_return_scene, 0, False),
    "pipe": (pipe_scene, 0, False),
    "bend": (bend_scene, 0, False),
    "pair_corridor": (pair_corridor_scene, 150, True),
    "single_corridor": (shipped("corridor"), 80, True),
    "floor": (shipped("floor"), 90, True),
    "middle": (middle_scene, 0, False),
    "fleet_floor": (shipped("floor", 3), 90, True),
    "kilometre": (kilometre_scene, 0, False),
    **{f"single_{scene}": (shipped(scene), 120, False)
       for scene in ("loop", "yard", "garage", "mine", "ramp", "hall", "warehouse")},
}


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(str(c) for c in command)}\n{done.stderr}")
    return done.returncode


def first_poses(truth):
    """Position and yaw of each vehicle's first true pose."""
    out = {}
    for path in sorted(truth.glob("*.tum")):
        for line in path.read_text().splitlines():
            if line.startswith("#"):
                continue
            _, x, y, z, qx, qy, qz, qw = (float(word) for word in line.split())
            yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
            out[path.stem] = (np.array([x, y, z]), yaw)
            break
    return out


def priors_text(truth, seed, reverse):
    """Start poses by tape and eye: sigma 0.1 m and 3 degrees, relative to v1 (or of v1)."""
    rng = random.Random(1000 + seed)
    poses = first_poses(truth)
    if len(poses) < 2:
        return ""
    text = "priors:\n"
    names = list(poses)
    for name in names[1:]:
        a, b = (name, names[0]) if reverse else (names[0], name)  # of b in a
        (p, yaw), (q, yaw_b) = poses[a], poses[b]
        d = q - p
        c, s = math.cos(yaw), math.sin(yaw)
        x = c * d[0] + s * d[1] + rng.gauss(0, 0.1)
        y = -s * d[0] + c * d[1] + rng.gauss(0, 0.1)
        turn = math.degrees(math.remainder(yaw_b - yaw, 2 * math.pi)) + rng.gauss(0, 3)
        text += (f"  - {{vehicle: {b}, relative_to: {a}, xyz_m: [{x:.2f}, {y:.2f}, {d[2]:.2f}], "
                 f"yaw_deg: {turn:.1f}, sigma_m: 0.1, sigma_deg: 3}}\n")
    return text


def is_whole(recording):
    """An interrupted simulation leaves a folder, too."""
    path = recording / "simulation.json"
    return path.exists() and json.loads(path.read_text()).get("status") == "complete"


def recorded(args, case, seed, duration_s=None):
    """The recording of a case, simulated if it is not in the folder yet.

    duration_s: of the data, instead of the case's own.
    """
    scene, own_duration_s, _ = CASES[case]
    name = f"{case}_{seed}" if duration_s is None else f"{case}_{duration_s}s_{seed}"
    duration_s = own_duration_s if duration_s is None else duration_s
    recording = pathlib.Path(args.folder) / "recordings" / name
    if not is_whole(recording):
        recording.parent.mkdir(parents=True, exist_ok=True)
        path = recording.with_suffix(".yaml")
        path.write_text(scene(seed))
        run([args.rali, "simulate", path, "--seed", seed, "--duration", duration_s, "-o", recording,
             "--overwrite", "-q", "--no-priors"])
    return recording


def fleet_file(args, recording, seed):
    text = (recording / "fleet.yaml").read_text()
    if args.noise != "none":
        words = DATA_SHEET
        if args.noise != "sheet":
            accel, gyro = args.noise.split(",")
            words = f"noise: {{accel_mps2_rthz: {accel}, gyro_radps_rthz: {gyro}}}, "
        text = text.replace("    imu: {", "    imu: {" + words)
    if args.priors != "none":
        text += priors_text(recording / "truth", seed, args.priors == "reverse")
    name = f"case_{args.noise}_{args.priors}.yaml".replace(",", "_")
    (recording / name).write_text(text)
    return recording / name


def tum(path):
    rows = [line.split() for line in path.read_text().splitlines() if not line.startswith("#")]
    return np.array(rows, dtype=float).reshape(-1, 8)


def truth_at(truth, stamps):
    return np.column_stack([np.interp(stamps, truth[:, 0], truth[:, k]) for k in (1, 2, 3)])


def aligned(estimate, truth):
    """The rigid motion that lays the estimated positions on the true ones (Umeyama, no scale)."""
    a, b = estimate.mean(0), truth.mean(0)
    u, _, vt = np.linalg.svd((truth - b).T @ (estimate - a))
    d = np.diag([1, 1, np.sign(np.linalg.det(u @ vt))])
    rotation = u @ d @ vt
    return (estimate - a) @ rotation.T + b


def along_errors(folder, truth_folder, kind):
    """Errors along the true direction of travel under one alignment for all, by vehicle."""
    parts = []
    for path in sorted((folder / kind).glob("*.tum")):
        estimate = tum(path)
        truth = tum(truth_folder / path.name)
        inside = (estimate[:, 0] >= truth[0, 0]) & (estimate[:, 0] <= truth[-1, 0])
        estimate = estimate[inside]
        if len(estimate) < 3:
            continue
        at = truth_at(truth, estimate[:, 0])
        ahead = truth_at(truth, estimate[:, 0] + 0.5) - truth_at(truth, estimate[:, 0] - 0.5)
        parts.append((path.stem, estimate[:, 1:4], at, ahead))
    if not parts:
        return {}
    both = aligned(np.vstack([p[1] for p in parts]), np.vstack([p[2] for p in parts]))
    out, begin = {}, 0
    for name, estimate, at, ahead in parts:
        error = both[begin:begin + len(estimate)] - at
        begin += len(estimate)
        speed = np.linalg.norm(ahead, axis=1)
        moving = speed > 0.2
        if moving.any():
            along = (error[moving] * ahead[moving]).sum(1) / speed[moving]
            out[name] = math.sqrt((along ** 2).mean())
    return out


def odom_step(path):
    """The largest change of speed from scan to scan, as a step [m] (REP-105: no jumps)."""
    poses = tum(path)
    if len(poses) < 3:
        return 0.0
    dt = np.diff(poses[:, 0])
    v = np.diff(poses[:, 1:4], axis=0) / dt[:, None]
    ok = (dt[1:] < 0.25) & (dt[:-1] < 0.25)
    step = np.linalg.norm(np.diff(v, axis=0), axis=1) * dt[1:]
    return float(step[ok].max()) if ok.any() else 0.0


def steps_of(path):
    rows = [line.split(",") for line in path.read_text().splitlines()[1:]]
    sizes = [float(r[1]) for r in rows if r[3].strip() != "joined"]
    return max(sizes, default=0.0)


def drop_big_files(out):
    """Clouds and messages, once they are evaluated."""
    for big in ("keyframes", "map.pcd", "map.ply", "removed.pcd", "session.mcap"):
        path = out / big
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)


def judged(args, case, seed):
    recording = recorded(args, case, seed)
    fleet = fleet_file(args, recording, seed)
    out = pathlib.Path(args.folder) / "out" / f"{case}_{seed}_{args.name}"
    mesh = CASES[case][2]
    command = [args.rali, "map", fleet, "-o", out, "--overwrite", "-q", "--preset", args.preset]
    for setting in args.set:
        command += ["--set", setting]
    if mesh:
        command += ["--set", "map.dynamic.remove=false"]
    code = run(command)
    command = [args.rali, "evaluate", out, "--truth", recording / "truth", "-q"]
    run(command)
    result = json.loads((out / "evaluation.json").read_text())
    metrics = json.loads((out / "metrics.json").read_text())
    figures = {"exit": float(code)}
    figures["frames"] = float(len(metrics["fleet"]["groups"])) if metrics.get("fleet") else 1.0
    for kind, name in (("trajectory", "APE m"), ("live", "live APE m"), ("odometry", "odometry APE m")):
        track = result["fleet"].get(kind)
        if track:
            figures[name] = track["ape_m"]["rmse"]
            if kind != "odometry":
                figures[name + " max"] = track["ape_m"]["max"]
    for kind, name in (("trajectory", "along m"), ("live", "live along m")):
        values = along_errors(out, recording / "truth", kind)
        if values:
            figures[name] = max(values.values())
    tracks = [v[k] for v in result["vehicles"].values() for k in ("trajectory",) if v.get(k)]
    nees = [t["nees_position"]["mean"] / t["nees_position"]["dof"] for t in tracks
            if t.get("nees_position")]
    if nees:
        figures["NEES/dof"] = sum(nees) / len(nees)
    figures["sigma max m"] = max(v["sigma_max_m"] for v in metrics["vehicles"].values())
    figures["odom step m"] = max(odom_step(p) for p in (out / "odometry").glob("*.tum"))
    figures["map step m"] = max((steps_of(p) for p in (out / "live").glob("*.steps.csv")), default=0.0)
    ranges = metrics.get("ranges") or {}
    if ranges.get("total"):
        figures["ranges"] = float(ranges["total"])
        figures["used"] = float(ranges["used"])
    cloud = (result.get("cloud") or {}).get("to_mesh")
    if cloud:
        figures["to mesh m"] = cloud["mean_m"]
        figures["complete"] = cloud["completeness"]
    drop_big_files(out)
    if args.forget:
        shutil.rmtree(recording)
    return figures


def seeds_of(text):
    seeds = []
    for part in text.split(","):
        low, _, high = part.partition("-")
        seeds += range(int(low), int(high or low) + 1)
    return seeds


def row(values):
    values = sorted(values)
    n = len(values)
    median = values[n // 2] if n % 2 else 0.5 * (values[n // 2 - 1] + values[n // 2])
    return f"{median:.4g} / {values[-1]:.4g}"


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rali", default="build/release/bin/rali")
    parser.add_argument("--folder", default="/tmp/cases")
    parser.add_argument("--cases", default="corridor,portal")
    parser.add_argument("--seeds", default="1-3")
    parser.add_argument("--preset", default="robust")
    parser.add_argument("--noise", default="none", help="none, sheet, or ACCEL,GYRO per rtHz")
    parser.add_argument("--priors", default="given", help="given, reverse (v1 relative to the others) or none")
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    parser.add_argument("--name", default="out", help="of the output folders")
    parser.add_argument("--forget", action="store_true", help="remove recordings after use")
    parser.add_argument("--each", action="store_true", help="print each seed, too")
    parser.add_argument("--list", action="store_true", help="only say what the cases are")
    args = parser.parse_args()
    if args.list:
        for name, (scene, duration_s, _) in CASES.items():
            print(f"{name}, {duration_s or 'all'} s\n{scene(1)}")
        return
    for case in args.cases.split(","):
        table = {}
        for seed in seeds_of(args.seeds):
            figures = judged(args, case, seed)
            if args.each:
                print(case, seed, json.dumps({k: round(v, 4) for k, v in figures.items()}), flush=True)
            for name, value in figures.items():
                table.setdefault(name, []).append(value)
        print(f"{case}, preset {args.preset}, noise {args.noise}, priors {args.priors} "
              f"{' '.join(args.set)}, seeds {args.seeds}, median / worst")
        print("| " + " | ".join(table) + " |\n|" + "---|" * len(table))
        print("| " + " | ".join(row(v) for v in table.values()) + " |\n", flush=True)


if __name__ == "__main__":
    main()
