#!/usr/bin/env python3
"""Tests of tools/run_tutorial.py on small pages; needs bash, no rali."""

import unittest

import run_tutorial

HEAD = "<!-- tutorial: figures within 10 % or 0.05 -->\n"


def page(commands, text):
    return f"{HEAD}Words.\n\n```sh\n{commands}\n```\n\n```text\n{text}\n```\nMore words.\n"


class RunTutorialTest(unittest.TestCase):
    def wrong(self, commands, text):
        return run_tutorial.run_page(page(commands, text), "/bin/true")[1]

    def test_accepts_figures_within_the_tolerance(self):
        self.assertEqual([], self.wrong("echo 'path 105 m,  0.04 off'", "path 100 m, 0.08 off"))

    def test_refuses_figures_beyond_it(self):
        self.assertEqual(1, len(self.wrong("echo 'path 111 m'", "path 100 m")))
        self.assertEqual(1, len(self.wrong("echo 'path -100 m'", "path 100 m")))

    def test_refuses_other_words_and_names_and_lines(self):
        self.assertEqual(1, len(self.wrong("echo 'way 100 m'", "path 100 m")))
        self.assertEqual(1, len(self.wrong("echo v2", "v1")))
        self.assertEqual(1, len(self.wrong("echo a; echo b", "a")))
        self.assertEqual(1, len(self.wrong("echo a", "a\nb")))

    def test_refuses_a_block_that_fails(self):
        with self.assertRaises(SystemExit):
            self.wrong("echo a; false", "a")

    def test_blocks_share_a_folder(self):
        text = page("echo 1 > f", "") + page("cat f", "1")
        self.assertEqual([], run_tutorial.run_page(text, "/bin/true")[1])

    def test_writes_what_was_printed(self):
        renewed, _ = run_tutorial.run_page(page("echo new", "old\nlines"), "/bin/true")
        self.assertEqual(page("echo new", "new"), renewed)

    def test_refuses_a_page_without_a_tolerance(self):
        with self.assertRaises(SystemExit):
            run_tutorial.run_page("```sh\ntrue\n```\n", "/bin/true")


if __name__ == "__main__":
    unittest.main()
