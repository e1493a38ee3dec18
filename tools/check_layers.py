#!/usr/bin/env python3
"""Checks the house rules that a machine can check; prints `file:line: message`, exit code 1.

usage: check_layers.py SOURCE_DIR [--print-ratchet]

- a room includes only the rooms that tools/layers.txt allows, and src/rali/CMakeLists.txt names the
  same rooms as DEPS; no cycles
- nobody includes <room>/internal/ of another room
- banned headers stay where tools/layers.txt lets them
- files have at most 400 lines, functions at most 60; tools/ratchet.txt lists the exceptions with
  their length, which may only shrink
"""

import re
import sys
from pathlib import Path

MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
SUFFIXES = (".hpp", ".cpp")


class Layers:
    """tools/layers.txt: allowed[room] = rooms in order, bans[header] = (rooms, replacement)."""

    def __init__(self, path):
        self.allowed = {}
        self.lines = {}
        self.bans = {}
        self.problems = []
        for number, line in enumerate(path.read_text().splitlines(), 1):
            where = f"{path}:{number}"
            line = line.split("#", 1)[0].strip()
            if not line:
                continue
            ban = re.fullmatch(r"ban\s+(\S+):\s*([^|]*)\|\s*(.+)", line)
            room = re.fullmatch(r"(\w+):\s*(.*)", line)
            if ban:
                self.bans[ban[1]] = (set(ban[2].split()), ban[3])
            elif room:
                if room[1] in self.allowed:
                    self.problems.append(f"{where}: room {room[1]} is listed twice")
                for dep in room[2].split():
                    if dep not in self.allowed:
                        self.problems.append(
                            f"{where}: {room[1]} may not include {dep}: not listed above it (cycle)")
                self.allowed[room[1]] = room[2].split()
                self.lines[room[1]] = number
            else:
                self.problems.append(f"{where}: not understood: {line}")


def without_comments_and_text(text):
    """The same text with comments, strings and characters blanked; line numbers stay."""
    pattern = re.compile(
        r'R"(?P<tag>[^()\s\\]{0,16})\(.*?\)(?P=tag)"'  # raw string
        r"|//[^\n]*|/\*.*?\*/"
        r'|"(?:\\.|[^"\\\n])*"'
        r"|(?<![0-9a-zA-Z])'(?:\\.|[^'\\\n])+'",
        re.S)

    def blank(match):
        return re.sub(r"[^\n]", " ", match[0])

    return pattern.sub(blank, text)


def is_function_head(head):
    """Whether the text before a '{' is the head of a function (and not of a type or a block)."""
    head = head.strip()
    if "(" not in head or re.search(r"(^|\s)(namespace|enum)\b", head):
        return False
    if re.match(r"(else\s+)?(if|for|while|switch|catch|do|else)\b", head):
        return False
    if re.search(r"\b(class|struct|union)\s+\w+[^()]*$", head):
        return False
    return not re.search(r"=\s*$|\breturn\b|\[[^\]]*\]\s*(\([^)]*\))?[^()]*$", head)


def functions(text):
    """(first line, name, number of lines) of each function body."""
    found = []
    stack = []  # (is function, line, name)
    head_begin = 0
    line = 1
    head_line = None
    inside = 0
    for at, char in enumerate(text):
        if char == "\n":
            line += 1
        if head_line is None and not char.isspace() and char not in "{};":
            head_line = line
            head_begin = at
        if char == "{":
            head = text[head_begin:at] if head_line is not None else ""
            if head and (head[-1].isalnum() or head[-1] in "_>" or head.count("(") > head.count(")")):
                stack.append((None, 0, ""))  # a value in braces: the head goes on behind it
                continue
            is_function = inside == 0 and is_function_head(head)
            name = re.search(r"([\w:~]+|operator\S+)\s*\(", head)
            stack.append((is_function, head_line or line, name[1] if name else "?"))
            inside += is_function
            head_line = None
        elif char == "}":
            if stack:
                is_function, begin, name = stack.pop()
                if is_function is None:
                    continue
                if is_function:
                    inside -= 1
                    found.append((begin, name, line - begin + 1))
            head_line = None
        elif char == ";":
            head_line = None
    return found


def read_ratchet(path, problems):
    """tools/ratchet.txt: `file lines` or `file function lines`."""
    ratchet = {}
    if not path.exists():
        return ratchet
    for number, line in enumerate(path.read_text().splitlines(), 1):
        words = line.split("#", 1)[0].split()
        if not words:
            continue
        if len(words) not in (2, 3) or not words[-1].isdigit():
            problems.append(f"{path}:{number}: not understood: {line}")
            continue
        ratchet[tuple(words[:-1])] = (int(words[-1]), f"{path}:{number}")
    return ratchet


class Checker:
    def __init__(self, root):
        self.root = root
        self.layers = Layers(root / "tools" / "layers.txt")
        self.problems = list(self.layers.problems)
        self.ratchet = read_ratchet(root / "tools" / "ratchet.txt", self.problems)
        self.lengths = {}  # key of the ratchet -> (length, where)

    def source_files(self):
        for folder in ("src", "include", "python", "examples", "tests", "bench"):
            for path in sorted((self.root / folder).rglob("*")):
                if path.suffix in SUFFIXES and path.is_file():
                    yield path

    def room_of(self, path):
        parts = path.relative_to(self.root).parts
        return parts[2] if parts[:2] == ("src", "rali") and len(parts) > 3 else None

    def check_include(self, path, number, included):
        room = self.room_of(path)
        where = f"{path.relative_to(self.root)}:{number}"
        if included in self.layers.bans and room is not None:
            rooms, instead = self.layers.bans[included]
            if room not in rooms:
                self.problems.append(f"{where}: {included} is banned in {room}: {instead}")
        target = re.fullmatch(r'"rali/(\w+)/(.+)"', included)
        if not target:
            return
        other, rest = target[1], target[2]
        if not (self.root / "src" / "rali" / other / rest).is_file():
            self.problems.append(f"{where}: there is no {included}")
        if other not in self.layers.allowed:
            self.problems.append(f"{where}: {other} is no room of tools/layers.txt")
        elif room is not None and other != room:
            if other not in self.layers.allowed.get(room, []):
                self.problems.append(f"{where}: {room} may not include {other}")
            if "internal/" in rest:
                self.problems.append(f"{where}: {included} is internal to {other}")

    def check_file(self, path):
        name = str(path.relative_to(self.root))
        text = path.read_text(encoding="utf-8", errors="replace")
        for number, line in enumerate(text.splitlines(), 1):
            include = re.match(r'\s*#\s*include\s*(<[^>]+>|"[^"]+")', line)
            if include:
                self.check_include(path, number, include[1])
        room = self.room_of(path)
        if room is not None and room not in self.layers.allowed:
            self.problems.append(f"{name}:1: room {room} is not in tools/layers.txt")
        self.lengths[(name,)] = (text.count("\n"), f"{name}:1")
        for begin, function, length in functions(without_comments_and_text(text)):
            if length > self.lengths.get((name, function), (0, ""))[0]:
                self.lengths[(name, function)] = (length, f"{name}:{begin}")

    def check_lengths(self):
        for key, (length, where) in self.lengths.items():
            limit = MAX_FILE_LINES if len(key) == 1 else MAX_FUNCTION_LINES
            what = "file" if len(key) == 1 else f"function {key[1]}"
            if key in self.ratchet:
                kept, ratchet_where = self.ratchet[key]
                if length > kept:
                    self.problems.append(f"{where}: {what} has {length} lines and had {kept}: "
                                         "a ratchet may only shrink")
                elif length < kept or length <= limit:
                    fix = f"write {length}" if length > limit else "remove the line"
                    self.problems.append(f"{ratchet_where}: {what} has only {length} lines: {fix}")
            elif length > limit:
                self.problems.append(f"{where}: {what} has {length} lines; at most {limit}")
        for key, (_, where) in self.ratchet.items():
            if key not in self.lengths:
                self.problems.append(f"{where}: {' '.join(key)} is gone: remove the line")

    def check_cmake(self):
        path = self.root / "src" / "rali" / "CMakeLists.txt"
        text = path.read_text()
        seen = set()
        for call in re.finditer(r"rali_room\(([^)]*)\)", text):
            where = f"src/rali/CMakeLists.txt:{text.count(chr(10), 0, call.start()) + 1}"
            words = call[1].split()
            room = words[words.index("NAME") + 1]
            deps = []
            if "DEPS" in words:
                for word in words[words.index("DEPS") + 1:]:
                    if word.isupper():  # the next argument: LIBS, HOT
                        break
                    deps.append(word)
            if room not in self.layers.allowed:
                self.problems.append(f"{where}: room {room} is not in tools/layers.txt")
            elif set(deps) != set(self.layers.allowed[room]):
                self.problems.append(
                    f"{where}: DEPS of {room} and tools/layers.txt differ: "
                    + " ".join(sorted(set(deps) ^ set(self.layers.allowed[room]))))
            seen.add(room)
        for room in self.layers.allowed:
            if room not in seen:
                self.problems.append(f"tools/layers.txt:{self.layers.lines[room]}: "
                                     f"no rali_room(NAME {room}) in src/rali/CMakeLists.txt")

    def run(self):
        self.check_cmake()
        for path in self.source_files():
            self.check_file(path)
        self.check_lengths()
        return self.problems


def print_ratchet(lengths):
    for key, (length, _) in sorted(lengths.items()):
        if length > (MAX_FILE_LINES if len(key) == 1 else MAX_FUNCTION_LINES):
            print(*key, length)


def main(arguments):
    if not arguments:
        print(__doc__, file=sys.stderr)
        return 2
    checker = Checker(Path(arguments[0]).resolve())
    problems = checker.run()
    if "--print-ratchet" in arguments:
        print_ratchet(checker.lengths)
        return 0
    for problem in problems:
        print(problem)
    if not problems:
        print(f"{len([k for k in checker.lengths if len(k) == 1])} files, "
              f"{len(checker.layers.allowed)} rooms: in order")
    return 1 if problems else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
