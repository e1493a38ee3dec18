#!/usr/bin/env python3
"""Runs the ```sh blocks of a tutorial in an empty folder and compares what they print.

usage: run_tutorial.py PAGE RALI [--write]

The standard output of a block must be that of the ```text block behind it: words as they stand,
figures within the tolerance that the page names in a hidden comment

    <!-- tutorial: figures within 20 % or 0.05 -->

so that another compiler or processor passes. A block ends the run if its last command fails.
--write puts what was printed into the page instead of comparing it.
"""

import os
import re
import subprocess
import sys
import tempfile
from pathlib import Path

BLOCK = re.compile(r"^```sh\n(.*?)^```\n(?:\n*^```text\n(.*?)^```\n)?", re.M | re.S)
TOLERANCE = re.compile(r"<!-- tutorial: figures within ([\d.]+) % or ([\d.]+) -->")
NUMBER = re.compile(r"(?<![\w.])[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?(?![\w])")


def tolerance_of(text):
    found = TOLERANCE.search(text)
    if not found:
        raise SystemExit("no comment '<!-- tutorial: figures within P % or A -->' in the page")
    return float(found[1]) / 100, float(found[2])


def is_close(expected, printed, relative, absolute):
    a, b = float(expected), float(printed)
    return abs(a - b) <= max(absolute, relative * abs(a))


def line_agrees(expected, printed, relative, absolute):
    words = [" ".join(NUMBER.sub("#", line).split()) for line in (expected, printed)]
    if words[0] != words[1]:
        return False
    figures = zip(NUMBER.findall(expected), NUMBER.findall(printed))
    return all(is_close(a, b, relative, absolute) for a, b in figures)


def differences(expected, printed, relative, absolute):
    """Lines that do not agree, as (expected, printed); a line that is missing is empty."""
    a, b = expected.rstrip().splitlines(), printed.rstrip().splitlines()
    length = max(len(a), len(b))
    pairs = zip(a + [""] * (length - len(a)), b + [""] * (length - len(b)))
    return [pair for pair in pairs if not line_agrees(*pair, relative, absolute)]


def run_block(commands, folder, rali):
    """What the block printed. PATH finds the given rali first."""
    path = os.path.dirname(os.path.abspath(rali)) + os.pathsep + os.environ["PATH"]
    done = subprocess.run(["bash", "-c", commands], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, env={**os.environ, "PATH": path}, text=True)
    if done.returncode != 0:
        raise SystemExit(f"exit code {done.returncode} of:\n{commands}\n{done.stderr[-3000:]}")
    return done.stdout


def with_printed(match, printed):
    """The block with the text that was printed in place of the text that was expected."""
    start, end = match.span(2)
    whole, offset = match[0], match.start(0)
    return whole[: start - offset] + printed.rstrip() + "\n" + whole[end - offset :]


def run_page(text, rali):
    """(page with the text that was printed, list of differences)."""
    tolerance, wrong, renewed, end = tolerance_of(text), [], [], 0
    with tempfile.TemporaryDirectory(prefix="rali_tutorial_") as folder:
        for match in BLOCK.finditer(text):
            printed = run_block(match[1], folder, rali)
            renewed += [text[end : match.start()], match[0]]
            end = match.end()
            if match[2] is None:
                continue
            renewed[-1] = with_printed(match, printed)
            line = text.count("\n", 0, match.start()) + 1
            wrong += [(line, *pair) for pair in differences(match[2], printed, *tolerance)]
    return "".join(renewed) + text[end:], wrong


def main(arguments):
    page, rali = Path(arguments[0]), arguments[1]
    text = page.read_text(encoding="utf-8")
    renewed, wrong = run_page(text, rali)
    if "--write" in arguments:
        page.write_text(renewed, encoding="utf-8")
        return 0
    for line, expected, printed in wrong:
        print(f"{page}:{line}: expected: {expected}\n{page}:{line}: printed:  {printed}")
    return bool(wrong)


if __name__ == "__main__":
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    sys.exit(main(sys.argv[1:]))
