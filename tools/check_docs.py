#!/usr/bin/env python3
"""Checks what the documents refer to; prints `file:line: message`, exit code 1.

usage: check_docs.py REPOSITORY

- a relative link of a page leads to a file, and its #fragment to a heading of that file
- a page inside docs/ links only inside docs/, as the site has nothing else
- a docs/....md that a page, a source or a script names exists
- a command of a ```sh block exists, and so does each of its options (docs/reference/cli.md)
- a setting that `rali map --set` or a guide names exists (docs/reference/settings*.md)
"""

import re
import sys
from pathlib import Path

SKIPPED = {"build", "node_modules", ".git", "site"}
HISTORY = {"CHANGELOG.md"}  # names pages as they were called then
SOURCES = {".cpp", ".hpp", ".py", ".sh", ".txt", ".cmake", ".yml"}
LINK = re.compile(r"!?\[(?:[^\]]|\n)*?\]\(([^)\s]+)\)")
PAGE = re.compile(r"\bdocs/[\w/.-]*?\.md\b")
SET = re.compile(r"--set '?([\w.]+)=")
KEY = re.compile(r"`((?:odometry|ranging|mission|map|vehicles|ranges|fleet\.\w+)\.[\w.]+)`")
FENCE = re.compile(r"^ *```(\w*)$")


def outside_of_code(text):
    """The text with the lines of code blocks and `code` emptied, so that line numbers stay."""
    lines, inside = [], False
    for line in text.splitlines():
        fence = FENCE.match(line)
        inside = inside != bool(fence)
        lines.append("" if inside or fence else re.sub(r"`[^`]*`", "", line))
    return "\n".join(lines)


def anchors_of(text):
    """The ids that the headings of a page get, on GitHub and from mkdocs alike."""
    for line in outside_of_code(text).splitlines():
        if re.match(r"#+ ", line):
            plain = re.sub(r"[^\w\- ]", "", line.lstrip("# ").lower())
            yield plain.strip().replace(" ", "-")


def shell_commands(text):
    """(line number, command) of the ```sh blocks, lines that end in a backslash joined."""
    number, joined, inside = 0, "", False
    for number, line in enumerate(text.splitlines(), 1):
        fence = FENCE.match(line)
        if fence:
            inside = fence[1] == "sh"
        elif inside:
            joined += line.rstrip("\\")
            if not line.endswith("\\"):
                yield number, joined
                joined = ""


class Documents:
    def __init__(self, root):
        self.root = Path(root).resolve()
        self.problems = []
        self.options = self.options_of_commands()
        self.settings = self.keys_of_settings()

    def files(self, suffixes):
        for path in sorted(self.root.rglob("*")):
            inside = path.relative_to(self.root).parts
            if path.suffix in suffixes and not SKIPPED & set(inside) and path.is_file():
                yield path

    def report(self, path, number, message):
        self.problems.append(f"{path.relative_to(self.root)}:{number}: {message}")

    def check(self):
        for path in self.files({".md"}):
            text = path.read_text(encoding="utf-8")
            self.check_links(path, outside_of_code(text))
            self.check_commands(path, text)
            self.check_keys(path, text)
            self.check_names(path, text)
        for path in (*self.files(SOURCES), self.root / "Makefile"):
            if path.is_file() and not path.name.startswith("check_docs"):
                self.check_names(path, path.read_text(encoding="utf-8", errors="replace"))
        return self.problems

    def check_links(self, path, text):
        for match in LINK.finditer(text):
            target, _, fragment = match[1].partition("#")
            if re.match(r"\w+:", target):
                continue
            number = text.count("\n", 0, match.start()) + 1
            page = (path.parent / target).resolve() if target else path
            if not page.exists():
                self.report(path, number, f"no file {target}")
            elif self.leaves_the_site(path, page):
                self.report(path, number, f"{target} is outside of docs/, the site has no such page")
            elif fragment and fragment not in anchors_of(page.read_text(encoding="utf-8")):
                self.report(path, number, f"no heading #{fragment} in {page.name}")

    def leaves_the_site(self, path, page):
        docs = self.root / "docs"
        return docs in path.parents and docs not in page.parents

    def check_names(self, path, text):
        if path.name in HISTORY:
            return
        for number, line in enumerate(text.splitlines(), 1):
            for name in PAGE.findall(line):
                if not (self.root / name).is_file():
                    self.report(path, number, f"no page {name}")

    def options_of_commands(self):
        """{command: options} by the generated reference of the commands."""
        path, options, command = self.root / "docs/reference/cli.md", {}, ""
        for line in path.read_text(encoding="utf-8").splitlines() if path.is_file() else ():
            heading = re.match(r"## rali (\S+)", line)
            if heading:
                command = heading[1]
                options[command] = {"--help", "-h", "--help-all"}
            elif line.startswith("| `-"):
                options[command].update(re.findall(r"-[-\w]+", line.split("`")[1]))
        return options

    def keys_of_settings(self):
        keys = set()
        for path in (self.root / "docs/reference").glob("settings*.md"):
            keys.update(re.findall(r"^\| `([\w.]+)`", path.read_text(encoding="utf-8"), re.M))
        return keys

    def is_setting(self, key):
        """Also of another vehicle than v1, without `settings.`, or of a group with a {...} value."""
        key = re.sub(r"^vehicles\.\w+\.", "vehicles.v1.", key)
        names = (key, f"settings.{key}")
        return any(k in names or k.startswith(tuple(n + "." for n in names)) for k in self.settings)

    def check_keys(self, path, text):
        commands = [(n, c) for n, c in shell_commands(text) if re.search(r"\brali (map|doctor)\b", c)]
        named = [(n, key) for n, c in commands for key in SET.findall(c)]
        if path.parent.name == "guide":
            lines = enumerate(text.splitlines(), 1)
            keys = [(n, key) for n, line in lines for key in KEY.findall(line)]
            named += [(n, key) for n, key in keys if not key.endswith((".csv", ".yaml"))]
        for number, key in named:
            if not self.is_setting(key):
                self.report(path, number, f"no setting {key}")

    def check_commands(self, path, text):
        for number, line in shell_commands(text):
            called = re.search(r"(?:^|[;|&]|\$\()\s*rali ([\w-]+)([^|;&#]*)", line)
            if not called or called[1].startswith(("-", "help")):
                continue
            known = self.options.get(called[1])
            if known is None:
                self.report(path, number, f"no command rali {called[1]}")
                continue
            for option in re.findall(r"(?<=\s)-{1,2}[A-Za-z][-\w]*", called[2]):
                if option not in known:
                    self.report(path, number, f"rali {called[1]} has no option {option}")


if __name__ == "__main__":
    found = Documents(sys.argv[1]).check()
    print("\n".join(found) if found else "documents: links, names and commands in order")
    sys.exit(bool(found))
