"""The table of one binary: a head of comment lines, then one row per case, preset and seed."""

import csv
import pathlib

KEY = ("case", "preset", "seed")
COLUMNS = KEY + (
    "input", "exit", "vehicles",
    "ape_live_m", "ape_live_max_m", "ape_final_m", "ape_final_max_m",
    "along_live_m", "along_final_m",
    "nees_live_position", "nees_live_pose", "nees_final_position", "nees_final_pose", "nis",
    "to_mesh_m", "complete",
    "frames", "frames_wrong", "loops", "loops_wrong", "silent",
    "ranges", "ranges_used", "ranges_applied", "rounds", "explored", "seen",
    "findings", "cpu_s", "mission_cpu_s", "memory_mb", "traffic_bytes")
TEXTS = ("case", "preset", "input", "findings")


class TableError(Exception):
    """A table that cannot be read; the text names file and line."""


def key_of(row):
    return tuple(row[name] for name in KEY)


def number_text(value):
    """Four digits are enough to see a change of 3 %; whole numbers stay whole."""
    if value is None:
        return ""
    if isinstance(value, str):
        return value
    if float(value).is_integer():
        return str(int(value))
    return f"{value:.4g}"


def row_text(row):
    unknown = set(row) - set(COLUMNS)
    if unknown:
        raise TableError(f"no such column: {', '.join(sorted(unknown))}")
    return ",".join(number_text(row.get(name)) for name in COLUMNS)


def head_text(head):
    return "".join(f"# {name}: {value}\n" for name, value in head.items())


def parsed(cells, where):
    row = {}
    for name, text in cells.items():
        if name in TEXTS:
            row[name] = text
        elif text == "":
            row[name] = None
        else:
            try:
                row[name] = int(text) if name == "seed" else float(text)
            except ValueError as error:
                raise TableError(f"{where}: {name} is \"{text}\", not a number") from error
    return row


def read(path):
    """Head as a dict, rows as a dict by (case, preset, seed)."""
    head, rows, body = {}, {}, []
    text = pathlib.Path(path).read_text(encoding="utf-8")
    for number, line in enumerate(text.splitlines(), 1):
        if line.startswith("# "):
            name, _, value = line[2:].partition(": ")
            head[name] = value
        elif line:
            body.append((number, line))
    if not body:
        raise TableError(f"{path}: has no row of column names")
    columns = body[0][1].split(",")
    unknown = [name for name in columns if name not in COLUMNS]
    if unknown or any(name not in columns for name in KEY):
        raise TableError(f"{path}:{body[0][0]}: columns are not those of this table {unknown}")
    for number, line in body[1:]:
        cells = next(csv.reader([line]))
        where = f"{path}:{number}"
        if len(cells) != len(columns):
            raise TableError(f"{where}: {len(cells)} cells for {len(columns)} columns")
        row = parsed(dict(zip(columns, cells)), where)
        if key_of(row) in rows:
            raise TableError(f"{where}: {key_of(row)} stands here for the second time")
        rows[key_of(row)] = row
    return head, rows


def write(path, head, rows, order):
    """The whole table, rows in the order of `order` (a key for sorting)."""
    text = head_text(head) + ",".join(COLUMNS) + "\n"
    for row in sorted(rows, key=order):
        text += row_text(row) + "\n"
    path = pathlib.Path(path)
    unfinished = path.with_name(path.name + ".tmp")
    unfinished.write_text(text, encoding="utf-8")
    unfinished.replace(path)
