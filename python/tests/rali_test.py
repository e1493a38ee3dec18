#!/usr/bin/env python3
"""Tests of the Python module. usage: rali_test.py BUILD_DIR [TEST...]; exit code 77: something is missing."""

import ast
import json
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

SKIPPED = 77
BUILD = Path(sys.argv[1])
SOURCE = Path(__file__).resolve().parents[2]
SIMULATE = ["simulate", "corridor", "--seed", "1", "--vehicles", "2", "--duration", "8"]

try:
    import numpy as np
except ImportError:
    print("SKIPPED: numpy is not installed (Debian: python3-numpy)", file=sys.stderr)
    sys.exit(SKIPPED)
if not list((BUILD / "python" / "rali").glob("_rali*.so")) or not (BUILD / "bin" / "rali").exists():
    print("SKIPPED: build the targets rali and rali_python first", file=sys.stderr)
    sys.exit(SKIPPED)

import rali  # noqa: E402


class Recorded(unittest.TestCase):
    """Two vehicles in a corridor, simulated and mapped once."""

    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.work = Path(cls.temporary.name)
        subprocess.run([BUILD / "bin" / "rali", *SIMULATE, "-o", cls.work / "sim"], check=True,
                       capture_output=True)
        cls.fleet = cls.work / "sim" / "fleet.yaml"
        cls.stages = []
        cls.ticks = 0
        cls.running = True
        watcher = threading.Thread(target=cls.count_while_mapping)
        watcher.start()
        cls.summary = rali.map(cls.fleet, out=cls.work / "out", threads=1,
                               settings={"output.map_voxel_m": 0.1},
                               progress=lambda p: cls.stages.append((p.stage, p.fraction)))
        cls.running = False
        watcher.join()

    @classmethod
    def count_while_mapping(cls):
        while cls.running:
            cls.ticks += 1
            time.sleep(0.01)

    @classmethod
    def tearDownClass(cls):
        cls.temporary.cleanup()

    def test_map_writes_what_its_summary_states(self):
        metrics = json.loads(self.summary.metrics_json)
        self.assertEqual(self.summary.status, metrics["status"])
        self.assertEqual([v.name for v in self.summary.vehicles], ["v1", "v2"])
        self.assertTrue(self.summary.connected)
        self.assertEqual(set(metrics["vehicles"]), {"v1", "v2"})
        self.assertIn("map_voxel_m: 0.1", (self.work / "out" / "settings.yaml").read_text())
        self.assertIn("odometry", {stage for stage, _ in self.stages})
        self.assertTrue(all(0.0 <= fraction <= 1.0 for _, fraction in self.stages))

    def test_other_threads_run_while_a_map_is_made(self):
        self.assertGreater(self.ticks, 20)

    def test_trajectory_is_a_view_with_poses_and_covariances(self):
        trajectory = rali.read_trajectory(self.work / "out" / "trajectory" / "v1.tum")
        n = len(trajectory)
        self.assertGreater(n, 60)
        self.assertEqual(trajectory.poses.shape, (n, 4, 4))
        self.assertEqual(trajectory.covariances.shape, (n, 6, 6))
        self.assertEqual(trajectory.stamp_ns.dtype, np.int64)
        self.assertFalse(trajectory.poses.flags.owndata)
        line = [float(w) for w in (self.work / "out" / "trajectory" / "v1.tum").read_text()
                .splitlines()[-1].split()]
        np.testing.assert_allclose(trajectory.poses[-1, :3, 3], line[1:4], atol=1e-9)
        np.testing.assert_array_equal(trajectory.poses[-1, 3], [0, 0, 0, 1])
        x, y, z, w = line[4:]
        self.assertAlmostEqual(trajectory.poses[-1, 0, 1], 2 * (x * y - z * w), places=6)
        np.testing.assert_array_equal(trajectory.covariances,
                                      trajectory.covariances.transpose(0, 2, 1))
        poses = trajectory.poses
        del trajectory  # the view keeps what it shows
        self.assertTrue(np.isfinite(poses).all())

    def test_map_is_read_as_columns(self):
        cloud = rali.read_map(self.work / "out" / "map.pcd")
        self.assertEqual(len(cloud), self.summary.map_points)
        self.assertEqual(cloud.xyz_m.shape, (len(cloud), 3))
        self.assertEqual(cloud.xyz_m.dtype, np.float32)
        self.assertFalse(cloud.xyz_m.flags.owndata)
        self.assertTrue((cloud.sigma_m > 0).all())
        self.assertEqual(set(np.unique(cloud.vehicle)), {0, 1})

    def test_ranges_are_read_with_their_reasons(self):
        ranges = rali.read_ranges(self.work / "out" / "ranges.csv")
        self.assertEqual(len(ranges), self.summary.ranges)
        self.assertEqual(int(ranges.used.sum()), self.summary.ranges_used)
        self.assertEqual({ranges.from_vehicle[0], ranges.to_vehicle[0]}, {"v1", "v2"})
        used = [reason == "used" for reason in ranges.reason]
        np.testing.assert_array_equal(ranges.used, used)

    def test_evaluation_against_the_ground_truth(self):
        evaluation = rali.evaluate(self.work / "out", self.work / "sim" / "truth",
                                   out=self.work / "judged")
        self.assertLess(evaluation.fleet.ape_m.rmse, 0.2)
        self.assertEqual([v.name for v in evaluation.vehicles], ["v1", "v2"])
        self.assertIn("APE", str(evaluation))
        self.assertEqual(json.loads(evaluation.json)["schema"], 2)

    def test_what_a_callback_raises_stops_the_run_and_leaves_it(self):
        def enough(state):
            if state.stage == "odometry":
                raise LookupError("enough")

        with self.assertRaisesRegex(LookupError, "enough"):
            rali.map(self.fleet, out=self.work / "raised", progress=enough, report=False)
        status = json.loads((self.work / "raised" / "status.json").read_text())
        self.assertEqual(status["status"], "interrupted")

    def test_errors_are_the_sentences_of_the_command_line(self):
        with self.assertRaises(rali.SettingsError) as caught:
            rali.map(self.fleet, out=self.work / "none", settings={"output.voxel": 0.1})
        self.assertEqual(caught.exception.where, "settings")
        self.assertIn("unknown key 'output.voxel'", str(caught.exception))
        with self.assertRaisesRegex(rali.InputError, "none.pcd"):
            rali.read_map(self.work / "none.pcd")
        with self.assertRaisesRegex(rali.SettingsError, "out"):
            rali.map(self.fleet, out=self.work / "out")

    def test_examples_run(self):
        tunnel = self.run_example("vehicle.py")
        self.assertEqual(len(tunnel.splitlines()), 10)
        self.assertIn("degenerate: True", tunnel.splitlines()[-1])
        compared = self.run_example("compare.py", self.fleet, self.work / "sim" / "truth", "-o",
                                    self.work / "compared")
        self.assertIn("APE, rmse [m]", compared)
        if "no plot" not in compared:
            self.assertGreater((self.work / "compared" / "compare.png").stat().st_size, 10000)

    def run_example(self, name, *arguments):
        done = subprocess.run([sys.executable, SOURCE / "examples" / name, *arguments],
                              capture_output=True, text=True)
        self.assertEqual(done.returncode, 0, done.stderr)
        return done.stdout


class Fed(unittest.TestCase):
    """A vehicle fed with arrays."""

    def scan(self, columns=6):
        sys.path.insert(0, str(SOURCE / "examples"))
        import vehicle

        return vehicle.tunnel_scan()[:, :columns]

    def test_scans_of_three_to_six_columns_give_poses(self):
        for columns in (3, 4, 5, 6):
            vehicle = rali.Vehicle(has_imu=False)
            outputs = vehicle.add_scan(self.scan(columns).astype(np.float32), 0.0)
            poses = [o for o in outputs if isinstance(o, rali.PoseEstimate)]
            self.assertEqual(len(poses), 1)
            self.assertEqual(poses[0].T_odom_body.shape, (4, 4))
            self.assertEqual(poses[0].covariance.shape, (6, 6))
            self.assertIsInstance(poses[0].degeneracy.degenerate, bool)
        with self.assertRaisesRegex(rali.InputError, r"shape \(N, 3\)"):
            vehicle.add_scan(np.zeros((5, 2)), 0.1)

    def test_scans_and_inertial_rows_together_hold_a_vehicle_at_rest(self):
        vehicle = rali.Vehicle(T_body_lidar=np.eye(4))
        poses = []
        for k in range(15):
            t_s = 0.1 * k + 0.005 * np.arange(20)
            rows = np.zeros((20, 7))
            rows[:, 0] = t_s
            rows[:, 6] = 9.81
            poses += vehicle.add_imu(rows)
            poses += vehicle.add_scan(self.scan(), 0.1 * k + 0.095)
        poses += vehicle.finish()
        poses = [p for p in poses if isinstance(p, rali.PoseEstimate)]
        self.assertGreater(len(poses), 3)
        np.testing.assert_allclose(poses[-1].T_odom_body[:3, 3], 0.0, atol=0.05)
        np.testing.assert_allclose(poses[-1].v_odom_mps, 0.0, atol=0.05)

    def test_same_events_same_state(self):
        hashes = []
        for _ in range(2):
            vehicle = rali.Vehicle(has_imu=False, preset="robust")
            vehicle.add_scan(self.scan(), 0.0)
            hashes.append(vehicle.state_hash())
        self.assertEqual(hashes[0], hashes[1])

    def test_wrong_arguments_are_named(self):
        with self.assertRaisesRegex(rali.SettingsError, "T_body_lidar"):
            rali.Vehicle(T_body_lidar=np.zeros((4, 4)))
        with self.assertRaisesRegex(rali.SettingsError, "preset"):
            rali.Vehicle(preset="best")
        with self.assertRaisesRegex(rali.InputError, r"shape \(N, 7\)"):
            rali.Vehicle().add_imu(np.zeros((3, 6)))

    def test_stubs_name_what_the_module_has(self):
        stubs = ast.parse((SOURCE / "python" / "rali" / "__init__.pyi").read_text())
        declared = {n.name: n for n in stubs.body if isinstance(n, (ast.ClassDef, ast.FunctionDef))}
        self.assertEqual(set(declared), set(rali.__all__))
        for name, node in declared.items():
            if isinstance(node, ast.FunctionDef):
                continue
            members = {n.name for n in node.body if isinstance(n, ast.FunctionDef)}
            real = {m for m in vars(getattr(rali, name)) if not m.startswith("_")}
            self.assertEqual({m for m in members if not m.startswith("_")}, real, name)

    def test_functions_document_their_shapes(self):
        self.assertIn("(N, 3) to (N, 6)", rali.Vehicle.add_scan.__doc__)
        self.assertIn("[rad/s]", rali.Vehicle.add_imu.__doc__)
        self.assertIn("(N, 4, 4)", rali.read_trajectory.__doc__)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1] + sys.argv[2:])
