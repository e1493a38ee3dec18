#!/usr/bin/env python3
"""Turns files into a C++ source of byte arrays.

usage: embed_files.py OUT.cpp NAMESPACE NAME=FILE...

Each NAME becomes `std::string_view NAME()` in NAMESPACE; a FILE.gz is unpacked first. Text is written as string literals in
pieces, because compilers read those a hundred times faster than lists of numbers.
"""

import gzip
import sys
from pathlib import Path

PIECE = 96  # bytes of one literal


def literal(piece):
    """Octal escapes have at most three digits, so what follows cannot be taken for a part."""
    return '"' + "".join(
        chr(b) if 32 <= b < 127 and b not in b'"\\?' else f"\\{b:03o}" for b in piece) + '"'


def source(namespace, files):
    lines = ["// Made by tools/embed_files.py.", "#include <string_view>", "",
             f"namespace {namespace} {{", ""]
    for name, data in files:
        pieces = [literal(data[i:i + PIECE]) for i in range(0, len(data), PIECE)] or ['""']
        lines += [f"std::string_view {name}();", "", f"std::string_view {name}() {{",
                  "  static constexpr char kBytes[] ="]
        lines += [f"      {piece}" for piece in pieces]
        lines += ["      ;", f"  return {{kBytes, {len(data)}}};", "}", ""]
    return "\n".join(lines + [f"}}  // namespace {namespace}", ""])


def main(arguments):
    if len(arguments) < 3:
        print(__doc__, file=sys.stderr)
        return 2
    files = []
    for argument in arguments[2:]:
        name, _, path = argument.partition("=")
        data = Path(path).read_bytes() if path else b""
        files.append((name, gzip.decompress(data) if path.endswith(".gz") else data))
    Path(arguments[0]).write_text(source(arguments[1], files), encoding="ascii")
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
