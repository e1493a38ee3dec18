#!/usr/bin/env python3
"""Maps a recording and plots it against a ground truth.

usage: compare.py INPUT [TRUTH] [-o OUT]

INPUT is a recording or a fleet.yaml, TRUTH a folder with <vehicle>.tum. Writes the results of
`rali map` and OUT/compare.png (needs matplotlib). With evo installed, its APE is printed beside ours.
"""

import argparse
import sys
from pathlib import Path

import numpy as np

import rali


def print_progress(state):
    print(f"\r{state.vehicle} {state.stage} {100 * state.fraction:3.0f} %", end="", file=sys.stderr)


def evo_ape(truth, estimate):
    """RMSE of evo's APE after alignment [m], or None without evo."""
    try:
        from evo.core import metrics, sync
        from evo.tools import file_interface
    except ImportError:
        return None
    reference = file_interface.read_tum_trajectory_file(str(truth))
    trajectory = file_interface.read_tum_trajectory_file(str(estimate))
    reference, trajectory = sync.associate_trajectories(reference, trajectory)
    trajectory.align(reference)
    ape = metrics.APE(metrics.PoseRelation.translation_part)
    ape.process_data((reference, trajectory))
    return ape.get_statistic(metrics.StatisticsType.rmse)


def plot(out, vehicles, truth, alignment):
    import matplotlib.pyplot as plt

    figure, (above, errors) = plt.subplots(1, 2, figsize=(12, 5))
    cloud = rali.read_map(out / "map.pcd").xyz_m[::10]
    above.scatter(cloud[:, 0], cloud[:, 1], s=0.2, color="0.8")
    for name in vehicles:
        trajectory = rali.read_trajectory(out / "trajectory" / f"{name}.tum")
        position = trajectory.poses[:, :3, 3]
        time_s = (trajectory.stamp_ns - trajectory.stamp_ns[0]) * 1e-9
        above.plot(position[:, 0], position[:, 1], label=name)
        sigma_m = np.sqrt(np.trace(trajectory.covariances[:, :3, :3], axis1=1, axis2=2))
        errors.plot(time_s, sigma_m, label=f"{name}: expected, 1 sigma")
        table = out / "errors" / f"{name}.csv"
        if truth and table.exists():
            judged = np.genfromtxt(table, delimiter=",", names=True)
            errors.plot(judged["stamp_s"] - judged["stamp_s"][0], judged["ape_m"],
                        label=f"{name}: measured ({alignment})")
    above.set(xlabel="x [m]", ylabel="y [m]", aspect="equal", title="map from above")
    errors.set(xlabel="time [s]", ylabel="position error [m]", title="error")
    above.legend()
    errors.legend()
    figure.tight_layout()
    figure.savefig(out / "compare.png", dpi=120)
    print(out / "compare.png")


def main():
    parser = argparse.ArgumentParser(description="Map a recording, compare, plot.")
    parser.add_argument("input")
    parser.add_argument("truth", nargs="?")
    parser.add_argument("-o", "--out", default="out", type=Path)
    arguments = parser.parse_args()
    summary = rali.map(arguments.input, out=arguments.out, progress=print_progress)
    print(file=sys.stderr)
    names = [vehicle.name for vehicle in summary.vehicles]
    for vehicle in summary.vehicles:
        print(f"{vehicle.name}: {vehicle.distance_m:.1f} m, expected error"
              f" {vehicle.sigma_median_m:.2f} m")
    if arguments.truth:
        evaluation = rali.evaluate(arguments.out, arguments.truth)
        print(evaluation)
        for name in names:
            rmse_m = evo_ape(Path(arguments.truth) / f"{name}.tum",
                             arguments.out / "trajectory" / f"{name}.tum")
            print(f"evo, APE of {name} [m]: "
                  + ("not installed" if rmse_m is None else f"{rmse_m:.4f}"))
    try:
        import matplotlib  # noqa: F401
    except ImportError:
        print("no plot: matplotlib is not installed (Debian: python3-matplotlib)")
    else:
        plot(arguments.out, names, arguments.truth, "se3")


if __name__ == "__main__":
    try:
        main()
    except rali.InputError as error:
        sys.exit(str(error))
