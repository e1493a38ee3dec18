#!/usr/bin/env python3
"""Writes the sources of a unity build: each includes several .cpp files of one room.

usage: unity_batches.py OUT_FOLDER FILES_MAX INCLUDE_FOLDER SOURCE.cpp...

Prints the written paths, one a line. A file-local name (anonymous namespace, `static`) is seen by
the files that follow in its batch. So two files share a batch only if neither mentions, itself or
in a header below INCLUDE_FOLDER, a file-local name of the other: no name clashes, and no call finds
another function than in a build of single files.
"""

import functools
import re
import sys
from pathlib import Path

COMMENT = re.compile(r"//[^\n]*|/\*.*?\*/|\"(?:\\.|[^\"\\\n])*\"", re.S)
INCLUDE = re.compile(r'^#include "([^"]+)"', re.M)
TOKEN = re.compile(r"(?<![\w.>])(?<!::)[A-Za-z_]\w*|(?<=[^-]>)[A-Za-z_]\w*")
HEADER_TOKEN = re.compile(r"(?<![\w.>])(?:k[A-Z]\w*|[A-Z]\w*|[a-z]\w*(?=\())")
# Behind these, a call `quoted(string)` finds std::quoted by its argument, beside the room's own.
BRINGS_QUOTED = re.compile(r"^#include <(?:filesystem|iomanip)>", re.M)
NAMESPACE = re.compile(r"(?:inline )?namespace\s*([\w:]*)\s*{")
# At column 0, as clang-format leaves a declaration in a namespace.
TYPE = re.compile(r"(?:struct|class|enum class|enum|union) (\w+)")
ALIAS = re.compile(r"using (\w+) =")
FUNCTION = re.compile(r"[A-Za-z_][\w:<>,&*\s\[\]]*?[\s&*]~?(\w+)\(")
CLOSED = "}  @namespace"  # the comment that clang-format sets, out of reach of COMMENT
VALUES = re.compile(r"\b([A-Za-z_]\w*)(?:\[[^\]]*\])*\s*(?==(?!=)|\{|;)")
NOT_A_DECLARATION = re.compile(r"(?:return|using|template|namespace|friend|public|private)\b|[#}\s]|$")


def declared(line):
    """The names that a line at namespace level declares."""
    for pattern in (TYPE, ALIAS, FUNCTION):
        found = pattern.match(line)
        if found and not (pattern is FUNCTION and "=" in line[:found.end()]):
            return [found.group(1)]
    if NOT_A_DECLARATION.match(line):
        return []
    return VALUES.findall(line)


def local_names(bare):
    """Names of anonymous namespaces and of `static` declarations."""
    names, spaces = set(), []
    for line in bare.split("\n"):
        opened = NAMESPACE.match(line)
        if opened and "}" not in line:
            spaces.append(opened.group(1))
        elif line.startswith(CLOSED) and spaces:
            spaces.pop()
        elif "" in spaces or line.startswith("static "):
            names.update(declared(line.removeprefix("static ")))
    return names


@functools.cache
def bare_text(path):
    text = re.sub(r"^}  // namespace.*", CLOSED, path.read_text(encoding="utf-8"), flags=re.M)
    return COMMENT.sub('""', text)


@functools.cache
def headers(path, include):
    """The project's headers that `path` includes, directly or not."""
    out = set()
    for name in INCLUDE.findall(path.read_text(encoding="utf-8")):
        header = include / name
        if header.exists():
            out |= {header} | headers(header, include)
    return frozenset(out)


@functools.cache
def header_tokens(path):
    """Constants, types and calls: a header's other names are members and parameters."""
    return frozenset(HEADER_TOKEN.findall(bare_text(path)))


def read(path, include):
    bare = bare_text(path)
    tokens, local = set(TOKEN.findall(bare)), local_names(bare)
    for header in headers(path, include):
        tokens |= header_tokens(header) - {"quoted"}  # io::quoted, see below
    if BRINGS_QUOTED.search(bare):
        local.add("quoted")
    return local, tokens


def batches(files, files_max, include):
    """Each file goes to the first batch that has room and no name in common with it."""
    out = []
    for path in files:
        local, tokens = read(Path(path), Path(include))
        for batch in out:
            if len(batch["files"]) < files_max and not local & batch["tokens"] and \
                    not tokens & batch["local"]:
                break
        else:
            batch = {"files": [], "local": set(), "tokens": set()}
            out.append(batch)
        batch["files"].append(path)
        batch["local"] |= local
        batch["tokens"] |= tokens
    return [batch["files"] for batch in out]


def main(arguments):
    if len(arguments) < 4:
        print(__doc__, file=sys.stderr)
        return 2
    folder = Path(arguments[0])
    folder.mkdir(parents=True, exist_ok=True)
    for number, files in enumerate(batches(arguments[3:], int(arguments[1]), arguments[2])):
        text = "".join(f'#include "{path}"\n' for path in files)
        target = folder / f"batch_{number}.cpp"
        if not target.exists() or target.read_text(encoding="utf-8") != text:
            target.write_text(text, encoding="utf-8")  # unchanged: not compiled again
        print(target)
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
