#!/usr/bin/env python3
"""Tests of tools/check_layers.py on small trees made for each rule."""

import tempfile
import unittest
from pathlib import Path

import check_layers

LAYERS = """# comment
base:
geometry: base
io: base geometry
ban <random>: | use base/rng.hpp
ban <thread>: io | threads live in io
"""
CMAKE = """rali_room(NAME base LIBS fmt::fmt)
rali_room(NAME geometry DEPS base LIBS Eigen3::Eigen)
rali_room(NAME io DEPS base geometry HOT)
"""


class CheckLayersTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = Path(self.folder.name).resolve()
        self.write("tools/layers.txt", LAYERS)
        self.write("src/rali/CMakeLists.txt", CMAKE)
        self.write("src/rali/base/a.hpp", "#pragma once\n")
        self.write("src/rali/geometry/g.hpp", '#include "rali/base/a.hpp"\n')

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def problems(self):
        return check_layers.Checker(self.root).run()

    def assert_only(self, sentence):
        self.assertEqual(self.problems(), [sentence])

    def test_a_tree_in_order_has_no_problem(self):
        self.assertEqual(self.problems(), [])

    def test_an_include_upwards_is_named_with_its_line(self):
        self.write("src/rali/io/x.hpp", "\n")
        self.write("src/rali/base/b.cpp", '\n#include "rali/io/x.hpp"\n')
        self.assert_only("src/rali/base/b.cpp:2: base may not include io")

    def test_a_foreign_internal_header_is_refused_and_an_own_one_not(self):
        self.write("src/rali/geometry/internal/i.hpp", "\n")
        self.write("src/rali/geometry/g.cpp", '#include "rali/geometry/internal/i.hpp"\n')
        self.assertEqual(self.problems(), [])
        self.write("src/rali/io/x.cpp", '#include "rali/geometry/internal/i.hpp"\n')
        self.assert_only('src/rali/io/x.cpp:1: "rali/geometry/internal/i.hpp" is internal to geometry')

    def test_an_include_of_nothing_is_named(self):
        self.write("src/rali/io/x.cpp", '#include "rali/base/gone.hpp"\n')
        self.assert_only('src/rali/io/x.cpp:1: there is no "rali/base/gone.hpp"')

    def test_banned_headers_name_the_replacement(self):
        self.write("src/rali/base/b.cpp", "#include <random>\n")
        self.write("src/rali/io/x.cpp", "#  include <thread>\n")  # allowed there
        self.assert_only("src/rali/base/b.cpp:1: <random> is banned in base: use base/rng.hpp")

    def test_a_cycle_in_the_list_is_refused(self):
        self.write("tools/layers.txt", LAYERS.replace("base:\n", "base: io\n"))
        self.assertTrue(any("base may not include io: not listed above it (cycle)" in problem
                            for problem in self.problems()))

    def test_cmake_and_list_must_agree(self):
        self.write("src/rali/CMakeLists.txt", CMAKE.replace("DEPS base geometry HOT", "DEPS base HOT"))
        self.assert_only("src/rali/CMakeLists.txt:3: DEPS of io and tools/layers.txt differ: geometry")

    def test_a_room_that_cmake_does_not_know_is_named(self):
        self.write("src/rali/CMakeLists.txt", CMAKE.rsplit("rali_room", 1)[0])
        self.assertTrue(self.problems()[0].endswith("no rali_room(NAME io) in src/rali/CMakeLists.txt"))

    def test_a_folder_that_is_no_room_is_named(self):
        self.write("src/rali/extra/x.cpp", "\n")
        self.assert_only("src/rali/extra/x.cpp:1: room extra is not in tools/layers.txt")

    def test_long_files_are_refused(self):
        self.write("src/rali/base/b.cpp", "\n" * 400)
        self.assertEqual(self.problems(), [])
        self.write("src/rali/base/b.cpp", "\n" * 401)
        self.assert_only("src/rali/base/b.cpp:1: file has 401 lines; at most 400")

    def test_long_functions_are_refused_wherever_they_hide(self):
        body = "  x = 1;\n" * 59
        heads = ["int f(int a) {", "A::A(int a)\n    : b_{a} {", "template <class T>\nauto f(T t) -> int {",
                 "bool operator==(const A& o) const noexcept {"]
        for head in heads:
            self.write("src/rali/base/b.cpp", "namespace a {\nstruct A {\n" + head + "\n" + body + "}\n};\n}\n")
            problems = self.problems()
            self.assertEqual(len(problems), 1, head)
            self.assertIn("lines; at most 60", problems[0], head)
        self.write("src/rali/base/b.cpp", "int f() {\n" + "  x = 1;\n" * 58 + "}\n")
        self.assertEqual(self.problems(), [])

    def test_types_and_namespaces_are_no_functions(self):
        members = "  int x = 1;\n" * 100
        for head in ["namespace a {", "class A final : public B {", "struct S {", "enum class E {",
                     "constexpr std::array kA{"]:
            self.write("src/rali/base/b.cpp", head + "\n" + members + "};\n")
            self.assertEqual(self.problems(), [], head)

    def test_braces_in_text_and_comments_do_not_count(self):
        text = 'void f() {\n  s = "}{{";  // {{{\n  /* { */ c = \'{\'; n = 1\'000;\n  r = R"({{)";\n}\n'
        blank = check_layers.without_comments_and_text(text)
        self.assertEqual(check_layers.functions(blank), [(1, "f", 5)])

    def test_the_ratchet_lets_a_file_shrink_only(self):
        self.write("src/rali/base/b.cpp", "\n" * 450)
        self.write("tools/ratchet.txt", "src/rali/base/b.cpp 450\n")
        self.assertEqual(self.problems(), [])
        self.write("src/rali/base/b.cpp", "\n" * 451)
        self.assertIn("a ratchet may only shrink", self.problems()[0])
        self.write("src/rali/base/b.cpp", "\n" * 449)
        self.assertIn("write 449", self.problems()[0])
        self.write("src/rali/base/b.cpp", "\n" * 10)
        self.assertIn("remove the line", self.problems()[0])
        (self.root / "src/rali/base/b.cpp").unlink()
        self.assertIn("is gone: remove the line", self.problems()[0])


if __name__ == "__main__":
    unittest.main()
