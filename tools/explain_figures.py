#!/usr/bin/env python3
"""Draws the figures of docs/explain as SVG; needs python3-matplotlib and python3-numpy.

usage: explain_figures.py REPOSITORY

Curves are computed from the formulas of the pages, measured points are read from CSV files beside
the figures. Same libraries, same bytes.
"""

import csv
import sys
from pathlib import Path

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (the backend is chosen first)
import numpy as np  # noqa: E402

# Okabe and Ito: distinguishable with any colour vision.
BLUE, ORANGE, GREEN, RED, GREY = "#0072B2", "#E69F00", "#009E73", "#D55E00", "#666666"
STYLE = {
    "svg.hashsalt": "rali", "svg.fonttype": "none", "font.size": 9, "axes.spines.top": False,
    "axes.spines.right": False, "legend.frameon": False, "font.family": "sans-serif",
}


def save(figure, path):
    figure.tight_layout()
    figure.savefig(path, metadata={"Date": None})
    plt.close(figure)


def information_ratio(rng, facing, scans=400, planes=300, tilt_rad=np.radians(1.0)):
    """I/B along d of walls parallel to d and of planes whose normals have the given n.d.

    All normals are estimated with the same sigma; unit weights, so that they cancel in the ratio.
    """
    true_cosines = np.concatenate([np.zeros(planes), facing])
    noise = rng.normal(0.0, tilt_rad, (scans, true_cosines.size))
    information = np.sum((true_cosines + noise) ** 2, axis=1)
    return information / (true_cosines.size * tilt_rad**2)


def draw_information(path):
    rng = np.random.default_rng(1)
    cases = [
        ("smooth tunnel", [], RED),
        ("tunnel with a person: 3 planes, n.d = 0.3", [0.3] * 3, ORANGE),
        ("tunnel with a niche: 2 planes, n.d = 0.7", [0.7] * 2, GREEN),
        ("corridor with 6 door frames, n.d = 1", [1.0] * 6, BLUE),
    ]
    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    bins = np.geomspace(0.6, 120, 90)
    for label, facing, colour in cases:
        axes.hist(information_ratio(rng, np.array(facing)), bins, color=colour, label=label,
                  histtype="stepfilled")
    axes.set_ylim(0, 520)  # room for the legend
    for limit, name in ((2, "kappa 2, with support"), (5, "kappa 5")):
        axes.axvline(limit, color=GREY, linestyle="--")
        axes.text(limit * 1.04, axes.get_ylim()[1], name, color=GREY, va="top", rotation=90,
                  fontsize=7)
    axes.set_xscale("log")
    axes.set_xlabel("I/B: information along the axis / what noise alone contributes")
    axes.set_ylabel("scans")
    axes.legend(loc="upper right")
    save(figure, path)


def draw_detectors(path, data):
    with open(data, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    colours = dict(zip(dict.fromkeys(row["detector"] for row in rows),
                       (BLUE, GREEN, ORANGE, GREY, RED)))
    figure, axes = plt.subplots(figsize=(6.4, 3.0))
    for row in rows:
        first = row["rings"] == "16"
        axes.scatter(100 * float(row["false_alarms"]), 100 * float(row["detected"]),
                     marker={"16": "o", "32": "s", "64": "^"}[row["rings"]],
                     color=colours[row["detector"]], label=row["detector"] if first else None)
    axes.set_xlabel("good scans reported as degenerate [%]")
    axes.set_title("circle 16, square 32, triangle 64 rings", fontsize=8)
    axes.set_ylabel("degenerate scans detected [%]")
    axes.legend(loc="center left", bbox_to_anchor=(1.0, 0.5))
    save(figure, path)


def draw_range_geometry(path):
    """Sigma of the position along the axis by one range of 0.1 m, at the lateral offset given."""
    figure, axes = plt.subplots(figsize=(6.4, 2.8))
    x_m = np.linspace(-30, 30, 1201)
    for lateral_m, colour in ((1.0, BLUE), (3.0, ORANGE)):
        cosine = np.abs(x_m) / np.hypot(x_m, lateral_m)
        axes.plot(x_m, 0.1 / np.maximum(cosine, 1e-3), color=colour,
                  label=f"lateral offset {lateral_m:.0f} m")
    axes.set_ylim(0, 1)
    axes.set_xlabel("position along the axis, the anchor at 0 [m]")
    axes.set_ylabel("sigma along the axis [m]")
    axes.legend()
    save(figure, path)


def weight(d):
    """range_gate.cpp with a clear line of sight: Huber within two sigma, one-sided beyond."""
    def cauchy(r, scale):
        return 1.0 / (1.0 + (r / scale) ** 2)
    one_sided = np.where(d > 0, cauchy(d, 1.5) ** 2, cauchy(d, 2.5))
    inside = np.abs(d) <= 2.0
    return np.where(d * d > 10.83, 0.0, np.where(inside, 1.0, one_sided))


def draw_range_weights(path):
    d = np.linspace(-4, 4, 1601)
    figure, axes = plt.subplots(figsize=(6.4, 2.6))
    axes.plot(d, weight(d), color=BLUE)
    axes.set_xlabel("innovation / its sigma   (right: the range is too long)")
    axes.set_ylabel("weight")
    save(figure, path)


def draw_frames(path):
    steps = [("odometry", "each vehicle in a frame\nof its own: odom"),
             ("1 frames", "ranges, start poses and\nplaces decide T; only one\nhypothesis may fit"),
             ("2 paths", "one graph: steps along\nobserved directions, each\nrange once, gravity"),
             ("3 loop closures", "submaps compared; walls,\npaths and all others\nmust agree"),
             ("4 map", "keyframes at their poses,\nmoving objects removed")]
    figure, axes = plt.subplots(figsize=(8.6, 1.9))
    axes.set_axis_off()
    axes.set_xlim(0, len(steps))
    axes.set_ylim(0, 1)
    for i, (title, text) in enumerate(steps):
        axes.add_patch(plt.Rectangle((i + 0.03, 0.2), 0.88, 0.75, fill=False, edgecolor=BLUE))
        axes.text(i + 0.47, 0.84, title, ha="center", va="center", weight="bold")
        axes.text(i + 0.47, 0.48, text, ha="center", va="center", fontsize=7)
        if i + 1 < len(steps):
            axes.annotate("", (i + 1.03, 0.57), (i + 0.91, 0.57), arrowprops={"arrowstyle": "->"})
    axes.plot([3.47, 3.47, 1.47], [0.2, 0.1, 0.1], color=RED, linewidth=1)
    axes.annotate("", (1.47, 0.2), (1.47, 0.09), arrowprops={"arrowstyle": "->", "color": RED})
    axes.text(2.47, 0.08, "loops that disprove a frame", color=RED, fontsize=8, ha="center", va="top")
    save(figure, path)


def main(root):
    images = Path(root) / "docs" / "images"
    plt.rcParams.update(STYLE)
    draw_information(images / "degeneracy_information.svg")
    draw_detectors(images / "degeneracy_detectors.svg", images / "degeneracy_detectors.csv")
    draw_range_geometry(images / "range_geometry.svg")
    draw_range_weights(images / "range_weights.svg")
    draw_frames(images / "frames_joined.svg")


if __name__ == "__main__":
    main(sys.argv[1])
