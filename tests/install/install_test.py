#!/usr/bin/env python3
"""Installs the library into a folder of its own and uses it as a stranger would.

usage: install_test.py BUILD_DIR SOURCE_DIR

Checks that exactly the public headers are installed, that rali::core needs no file, thread or clock,
that the project examples/ finds the package and builds, and that its programs work on a small
simulated recording. Exit code 77: something is missing, said on stderr.
"""

import os
import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

SKIPPED = 77
FORBIDDEN = re.compile(r"fopen|\bopen(at)?64?\b|fstream|filesystem|std::thread|pthread_create|"
                       r"clock_gettime|gettimeofday|chrono::\w+::now|random_device|std::(cout|cerr)")


def run(*command, cwd=None):
    """The standard output of a command; ends the test with its words where it fails."""
    done = subprocess.run([str(c) for c in command], cwd=cwd, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))} ended with {done.returncode}:\n"
                 f"{done.stdout[-4000:]}\n{done.stderr[-4000:]}")
    return done.stdout


def check(condition, sentence):
    if not condition:
        sys.exit(sentence)


def check_headers(source, prefix):
    public = {p.relative_to(source / "include") for p in (source / "include").rglob("*.hpp")}
    installed = {p.relative_to(prefix / "include") for p in (prefix / "include").rglob("*")
                 if p.is_file()}
    check(installed == public, f"installed headers differ from include/: {installed ^ public}")
    for header in sorted((prefix / "include").rglob("*.hpp")):
        for included in re.findall(r'#include "([^"]+)"', header.read_text()):
            check((prefix / "include" / included).is_file(),
                  f"{header} includes {included}, which is not installed")


def check_core(prefix):
    """What does no input or output has no symbol for it either."""
    archive = next(prefix.rglob("librali_core.a"))
    symbols = run("nm", "-u", "--demangle", archive).splitlines()
    bad = sorted({s.strip() for s in symbols if " U " in f" {s}" and FORBIDDEN.search(s)})
    check(not bad, f"librali_core.a uses {bad}")


def build_examples(source, prefix, build, work):
    examples = work / "examples"
    shutil.copytree(source / "examples", examples)
    cache = (build / "CMakeCache.txt").read_text()
    options = [f"-D{key}={value}" for key, value in
               re.findall(r"^(CMAKE_CXX_COMPILER(?:_LAUNCHER)?):\w+=(.+)$", cache, re.M)]
    run("cmake", "-S", examples, "-B", work / "consumer", f"-DCMAKE_PREFIX_PATH={prefix}", *options)
    run("cmake", "--build", work / "consumer", "-j", "1")
    return work / "consumer"


def check_examples(programs, build, work):
    lines = run(programs / "vehicle_without_files").splitlines()
    check(len(lines) == 10 and "degenerate=1 along (" in lines[-1], f"the tunnel: {lines}")

    run(build / "bin" / "rali", "simulate", "corridor", "--seed", "1", "--vehicles", "1",
        "--duration", "8", "-o", work / "sim")
    fleet = work / "sim" / "fleet.yaml"
    poses = run(programs / "step_vehicle", fleet).splitlines()
    check(len(poses) > 70 and poses[-1].startswith("v1 "), f"poses: {poses[-3:]}")
    summary = run(programs / "map_recording", fleet, work / "out", work / "sim" / "truth")
    error = re.search(r"^error: ([0-9.]+) m$", summary, re.M)
    check(error and float(error[1]) < 0.2, f"map_recording: {summary}")
    for name in ("map.pcd", "trajectory/v1.tum", "report.html"):
        check((work / "out" / name).stat().st_size > 0, f"no {name}")

    wrong = subprocess.run([programs / "step_vehicle", work / "none.bag"], capture_output=True,
                           text=True)
    check(wrong.returncode == 2 and "none.bag" in wrong.stderr, f"a missing file: {wrong.stderr}")


def main():
    build, source = Path(sys.argv[1]), Path(sys.argv[2])
    if not list((build / "library").glob("librali_io.a")) or not (build / "bin" / "rali").exists():
        print("SKIPPED: build the targets rali and rali_library_io first", file=sys.stderr)
        sys.exit(SKIPPED)
    for tool in ("cmake", "nm"):
        if not shutil.which(tool):
            print(f"SKIPPED: {tool} is not installed", file=sys.stderr)
            sys.exit(SKIPPED)
    os.environ.pop("CMAKE_PREFIX_PATH", None)
    with tempfile.TemporaryDirectory() as folder:
        work = Path(folder)
        prefix = work / "prefix"
        run("cmake", "--install", build, "--component", "dev", "--prefix", prefix)
        check_headers(source, prefix)
        check_core(prefix)
        check_examples(build_examples(source, prefix, build, work), build, work)
    print("installed, found, compiled and run")


if __name__ == "__main__":
    main()
