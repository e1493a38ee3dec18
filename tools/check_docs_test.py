#!/usr/bin/env python3
"""Tests of tools/check_docs.py on a small repository made for each rule."""

import tempfile
import unittest
from pathlib import Path

import check_docs

CLI = "## rali map\n\n| `-o, --out DIR` | out | where |\n| `--start S` |  | leave out |\n"


class CheckDocsTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.addCleanup(self.folder.cleanup)
        self.root = Path(self.folder.name).resolve()
        self.write("docs/reference/cli.md", CLI)
        self.write("docs/reference/settings.md", "| `settings.map.a.b_m` | 1 |\n| `ranges.c` | 2 |\n")
        self.write("docs/other.md", "# A heading, and more\n")
        self.write("LICENSE", "free\n")

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text)

    def problems(self, text, name="docs/page.md"):
        self.write(name, text)
        return check_docs.Documents(self.root).check()

    def test_accepts_links_that_lead_somewhere(self):
        text = "[a](other.md) [b](other.md#a-heading-and-more) [c](https://x.org) `[d](no.md)`\n"
        self.assertEqual([], self.problems(text + "```\n[e](no.md)\n```\n"))

    def test_refuses_links_that_lead_nowhere(self):
        for link in ("no.md", "other.md#no-heading", "#none", "images/no.png", "../LICENSE"):
            self.assertEqual(1, len(self.problems(f"line\n[a]({link})\n")), link)
        self.assertIn("docs/page.md:2:", self.problems("line\n[a](no.md)\n")[0])

    def test_pages_outside_of_docs_may_link_anywhere(self):
        self.assertEqual([], self.problems("[a](LICENSE) [b](docs/other.md)\n", "README.md"))

    def test_refuses_names_of_pages_that_are_gone(self):
        self.assertEqual(1, len(self.problems("see docs/gone.md\n")))
        self.write("docs/page.md", "fine\n")
        self.assertEqual(1, len(self.problems("// docs/gone.md says why\n", "src/a.cpp")))

    def test_knows_settings(self):
        cli = "## rali map\n\n| `--set KEY=VALUE` |  | a setting |\n"
        self.write("docs/reference/cli.md", cli)
        good = "```sh\nrali map a --set map.a.b_m=1 --set 'map.a={b_m: 1}' --set ranges.c=2\n```\n"
        self.assertEqual([], self.problems(good))
        self.assertEqual(1, len(self.problems("```sh\nrali map a --set map.a.d=1\n```\n")))
        self.write("docs/page.md", "fine\n")
        self.assertEqual(1, len(self.problems("`map.a.d` and `map.a.b_m`\n", "docs/guide/page.md")))

    def test_knows_commands_and_options(self):
        good = "```sh\nrali map a.bag -o x \\\n  --start 3 | head\n```\n"
        self.assertEqual([], self.problems(good))
        for bad in ("rali mapp a", "rali map a --sart 3", "cat x; rali map a -w"):
            self.assertEqual(1, len(self.problems(f"```sh\n{bad}\n```\n")), bad)


if __name__ == "__main__":
    unittest.main()
