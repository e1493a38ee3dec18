#!/usr/bin/env python3
"""Tests of comparison.py and of the command on small tables made by hand."""

import contextlib
import io
import tempfile
import unittest
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from unittest import mock

import comparison
import regression
import rows
import table


def row(seed, case="floor", **figures):
    line = {name: None for name in table.COLUMNS}
    line.update(case=case, preset="robust", seed=seed, input="a", findings="", exit=0, vehicles=1,
                frames=1, ape_final_m=0.100)
    line.update(figures)
    return line


def rows_of(lines):
    return {table.key_of(line): line for line in lines}


def with_figure(name, values, **others):
    return rows_of(row(seed, **{name: value}, **others) for seed, value in enumerate(values, 1))


def verdict(name, base, new):
    result = comparison.compare(with_figure(name, base), with_figure(name, new))
    return {line.figure: line.verdict for line in result.lines}[name], result.worse


class IntervalTest(unittest.TestCase):
    def test_is_that_of_a_table_of_students_t(self):
        middle, (low, high) = comparison.interval([1.0, 2.0, 3.0])  # s = 1, t(2) = 4.303
        self.assertAlmostEqual(2.0, middle)
        self.assertAlmostEqual(2.0 - 4.303 / 3 ** 0.5, low, 6)
        self.assertAlmostEqual(2.0 + 4.303 / 3 ** 0.5, high, 6)

    def test_of_one_seed_there_is_none(self):
        self.assertEqual((0.5, None), comparison.interval([0.5]))

    def test_quantiles_beyond_the_table_go_on_without_a_step(self):
        self.assertAlmostEqual(2.0395, comparison.t_quantile(31), 2)
        self.assertAlmostEqual(1.9840, comparison.t_quantile(100), 2)

    def test_the_worst_decile_of_twenty_is_the_mean_of_two(self):
        self.assertEqual(19.5, comparison.worst_decile(list(range(1, 21))))
        self.assertEqual(3, comparison.worst_decile([1, 3, 2]))


class VerdictTest(unittest.TestCase):
    def test_a_shift_of_every_seed_is_worse_one_way_and_better_the_other(self):
        low, high = [0.100, 0.110, 0.120, 0.105], [0.110, 0.121, 0.130, 0.116]
        self.assertEqual(("WORSE", True), verdict("ape_final_m", low, high))
        self.assertEqual(("better", False), verdict("ape_final_m", high, low))

    def test_the_same_table_is_equal(self):
        self.assertEqual(("equal", False), verdict("ape_final_m", [0.1, 0.2], [0.1, 0.2]))

    def test_a_certain_change_below_three_percent_is_not_worse(self):
        self.assertEqual(("not worse", False),
                         verdict("ape_final_m", [0.100, 0.200, 0.300], [0.102, 0.202, 0.302]))

    def test_a_certain_change_below_a_millimetre_is_not_worse(self):
        self.assertEqual(("not worse", False),
                         verdict("ape_final_m", [0.003] * 4, [0.0038] * 4))
        self.assertEqual(("WORSE", True), verdict("ape_final_m", [0.003] * 4, [0.0042] * 4))

    def test_a_large_but_uncertain_change_is_not_worse(self):
        base = [0.20, 0.30, 0.40, 0.50]
        self.assertEqual(("not worse", False), verdict("ape_final_m", base, [0.28, 0.24, 0.48, 0.51]))

    def test_one_seed_far_off_is_a_worse_decile(self):
        base = [0.1 + 0.001 * k for k in range(20)]
        new = base[:19] + [0.9]
        self.assertEqual(("WORSE, worst decile", True), verdict("ape_final_m", base, new))
        self.assertFalse(verdict("ape_final_m", new, base)[1])

    def test_the_worst_of_a_few_seeds_may_scatter(self):
        base = [0.100, 0.110, 0.120]
        self.assertFalse(verdict("ape_final_m", base, [0.100, 0.108, 0.135])[1])
        self.assertTrue(verdict("ape_final_m", base, [0.100, 0.108, 0.150])[1])

    def test_nees_is_judged_by_its_distance_from_one_in_either_direction(self):
        for name in ("nees_live_position", "nis"):
            self.assertTrue(verdict(name, [1.0, 1.1, 0.9], [4.0, 4.1, 3.9])[1])
            self.assertTrue(verdict(name, [1.0, 1.1, 0.9], [0.25, 0.26, 0.24])[1])
            self.assertEqual("better", verdict(name, [4.0, 4.1, 3.9], [1.0, 1.1, 0.9])[0])
            self.assertEqual("better", verdict(name, [0.2, 0.21, 0.19], [1.0, 1.1, 0.9])[0])
            self.assertFalse(verdict(name, [0.5, 0.5, 0.5], [2.0, 2.0, 2.0])[1])

    def test_a_gain_is_worse_when_it_shrinks(self):
        self.assertTrue(verdict("ranges_applied", [0.8, 0.82, 0.81], [0.6, 0.61, 0.62])[1])
        self.assertEqual("better", verdict("ranges_applied", [0.6, 0.61, 0.62], [0.8, 0.82, 0.81])[0])

    def test_processor_time_may_differ_by_ten_percent(self):
        self.assertFalse(verdict("cpu_s", [10.0, 20.0, 30.0], [10.8, 21.6, 32.4])[1])
        self.assertTrue(verdict("cpu_s", [10.0, 10.0, 10.0], [11.5, 11.6, 11.4])[1])


    def test_processor_times_of_two_machines_are_not_compared(self):
        base, new = with_figure("cpu_s", [10.0, 10.1, 10.2]), with_figure("cpu_s", [20.0, 20.1, 20.2])
        self.assertTrue(comparison.compare(base, new).worse)
        other = comparison.compare(base, new, same_machine=False)
        self.assertFalse(other.worse)
        self.assertIn("CPU time is not compared", other.notes[0])


class FailureTest(unittest.TestCase):
    def worse(self, base, new):
        return comparison.compare(rows_of(base), rows_of(new)).worse

    def test_one_failure_more_is_worse_one_less_is_not(self):
        good = [row(1), row(2)]
        bad = {"exit": 3, "frames": 0, "frames_wrong": 1, "loops_wrong": 2, "explored": 0, "silent": 1,
               "seen": 0.9,
               "ape_final_m": None}
        for name, value in bad.items():
            with self.subTest(name):
                failed = [row(1), row(2, **{name: value})]
                self.assertTrue(self.worse(good, failed))
                self.assertFalse(self.worse(failed, good))
                self.assertFalse(self.worse(failed, failed))

    def test_a_crash_does_not_leave_the_comparison(self):
        crash = row(2, exit=139, ape_final_m=None, frames=None)
        result = comparison.compare(rows_of([row(1), row(2)]), rows_of([row(1), crash]))
        self.assertTrue(result.worse)
        self.assertIn("no ape_final_m: floor robust, seeds 2 (NEW)", result.notes)


class MissingTest(unittest.TestCase):
    def test_seeds_and_rows_on_one_side_are_said(self):
        base = rows_of([row(1), row(2), row(1, case="tunnel")])
        new = rows_of([row(1), row(3)])
        notes = comparison.compare(base, new).notes
        self.assertEqual(["only in BASE: floor robust, seeds 2", "only in BASE: tunnel robust, seeds 1",
                          "only in NEW: floor robust, seeds 3"], notes)

    def test_another_recording_is_said(self):
        notes = comparison.compare(rows_of([row(1)]), rows_of([row(1, input="b")])).notes
        self.assertEqual(["other input: floor robust, seeds 1"], notes)


class CommandTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def write(self, name, lines):
        path = self.folder / name
        table.write(path, {"commit": name, "machine": "m"}, lines, table.key_of)
        return str(path)

    def compare(self, base, new):
        out, err = io.StringIO(), io.StringIO()
        with mock.patch("sys.argv", ["regression.py", "compare", base, new]), \
                contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
            return regression.main(), out.getvalue() + err.getvalue()

    def test_exit_code_is_one_if_worse_and_zero_if_not(self):
        base = self.write("base.csv", [row(s, ape_final_m=0.1) for s in (1, 2, 3)])
        new = self.write("new.csv", [row(s, ape_final_m=0.2) for s in (1, 2, 3)])
        code, text = self.compare(base, new)
        self.assertEqual(1, code)
        self.assertIn("| floor | robust | ape_final_m | 3 | 0.1 | 0.2 | +0.1 |", text)
        self.assertIn("commit: base.csv; NEW: new.csv", text)
        self.assertEqual(0, self.compare(new, base)[0])
        self.assertEqual(0, self.compare(base, base)[0])

    def test_the_last_line_says_how_much_was_compared(self):
        base = self.write("base.csv", [row(1), row(2)])
        new = self.write("new.csv", [row(2), row(3), row(4)])
        self.assertIn("1 runs compared, 1 only in BASE, 2 only in NEW: nothing is worse",
                      self.compare(base, new)[1])

    def test_tables_without_a_common_row_are_a_usage_error(self):
        base = self.write("base.csv", [row(1)])
        self.assertEqual(2, self.compare(base, self.write("new.csv", [row(2)]))[0])

    def test_a_damaged_table_is_named_with_its_line(self):
        base = self.write("base.csv", [row(1), row(2)])
        for damage, said in ((lambda t: t.replace(",0.1,", ",x,", 1), ":4: ape_final_m"),
                             (lambda t: t + t.splitlines()[-1] + "\n", ":6: ('floor', 'robust', 2)"),
                             (lambda t: t + "1,2\n", ":6: 2 cells"),
                             (lambda t: t.replace("case,", "place,"), "columns are not those"),
                             (lambda t: "", "has no row of column names")):
            path = self.folder / "damaged.csv"
            path.write_text(damage(Path(base).read_text()))
            code, text = self.compare(str(path), base)
            self.assertEqual(2, code)
            self.assertIn(said, text)
        self.assertEqual(2, self.compare(base, str(self.folder / "none.csv"))[0])

    def test_a_table_that_is_written_reads_back(self):
        lines = [row(2, nis=0.12345), row(1, findings="a.b:2 c:1", ape_live_m=None)]
        head, read = table.read(self.write("base.csv", lines))
        self.assertEqual({"commit": "base.csv", "machine": "m"}, head)
        self.assertEqual([1, 2], [line["seed"] for line in read.values()])
        first, second = read.values()
        self.assertEqual(("a.b:2 c:1", None), (first["findings"], first["ape_live_m"]))
        self.assertEqual(0.1235, second["nis"])  # four digits


class FakeRunner:
    """A binary that measures nothing and fails where it is told to."""

    def __init__(self, fails=()):
        self.fails, self.ran = fails, []

    def run(self, case, seed):
        self.ran.append(seed)
        if seed in self.fails:
            raise self.fails[seed]
        return row(seed, case=case.case)


class MeasureTest(unittest.TestCase):
    def measure(self, runner, seeds):
        lines, saved = {}, []
        plan = [(rows.ROWS[0], seed) for seed in seeds]
        with ThreadPoolExecutor(max_workers=1) as pool, contextlib.redirect_stderr(io.StringIO()) as said:
            code = regression.measure(pool, runner, plan, lines, lambda: saved.append(len(lines)))
        return code, lines, saved, said.getvalue()

    def test_saves_after_each_run(self):
        code, lines, saved, _ = self.measure(FakeRunner(), [1, 2])
        self.assertEqual((0, 2, [1, 2]), (code, len(lines), saved))

    def test_a_run_that_cannot_be_measured_ends_no_other_and_is_said(self):
        for error in (RuntimeError("no disk"), SystemExit("no disk")):
            code, lines, _, said = self.measure(FakeRunner({1: error}), [1, 2])
            self.assertEqual((1, [2]), (code, [key[2] for key in lines]))
            self.assertIn("single corridor robust 1: not measured: no disk", said)


class PlanTest(unittest.TestCase):
    def test_goes_seed_by_seed_so_that_an_interrupted_run_has_all_rows(self):
        plan = rows.plan("short")
        first = [row.case for row, seed in plan if seed == rows.FIRST_SEED]
        self.assertEqual(first, [row.case for row, _ in plan[:len(first)]])
        self.assertNotIn("kilometre", first)
        self.assertIn("kilometre", {row.case for row, _ in rows.plan("long")})

    def test_no_two_rows_have_one_key(self):
        keys = [(row.case, row.preset) for row in rows.ROWS]
        self.assertEqual(len(keys), len(set(keys)))

    def test_the_short_form_stays_below_25_minutes(self):
        self.assertLess(sum(row.cpu_s for row, _ in rows.plan("short")), 25 * 60)


if __name__ == "__main__":
    unittest.main()
