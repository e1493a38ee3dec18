#!/usr/bin/env python3
"""Tests of tools/unity_batches.py: which files may share a compiler call."""

import tempfile
import unittest
from pathlib import Path

import unity_batches

ALONE = "namespace rali::x {\nint value(int a) { return a; }\n}  // namespace rali::x\n"


def with_local(*lines):
    return "\n".join(["namespace rali::x {", "namespace {", *lines, "}  // namespace",
                      "void shared() {}", "}  // namespace rali::x", ""])


class UnityBatchesTest(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.root = Path(folder.name)

    def batches(self, files_max=8, **texts):
        """The names of the files of each batch."""
        for name, text in texts.items():
            (self.root / f"{name}.cpp").write_text(text)
        out = unity_batches.batches([str(self.root / f"{n}.cpp") for n in texts], files_max,
                                    str(self.root))
        return [[Path(f).stem for f in batch] for batch in out]

    def test_files_without_a_name_in_common_share_a_call_up_to_the_limit(self):
        self.assertEqual(self.batches(a=ALONE, b=ALONE, c=ALONE), [["a", "b", "c"]])
        self.assertEqual(self.batches(2, a=ALONE, b=ALONE, c=ALONE), [["a", "b"], ["c"]])

    def test_the_same_local_name_parts_two_files(self):
        for line in ("constexpr double kDegree = 1.0, kTurn = 2.0;", "struct kTurn {", "int kTurn(",
                     "std::vector<double> kTurn(const A& a) {", "using kTurn = int;",
                     "enum class kTurn { kOne };", "constexpr int kTurn[] = {1};", "int kTurn;"):
            with self.subTest(line):
                self.assertEqual(
                    self.batches(a=with_local(line), b=with_local("constexpr int kTurn = 1;")),
                    [["a"], ["b"]])

    def test_a_mention_of_the_others_local_name_parts_them_in_both_orders(self):
        local = with_local("int value(int a) { return a; }")
        self.assertEqual(self.batches(a=local, b=ALONE), [["a"], ["b"]])
        self.assertEqual(self.batches(a=ALONE, b=local), [["a"], ["b"]])

    def test_a_header_that_declares_the_name_parts_them(self):
        (self.root / "low.hpp").write_text("enum class State { kFree };\n")
        (self.root / "high.hpp").write_text('#include "low.hpp"\n')
        self.assertEqual(self.batches(a=with_local("constexpr int kFree = 1;"),
                                      b='#include "high.hpp"\n'), [["a"], ["b"]])

    def test_members_and_comments_are_no_mention(self):
        local = with_local("int at(int i) { return i; }")
        user = "int f(A a) { return a.at(1) + B::at(2); }  // at\n"
        self.assertEqual(self.batches(a=local, b=user), [["a", "b"]])

    def test_an_unchanged_batch_is_not_written_again(self):
        source = self.root / "a.cpp"
        source.write_text(ALONE)
        out = self.root / "out"
        call = [str(out), "8", str(self.root), str(source)]
        unity_batches.main(call)
        written = (out / "batch_0.cpp").stat().st_mtime_ns
        unity_batches.main(call)
        self.assertEqual((out / "batch_0.cpp").stat().st_mtime_ns, written)


if __name__ == "__main__":
    unittest.main()
