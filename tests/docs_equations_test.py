#!/usr/bin/env python3
"""Every file, function and test named in docs/reference/equations.md exists.

usage: docs_equations_test.py REPOSITORY
"""
import os
import re
import sys
import tempfile
import unittest

ROOT = os.path.abspath(sys.argv.pop(1)) if len(sys.argv) > 1 else os.getcwd()
COLUMNS = 5
ROWS_MIN = 30
FUNCTION = re.compile(r"`(\w+)` in `([\w/.]+)`")
TESTS = re.compile(r"`([\w/]+_test\.cpp)`: ((?:`\w+`(?:, )?)+)")


def rows_of(text):
    """(line number, cells) of the table rows, without heads and rulers."""
    for number, line in enumerate(text.splitlines(), 1):
        if not line.startswith("|") or line.startswith(("|---", "| what |")):
            continue
        yield number, [cell.strip() for cell in line.strip().strip("|").split("|")]


def source(root, path):
    full = os.path.join(root, "src", "rali", path)
    if not os.path.isfile(full):
        return None
    with open(full, encoding="utf-8") as f:
        return f.read()


def is_defined(name, text):
    # At its definition: after a type, a class:: or alone, not only in a call or a comment.
    return re.search(rf"^[^\s/](?:[^\n=;]*[\s:&*])?{name}\(", text, re.M) is not None


def check_functions(root, cell):
    found = FUNCTION.findall(cell)
    if not found or FUNCTION.sub("", cell).strip("; "):
        yield f"not `function` in `file`: {cell}"
    for name, path in found:
        text = source(root, path)
        if text is None:
            yield f"no file src/rali/{path}"
        elif not is_defined(name, text):
            yield f"{path} does not define {name}"


def check_tests(root, cell):
    found = TESTS.findall(cell)
    if not found or TESTS.sub("", cell).strip("; "):
        yield f"not `file_test.cpp`: `test`, ...: {cell}"
    for path, names in found:
        text = source(root, path)
        if text is None:
            yield f"no file src/rali/{path}"
            continue
        for name in re.findall(r"`(\w+)`", names):
            if not re.search(rf"TEST(?:_F|_P)?\(\w+,\s*{name}\)", text):
                yield f"{path} has no test {name}"


def problems_of(root, text):
    for number, cells in rows_of(text):
        if len(cells) != COLUMNS:
            yield f"line {number}: {len(cells)} cells, not {COLUMNS}"
            continue
        for problem in (*check_functions(root, cells[3]), *check_tests(root, cells[4])):
            yield f"line {number}: {problem}"


class Equations(unittest.TestCase):
    def test_everything_named_exists(self):
        with open(os.path.join(ROOT, "docs", "reference", "equations.md"), encoding="utf-8") as f:
            text = f.read()
        self.assertGreaterEqual(len(list(rows_of(text))), ROWS_MIN)
        self.assertEqual([], list(problems_of(ROOT, text)))


class Checker(unittest.TestCase):
    """The check itself, on a repository of one function and one test."""

    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        room = os.path.join(self.folder.name, "src", "rali", "a")
        os.makedirs(room)
        with open(os.path.join(room, "f.cpp"), "w", encoding="utf-8") as f:
            f.write("// g(x) is elsewhere\ndouble A::f(double x) {\n  return h(x);\n}\n")
        with open(os.path.join(room, "f_test.cpp"), "w", encoding="utf-8") as f:
            f.write("TEST(F,\n     holds) {}\n// TEST that others\n")

    def problems(self, function, tests):
        return list(problems_of(self.folder.name, f"| x | y | z | {function} | {tests} |"))

    def test_accepts_what_exists(self):
        self.assertEqual([], self.problems("`f` in `a/f.cpp`", "`a/f_test.cpp`: `holds`"))

    def test_refuses_what_is_missing(self):
        good, test = "`f` in `a/f.cpp`", "`a/f_test.cpp`: `holds`"
        for function, tests in ((good, "`a/f_test.cpp`: `others`"), (good, "`a/g_test.cpp`: `holds`"),
                                ("`f` in `a/g.cpp`", test), ("`g` in `a/f.cpp`", test),
                                ("`h` in `a/f.cpp`", test), ("", test), (good, ""),
                                (good + " and more", test), (good, "`a/f_test.cpp`: `holds`, or so")):
            self.assertEqual(1, len(self.problems(function, tests)), (function, tests))

    def test_refuses_a_row_with_a_cell_too_many(self):
        self.assertEqual(1, len(self.problems("`f` in `a/f.cpp` | ", "`a/f_test.cpp`: `holds`")))


if __name__ == "__main__":
    unittest.main()
