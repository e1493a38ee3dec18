#!/usr/bin/env python3
"""Keeps web/dist: the bundled scripts of report.html and of the live page, so that a build needs no npm.

usage: web_bundle.py fresh WEB        exit 0 if WEB/dist was made from WEB's scripts and lock file
       web_bundle.py pack WEB BUILD   writes WEB/dist from the bundles in BUILD
       web_bundle.py same WEB BUILD   exit 0 if WEB/dist holds the bundles in BUILD
"""

import gzip
import hashlib
import sys
from pathlib import Path

BUNDLES = ("report", "live")
REMEDY = "run `make bundle` (needs npm and, once, the network) and commit web/dist"


def sources_hash(web):
    """Over what the bundle is made of; the bytes of a bundle cannot be compared without npm."""
    out = hashlib.sha256()
    for path in [web / "package-lock.json", *sorted((web / "src").glob("**/*.js"))]:
        text = path.read_bytes().replace(b"\r\n", b"\n")
        out.update(f"{path.relative_to(web).as_posix()} {len(text)}\n".encode() + text)
    return out.hexdigest() + "\n"


def fresh(web):
    stamp = web / "dist/sources.sha256"
    if stamp.exists() and stamp.read_text(encoding="ascii") == sources_hash(web):
        return 0
    print(f"{web}/dist was made from other scripts or packages than {web} holds: {REMEDY}.")
    return 1


def pack(web, build):
    dist = web / "dist"
    dist.mkdir(exist_ok=True)
    for name in BUNDLES:
        script = (build / f"{name}.js").read_bytes()
        # Without a time, so that the same scripts give the same file.
        (dist / f"{name}.js.gz").write_bytes(gzip.compress(script, 9, mtime=0))
    (dist / "sources.sha256").write_text(sources_hash(web), encoding="ascii")
    return 0


def same(web, build):
    differ = 0
    for name in BUNDLES:
        kept = web / f"dist/{name}.js.gz"
        script = build / f"{name}.js"
        if kept.exists() and gzip.decompress(kept.read_bytes()) == script.read_bytes():
            continue
        print(f"{script}, bundled now, differs from {kept}: {REMEDY}.")
        differ = 1
    return differ


def main(arguments):
    verbs = {"fresh": (fresh, 2), "pack": (pack, 3), "same": (same, 3)}
    if not arguments or arguments[0] not in verbs or len(arguments) != verbs[arguments[0]][1]:
        print(__doc__, file=sys.stderr)
        return 2
    return verbs[arguments[0]][0](*map(Path, arguments[1:]))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
