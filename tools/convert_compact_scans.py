#!/usr/bin/env python3
"""Convert a folder of compact scans to a folder that `rali map` reads.

Compact scans are records of 8 bytes, little endian, int16 x y z in units of 2.5 mm, then
  .xyzir  uint8 intensity (0..100), uint8 ring
  .xyzi   uint16 intensity (sensor counts)

Each becomes a KITTI .bin (float32 x y z intensity; rings are lost) or, with --format pcd, a binary
PCD that keeps the ring. Standard library only.

example: convert_compact_scans.py kitti_0005/scans16 out --period 0.10356
example: convert_compact_scans.py hku_keyframes/scans out --times hku_keyframes/poses.tum
"""
import argparse
import array
import os
import struct
import sys

LSB_M = 0.0025
RECORD_BYTES = 8
ROW = {".xyzir": ("<hhhBB", 0.01), ".xyzi": ("<hhhH", 1.0)}  # layout, unit of intensity


def read_rows(path):
    """Rows of (x, y, z, intensity, ring or None); a cut last record is left out and said."""
    layout, unit = ROW[os.path.splitext(path)[1]]
    with open(path, "rb") as f:
        data = f.read()
    rest = len(data) % RECORD_BYTES
    if rest:
        print(f"{path}: ends {rest} bytes into a record; left out", file=sys.stderr)
        data = data[: len(data) - rest]
    for row in struct.iter_unpack(layout, data):
        x, y, z = (LSB_M * v for v in row[:3])
        yield x, y, z, unit * row[3], row[4] if len(row) == 5 else None


def little_endian(values):
    if sys.byteorder == "big":
        values.byteswap()
    return values.tobytes()


def write_bin(path, rows):
    values = array.array("f")
    for x, y, z, intensity, _ in rows:
        values.extend((x, y, z, intensity))
    with open(path, "wb") as f:
        f.write(little_endian(values))


def write_pcd(path, rows):
    rows = list(rows)
    rings = bool(rows) and rows[0][4] is not None
    body = bytearray()
    for x, y, z, intensity, ring in rows:
        body += struct.pack("<ffff", x, y, z, intensity)
        if rings:
            body += struct.pack("<H", ring)
    names, sizes, types, counts = "x y z intensity", "4 4 4 4", "F F F F", "1 1 1 1"
    if rings:
        names, sizes, types, counts = names + " ring", sizes + " 2", types + " U", counts + " 1"
    header = (
        "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\n"
        f"FIELDS {names}\nSIZE {sizes}\nTYPE {types}\nCOUNT {counts}\n"
        f"WIDTH {len(rows)}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {len(rows)}\nDATA binary\n"
    )
    with open(path, "wb") as f:
        f.write(header.encode("ascii") + body)


def stamps_of_tum(path):
    """First word of each line that is no comment, as text: no rounding."""
    with open(path, encoding="utf-8") as f:
        lines = [line.split() for line in f]
    return [words[0] for words in lines if words and not words[0].startswith("#")]


def stamps(args, n):
    if args.times:
        found = stamps_of_tum(args.times)
        if len(found) < n or (not args.count and len(found) != n):
            sys.exit(f"{args.times}: {len(found)} stamps for {n} scans")
        return found[:n]
    if args.period:
        return [f"{i * args.period:.9f}" for i in range(n)]
    return []


def main():
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", help="with *.xyzir or *.xyzi")
    parser.add_argument("out", help="folder to write; made if it is not there")
    parser.add_argument("--format", choices=["bin", "pcd"], default="bin")
    parser.add_argument("--times", help="TUM file with a stamp for each scan -> times.txt")
    parser.add_argument("--period", type=float, help="seconds between scans -> times.txt")
    parser.add_argument("--count", type=int, help="only the first N scans")
    args = parser.parse_args()
    if args.times and args.period:
        parser.error("--times and --period exclude each other")
    try:
        names = sorted(n for n in os.listdir(args.folder) if os.path.splitext(n)[1] in ROW)
    except OSError as error:
        sys.exit(f"{args.folder}: {error.strerror}")
    if not names:
        sys.exit(f"{args.folder}: no *.xyzir and no *.xyzi")
    names = names[: args.count] if args.count else names
    times = stamps(args, len(names))
    os.makedirs(args.out, exist_ok=True)
    write = write_bin if args.format == "bin" else write_pcd
    for name in names:
        target = os.path.join(args.out, os.path.splitext(name)[0] + "." + args.format)
        write(target, read_rows(os.path.join(args.folder, name)))
    if times:
        with open(os.path.join(args.out, "times.txt"), "w", encoding="ascii") as f:
            f.write("".join(t + "\n" for t in times))
    print(f"{len(names)} scans in {args.out}")


if __name__ == "__main__":
    main()
