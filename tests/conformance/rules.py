#!/usr/bin/env python3
"""rules.py RUN: what evo and Nav2's map_server read, checked by their written rules.

Neither program is in Debian 12, so this is no proof by the programs themselves. The rules are those
of evo's file_interface.read_tum_trajectory_file and its PoseTrajectory3D.check, and of map_server's
map_io (`nav2_map_server/README.md`). `selftest` as RUN runs hand-made good and bad examples.
"""

import math
import re
import sys
import tempfile
from pathlib import Path


def tum_faults(text):
    """evo: rows of 8 numbers by one blank, `#` starts a comment; ascending stamps; unit quaternions."""
    rows = [line for line in text.split("\n") if line and not line.startswith("#")]
    if not rows:
        return ["no pose"]
    faults, last = [], -math.inf
    for number, line in enumerate(rows, 1):
        fields = line.split(" ")
        try:
            values = [float(field) for field in fields]
        except ValueError:
            values = []
        if len(values) != 8 or not all(map(math.isfinite, values)):
            faults.append(f"row {number}: not 8 finite numbers parted by one blank")
            continue
        if values[0] <= last:
            faults.append(f"row {number}: its stamp does not ascend")
        if abs(math.sqrt(sum(q * q for q in values[4:])) - 1.0) > 1e-3:
            faults.append(f"row {number}: no unit quaternion x y z w")
        last = values[0]
    return faults


def grid_faults(folder, name):
    """map_server: keys of the YAML; an 8-bit binary PGM beside it; thresholds in order."""
    keys = dict(re.findall(r"^(\w+): *(.*?)\s*$", (folder / name).read_text(), re.M))
    faults = [f"no key {key}" for key in ("image", "resolution", "origin", "negate", "occupied_thresh",
                                          "free_thresh") if key not in keys]
    if faults:
        return faults
    if not float(keys["resolution"]) > 0.0:
        faults.append("the resolution is not positive")
    origin = re.fullmatch(r"\[(.*),(.*),(.*)\]", keys["origin"])
    if not origin or not all(math.isfinite(float(v)) for v in origin.groups()):
        faults.append("the origin is not [x, y, yaw]")
    if keys["negate"] not in ("0", "1", "true", "false"):
        faults.append("negate is no boolean")
    if not 0.0 <= float(keys["free_thresh"]) < float(keys["occupied_thresh"]) <= 1.0:
        faults.append("free_thresh is not below occupied_thresh")
    if keys.get("mode", "trinary") not in ("trinary", "scale", "raw"):
        faults.append("mode is unknown")
    image = (folder / keys["image"].strip("\"'")).read_bytes()
    head = re.match(rb"P5\s+(?:#.*\n)*(\d+)\s+(\d+)\s+(\d+)\s", image)
    if not head or int(head[3]) != 255:
        return faults + ["the image is no 8-bit P5"]
    if len(image) - head.end() != int(head[1]) * int(head[2]):
        faults.append("the image has not width times height bytes")
    return faults


def check_run(folder):
    out = []
    paths = sorted(path for place in ("trajectory", "odometry", "live")
                   for path in (folder / place).glob("*.tum"))
    out += [f"{path}: {fault}" for path in paths for fault in tum_faults(path.read_text())]
    out += [f"map_2d.yaml: {fault}" for fault in grid_faults(folder, "map_2d.yaml")]
    print("\n".join(out) or f"{len(paths)} trajectories and map_2d keep the rules")
    return 1 if out or not paths else 0


def selftest():
    good = "# x\n1.0 0 0 0 0 0 0 1\n1.1 1 0 0 0 0 0.6 0.8\n"
    assert not tum_faults(good)
    for bad in ("", "1,0,0,0,0,0,0,1\n", "1 0 0 0 0 0 1\n", "1  0 0 0 0 0 0 1\n", "1 nan 0 0 0 0 0 1\n",
                good + "1.1 0 0 0 0 0 0 1\n", "1 0 0 0 0 0 0 2\n"):
        assert tum_faults(bad), bad
    text = ("image: m.pgm\nresolution: 0.05\norigin: [-1.0, 2.0, 0.0]\nnegate: 0\n"
            "occupied_thresh: 0.65\nfree_thresh: 0.25\n")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)

        def faults(yaml=text, image=b"P5\n2 2\n255\n\x00\x01\x02\x03"):
            (folder / "m.yaml").write_text(yaml)
            (folder / "m.pgm").write_bytes(image)
            return grid_faults(folder, "m.yaml")

        assert not faults()
        for old, new in (("0.05", "0"), ("negate: 0\n", ""), ("0.25", "0.7"), (", 0.0]", "]"),
                         ("negate: 0", "negate: 2"), ("image", "mode: other\nimage")):
            assert faults(text.replace(old, new)), new
        assert faults(image=b"P2\n2 2\n255\n0 1 2 3") and faults(image=b"P5\n2 2\n255\n\x00")
    print("good examples are accepted, bad ones refused")
    return 0


if __name__ == "__main__":
    sys.exit(selftest() if sys.argv[1] == "selftest" else check_run(Path(sys.argv[1])))
