#!/usr/bin/env python3
"""Tests of tools/web_bundle.py and of the unpacking in tools/embed_files.py."""

import contextlib
import io
import tempfile
import unittest
from pathlib import Path

import embed_files
import web_bundle


class WebBundleTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.web = Path(self.folder.name)
        (self.web / "src/inner").mkdir(parents=True)
        (self.web / "package-lock.json").write_text("{}")
        (self.web / "src/main.js").write_text("start();\n")
        (self.web / "src/inner/deep.js").write_text("deep();\n")
        self.build = self.web / "build"
        self.build.mkdir(exist_ok=True)
        self.script = self.build / "report.js"
        self.script.write_text("start()")
        (self.build / "live.js").write_text("live()")
        web_bundle.pack(self.web, self.build)

    def tearDown(self):
        self.folder.cleanup()

    def run_silent(self, verb, *arguments):
        with contextlib.redirect_stdout(io.StringIO()) as printed:
            return verb(self.web, *arguments), printed.getvalue()

    def test_a_packed_bundle_is_fresh_and_the_same(self):
        self.assertEqual(self.run_silent(web_bundle.fresh), (0, ""))
        self.assertEqual(self.run_silent(web_bundle.same, self.build), (0, ""))

    def test_a_changed_script_or_lock_file_makes_it_stale_and_the_remedy_is_named(self):
        for name in ("src/main.js", "src/inner/deep.js", "package-lock.json"):
            with self.subTest(name):
                self.setUp()
                (self.web / name).write_text("other")
                code, printed = self.run_silent(web_bundle.fresh)
                self.assertEqual(code, 1)
                self.assertIn("make bundle", printed)

    def test_a_bundle_of_other_bytes_is_refused(self):
        for name in web_bundle.BUNDLES:
            with self.subTest(name):
                self.setUp()
                (self.build / f"{name}.js").write_text("other()")
                self.assertEqual(self.run_silent(web_bundle.same, self.build)[0], 1)

    def test_a_bundle_that_was_never_packed_is_refused(self):
        (self.web / "dist/live.js.gz").unlink()
        self.assertEqual(self.run_silent(web_bundle.same, self.build)[0], 1)

    def test_the_same_script_is_packed_to_the_same_bytes(self):
        first = (self.web / "dist/report.js.gz").read_bytes()
        web_bundle.pack(self.web, self.build)
        self.assertEqual((self.web / "dist/report.js.gz").read_bytes(), first)

    def test_a_packed_file_is_embedded_unpacked(self):
        target = self.web / "assets.cpp"
        embed_files.main([str(target), "a", f"script={self.web}/dist/report.js.gz"])
        self.assertIn('"start()"', target.read_text())


if __name__ == "__main__":
    unittest.main()
