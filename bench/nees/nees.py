#!/usr/bin/env python3
"""Are the errors that rali states true? Simulates, maps and evaluates, and prints NEES.

One row per kind of fleet, live or final poses, position or full pose: mean NEES per degree of
freedom (honest: 1) over all vehicles and seeds, and how many of the single trajectories lie outside
0.2 to 4. Recordings are kept in the folder and used again. Usage:
    nees.py --rali build/release/bin/rali --folder /tmp/nees --seeds 5
    nees.py ... --kinds single,tunnel --set odometry.robust.drift.growth=1
"""

import argparse
import json
import math
import pathlib
import shutil
import subprocess
import sys

TUNNEL = """\
schema: 1
tunnel: {length_m: 215, width_m: 6, wall_height_m: 1.5, roughness_m: 0.008}
vehicles:
  - {start: [0.0, 1.0], yaw_deg: 0}
  - {start: [0.0, -1.9], yaw_deg: 0}
rounds:
  - {anchor: v1, routes: {v2: [[2, -1.2], [8, -0.3], [200, 0]]}}
uwb: {max_range_m: 400}
motion: {speed_mps: 1.0, standstill_s: 6}
"""
KINDS = ("single", "lidar-only", "fleet", "tunnel")
LOW, HIGH = 0.2, 4.0


def scene_of(kind, seed, folder):
    """Scene, vehicles, seed of the simulation and seconds: corridors for three seeds of five."""
    corridor = seed % 5 in (1, 2, 3)
    if kind == "tunnel":
        path = folder / "tunnel.yaml"
        path.write_text(TUNNEL)
        return str(path), 2, 20 + seed, 80
    if kind == "fleet":
        return ("corridor", 2, 10 + seed, 70) if corridor else ("floor", 3, 10 + seed, 70)
    return ("corridor" if corridor else "floor"), 1, seed, 70


def run(command):
    done = subprocess.run([str(c) for c in command], capture_output=True, text=True, check=False)
    if done.returncode not in (0, 3):
        sys.exit(f"{' '.join(str(c) for c in command)}\n{done.stderr}")


def recorded(args, kind, seed):
    """The folder of the recording; LiDAR alone takes that of the single vehicle."""
    folder = pathlib.Path(args.folder)
    name = "single" if kind == "lidar-only" else kind
    recording = folder / "recordings" / f"{name}_{seed}"
    if not (recording / "simulation.json").exists():
        scene, vehicles, sim_seed, duration_s = scene_of(kind, seed, folder)
        command = [args.rali, "simulate", scene, "--seed", sim_seed, "--duration", duration_s]
        if kind != "tunnel":
            command += ["--vehicles", vehicles]
        run(command + ["-o", recording, "--overwrite", "-q"])
    return recording


def without_imu(fleet):
    """A fleet.yaml beside `fleet` that uses the LiDAR alone."""
    path = fleet.with_name("lidar_only.yaml")
    path.write_text(fleet.read_text().replace("imu: {T_body", "imu: {topic: none, T_body"))
    return path


def evaluated(args, kind, seed):
    """evaluation.json of one run."""
    recording = recorded(args, kind, seed)
    fleet = recording / "fleet.yaml"
    if kind == "lidar-only":
        fleet = without_imu(fleet)
    out = pathlib.Path(args.folder) / "out" / f"{kind}_{seed}"
    settings = [word for key_value in args.set for word in ("--set", key_value)]
    run([args.rali, "map", fleet, "-o", out, "--overwrite", "-q", *settings])
    run([args.rali, "evaluate", out, "--truth", recording / "truth", "-q"])
    result = json.loads((out / "evaluation.json").read_text())
    for big in ("keyframes", "map.pcd", "map.ply", "removed.pcd", "session.mcap"):
        path = out / big
        shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    return result


def per_dof(track, which):
    """Mean NEES per degree of freedom; nothing where all poses hold the gauge."""
    score = track and track[f"nees_{which}"]
    return score["mean"] / score["dof"] if score else None


def add(table, kind, seed, result):
    for name, vehicle in result["vehicles"].items():
        for track in ("live", "trajectory"):
            for which in ("position", "pose"):
                value = per_dof(vehicle[track], which)
                if value is None:
                    continue
                key = (kind, "final" if track == "trajectory" else track, which)
                table.setdefault(key, []).append((seed, name, value))


def print_table(table):
    print("| kind | poses | of | trajectories | NEES/dof, mean | geometric | outside 0.2 to 4 |")
    print("|---|---|---|---|---|---|---|")
    for (kind, poses, of), values in table.items():
        numbers = [v for _, _, v in values]
        mean = sum(numbers) / len(numbers)
        geometric = math.exp(sum(math.log(max(v, 1e-9)) for v in numbers) / len(numbers))
        outside = [f"{n} {s}: {v:.2g}" for s, n, v in values if not LOW <= v <= HIGH]
        print(f"| {kind} | {poses} | {of} | {len(numbers)} | {mean:.2f} | {geometric:.2f} | "
              f"{100 * len(outside) / len(numbers):.0f} % {'; '.join(outside)} |")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--rali", default="build/release/bin/rali")
    parser.add_argument("--folder", default="/tmp/nees")
    parser.add_argument("--seeds", type=int, default=5, help="1 to this one")
    parser.add_argument("--kinds", default=",".join(KINDS))
    parser.add_argument("--set", action="append", default=[], metavar="KEY=VALUE")
    args = parser.parse_args()
    table = {}
    for kind in args.kinds.split(","):
        for seed in range(1, args.seeds + 1):
            add(table, kind, seed, evaluated(args, kind, seed))
            print(f"{kind} {seed} done", file=sys.stderr)
    print_table(table)


if __name__ == "__main__":
    main()
