#!/usr/bin/env python3
"""web_bundle_test.py SOURCE_DIR BUILD_DIR CMAKE [NPM]: bundles the scripts again and compares.

A bundle packed by hand, or with other packages than the lock file names, would show in no other
test: the program is built from web/dist alone. Exit 77: skipped.
"""

import subprocess
import sys
from pathlib import Path


def main(source, build, cmake, npm=""):
    if not npm or npm.endswith("NOTFOUND"):
        print("SKIPPED: npm is not there, the bundle in web/dist was not made again")
        return 77
    base = [cmake, "-D", f"SOURCE={source}/web", "-D", f"BUILD={build}"]
    installed = subprocess.run([*base, "-D", f"NPM={npm}", "-P", f"{source}/cmake/InstallWeb.cmake"])
    if installed.returncode != 0:
        print("SKIPPED: the npm registry was not reached, the bundle was not made again")
        return 77
    subprocess.run([*base, "-P", f"{source}/cmake/BundleWeb.cmake"], check=True)
    return subprocess.run([sys.executable, f"{source}/tools/web_bundle.py", "same", f"{source}/web",
                           str(Path(build))]).returncode


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
