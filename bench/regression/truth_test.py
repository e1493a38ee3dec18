#!/usr/bin/env python3
"""Tests of truth.py, runs.py and measured.py on outputs made by hand. Needs python3-numpy."""

import json
import math
import struct
import subprocess
import sys
import tempfile
import unittest
from pathlib import Path

import numpy as np

import coverage
import runs
import truth

HERE = Path(__file__).resolve().parent


def track_text(points, yaw=0.0):
    """TUM lines of (t, x, y), level, with one heading."""
    q = f"0 0 {math.sin(yaw / 2)} {math.cos(yaw / 2)}"
    return "# t x y z qx qy qz qw\n" + "".join(f"{t} {x} {y} 0 {q}\n" for t, x, y in points)


class TruthTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.out, self.true = Path(folder.name) / "out", Path(folder.name) / "truth"

    def write(self, path, text):
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def both(self, name, estimate, true, yaw=0.0):
        self.write(self.out / "trajectory" / f"{name}.tum", track_text(estimate, yaw))
        self.write(self.true / f"{name}.tum", track_text(true))

    def test_a_pose_between_two_is_on_the_line(self):
        track = np.array([[0, 0, 0, 0, 0, 0, 0, 1], [1, 2, 0, 0, 0, 0, 1, 0]], dtype=float)
        T = truth.pose_at(track, 0.5)
        np.testing.assert_allclose(T[:3, 3], [1, 0, 0])
        np.testing.assert_allclose(truth.rotation_vector(T[:3, :3]), [0, 0, math.pi / 2], atol=1e-12)
        self.assertIsNone(truth.pose_at(track, 1.1))

    def test_a_frame_is_wrong_beyond_half_a_metre_or_five_degrees(self):
        line = [(0, 0, 0), (1, 1, 0)]
        beside = [(0, 5, 3), (1, 6, 3)]
        self.both("v1", line, line)
        for shift, yaw_deg, wrong in ((0.0, 0, 0), (0.4, 0, 0), (0.6, 0, 1), (0.0, 4, 0), (0.0, 6, 1)):
            with self.subTest(shift=shift, yaw_deg=yaw_deg):
                moved = [(t, x + shift, y) for t, x, y in beside]
                self.both("v2", moved, beside, math.radians(yaw_deg))
                self.assertEqual(wrong, truth.wrong_frames(self.out, self.true, ["v1", "v2"]))

    def test_a_shift_of_the_whole_map_is_no_wrong_frame(self):
        line = [(0, 0, 0), (1, 1, 0)]
        for name in ("v1", "v2"):
            self.both(name, [(t, x + 7, y) for t, x, y in line], line)
        self.assertEqual(0, truth.wrong_frames(self.out, self.true, ["v1", "v2"]))

    def loop(self, x, sigma_x):
        """A loop from v1 at 0 s to v2 at 1 s that is 2 m ahead; `x` is what it measured."""
        covariance = np.diag([sigma_x ** 2, 1e-4, 1e-4, 1e-6, 1e-6, 1e-6])
        cells = " ".join(str(c) for c in covariance[np.triu_indices(6)])
        self.write(self.out / "graph.pyfg",
                   "VERTEX_SE3:QUAT 0.0 A0 0 0 0 0 0 0 1\nVERTEX_SE3:QUAT 1.0 B3 0 0 0 0 0 0 1\n"
                   f"EDGE_SE3:QUAT 1.0 A0 B3 {x} 0 0 0 0 0 1 {cells}\n"
                   "EDGE_RANGE 1.0 A0 B3 2.0 0.01\n")
        self.write(self.out / "loops.csv",
                   "stamp_from_s,vehicle_from,stamp_to_s,vehicle_to,accepted,reason,score,shift_m\n"
                   "0.0,v1,1.0,v2,1,accepted,0.9,0.1\n0.0,v1,0.5,v2,0,slid,0.9,0.1\n")
        self.write(self.true / "v1.tum", track_text([(0, 0, 0), (1, 0, 0)]))
        self.write(self.true / "v2.tum", track_text([(0, 2, 0), (1, 2, 0)]))
        return truth.wrong_loops(self.out, self.true, ["v1", "v2"])

    def test_a_loop_is_wrong_where_it_claims_to_know(self):
        self.assertEqual((1, 0), self.loop(2.2, 0.05))
        self.assertEqual((1, 1), self.loop(2.5, 0.05))
        self.assertEqual((1, 0), self.loop(2.5, 1.0))  # of this direction it claims nothing

    def test_nis_is_of_the_ranges_that_were_used(self):
        self.write(self.out / "ranges.csv", "residual_m,sigma_m,used\n0.2,0.1,1\n0.0,0.1,1\n9,0.1,0\n,,1\n")
        self.assertAlmostEqual(2.0, truth.nis(self.out))

    def ranges(self, used, obstructed="0", v1_moves=False):
        """Four ranges of v1 and v2 while v2 drives and is degenerate from 1 s on."""
        still = [(0, 0, 0), (3, 0, 0)]
        moving = [(0, 0, 0), (3, 3, 0)]
        self.write(self.true / "v1.tum", track_text(moving if v1_moves else still))
        self.write(self.true / "v2.tum", track_text(moving))
        stamps = (0.5, 1.2, 1.5, 1.8)
        self.write(self.out / "ranges.csv", "stamp_s,from,to,used,reason\n" + "".join(
            f"{t + 0.001},v1,v2,{u},{'used' if u else 'no_pose'}\n" for t, u in zip(stamps, used)))
        self.write(self.true / "ranges.csv", "stamp_s,from,to,distance_m,obstructed\n" + "".join(
            f"{t},v1,v2,1,{obstructed}\n" for t in stamps))
        for name in ("v1", "v2"):
            self.write(self.out / "degeneracy" / f"{name}.csv",
                       "stamp_s,degenerate\n1.0,0\n2.0,1\n3.0,1\n")
        return truth.applied_ranges(self.out, self.true, ["v1", "v2"])

    def test_ranges_count_while_the_driving_vehicle_is_degenerate_and_in_sight(self):
        self.assertAlmostEqual(2 / 3, self.ranges((1, 1, 0, 1)))
        self.assertIsNone(self.ranges((1, 1, 0, 1), obstructed="1"))
        self.assertIsNone(self.ranges((1, 1, 0, 1), v1_moves=True))

    def test_findings_are_counted_by_id(self):
        warnings = [{"id": "b"}, {"id": "a"}, {"id": "b"}]
        self.assertEqual("a:1 b:2", truth.findings({"warnings": warnings}))


class CoverageTest(unittest.TestCase):
    """A hall of 12 x 4 m whose inner wall at x = 6 has a door at y = 2 to 4, or none."""

    def write(self, folder, door, paths):
        walls = [((0, 0), (12, 0)), ((12, 0), (12, 4)), ((12, 4), (0, 4)), ((0, 4), (0, 0)),
                 ((6, 0), (6, 2.0 if door else 4.0))]
        points, faces = [], b""
        for (x, y), (u, v) in walls:
            n = len(points)
            points += [(x, y, 0), (u, v, 0), (u, v, 2), (x, y, 2)]
            for corners in ((n, n + 1, n + 2), (n, n + 2, n + 3)):
                faces += struct.pack("<B3if", 3, *corners, 0.5)
        head = (f"ply\nformat binary_little_endian 1.0\nelement vertex {len(points)}\n"
                f"element face {2 * len(walls)}\nend_header\n")
        body = b"".join(struct.pack("<3f", *p) for p in points)
        (folder / "mesh.ply").write_bytes(head.encode() + body + faces)
        for name, track in paths.items():
            (folder / f"{name}.tum").write_text(track_text(
                [(0.01 * i, x, y) for i, (x, y) in enumerate(track)]))

    def seen(self, door, paths):
        with tempfile.TemporaryDirectory() as name:
            self.write(Path(name), door, paths)
            return coverage.seen_fraction(Path(name))

    def test_a_room_without_a_door_is_not_asked_for(self):
        self.assertGreater(self.seen(False, {"v1": [(2, 2)] * 2}), 0.99)

    def test_a_second_room_is_missing_until_a_vehicle_looks_into_it(self):
        outside = [(1, 1)] * 2
        inside = outside + [(1 + 0.01 * i, 3) for i in range(900)]
        self.assertLess(self.seen(True, {"v1": outside}), 0.85)
        self.assertGreater(self.seen(True, {"v1": inside}), 0.99)
        self.assertGreater(self.seen(True, {"v1": outside, "v2": inside}), 0.99)

    def test_a_room_behind_walls_counts_if_a_vehicle_starts_in_it(self):
        self.assertGreater(self.seen(False, {"v1": [(2, 2)] * 2, "v2": [(9, 2)] * 2}), 0.99)


class RunsTest(unittest.TestCase):
    def test_a_mission_with_an_open_frontier_at_its_end_is_not_explored(self):
        with tempfile.TemporaryDirectory() as name:
            folder = Path(name)
            (folder / "rounds.csv").write_text("round,anchor\n1,v1\n2,v2\n")
            (folder / "traffic.csv").write_text("vehicle,kind,messages,bytes\nv1,a,1,10\nv2,a,1,5\n")
            for state, explored in (("explored", 1), ("open", 0)):
                (folder / "frontiers.csv").write_text(f"round,state\n1,open\n2,{state}\n")
                self.assertEqual({"rounds": 2, "explored": explored, "traffic_bytes": 15},
                                 runs.mission_figures(folder))

    def test_a_record_of_the_campaign_is_a_row(self):
        track = {"rmse_m": 0.2, "max_m": 0.5, "nees": 2.0}
        score = {"gaps": False, "lost": False, "silent": [{}], "ranges": 9, "ranges_used": 4,
                 "said": ["b", "a"], "error": "", "solvable_joint": True, "groups": 2,
                 "vehicles": [{"live": None, "final": track}, {"live": None, "final": track}]}
        line = runs.campaign_line({"score": score, "vehicles": 2, "cpu_mapped_s": 3.0})
        self.assertEqual((0, 1, 1, 2), tuple(line[k] for k in ("exit", "silent", "frames", "vehicles")))
        self.assertEqual((0.2, 0.5, 2.0), (line["ape_final_m"], line["ape_final_max_m"],
                                           line["nees_final_position"]))
        self.assertNotIn("ape_live_m", line)
        score["error"] = "no file, no map"
        self.assertEqual(5, runs.campaign_line({"score": score, "vehicles": 2, "cpu_mapped_s": 1})["exit"])


class MeasuredTest(unittest.TestCase):
    def measured(self, limit_s, *command):
        with tempfile.TemporaryDirectory() as name:
            usage = Path(name) / "usage.json"
            done = subprocess.run([sys.executable, "-S", "-E", HERE / "measured.py", usage, str(limit_s),
                                   *command], check=False)
            used = json.loads(usage.read_text())
            self.assertEqual(done.returncode, used["exit"])
            return used

    def test_says_how_a_command_ended(self):
        self.assertEqual(3, self.measured(60, "sh", "-c", "exit 3")["exit"])
        self.assertEqual(137, self.measured(60, "sh", "-c", "kill -9 $$")["exit"])
        self.assertEqual(124, self.measured(1, "sleep", "30")["exit"])

    def test_memory_is_that_of_the_command(self):
        small = self.measured(60, "true")["memory_mb"]
        large = self.measured(60, sys.executable, "-c", "x = b'x' * 200_000_000")["memory_mb"]
        self.assertLess(small, 40)
        self.assertGreater(large, 190)


if __name__ == "__main__":
    unittest.main()
