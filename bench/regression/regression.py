#!/usr/bin/env python3
"""Every figure that must not get worse, in one table; and two tables compared.

    regression.py run --binary build/release/bin/rali --form short --out new.csv
    regression.py compare bench/regression/baseline_short.csv new.csv

README.md explains columns, rule and forms. Needs python3-numpy.
"""

import argparse
import hashlib
import os
import pathlib
import subprocess
import sys
from concurrent.futures import ThreadPoolExecutor, as_completed

import comparison
import rows
import table

USAGE, INTERRUPTED = 2, 130


def machine():
    """Processor and number of cores: CPU figures of other machines are not comparable."""
    model = "unknown processor"
    for line in pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
        if line.startswith("model name"):
            model = line.partition(":")[2].strip()
            break
    return f"{model}, {os.cpu_count()} cores"


def commit_of(binary):
    """Of the repository around the binary, with a mark if it was changed; empty outside of any."""
    done = subprocess.run(["git", "-C", str(binary.parent), "describe", "--always", "--dirty",
                           "--exclude", "*"], capture_output=True, text=True, check=False)
    return done.stdout.strip()


def head_of(args):
    binary = pathlib.Path(args.binary)
    digest = hashlib.sha256(binary.read_bytes()).hexdigest()[:16]
    return {"commit": args.commit or commit_of(binary) or "unknown", "binary": digest,
            "command": f"regression.py run --binary rali --form {args.form}"
                       + (f" --seeds {args.seeds}" if args.seeds else "")
                       + (f" --cases \"{args.cases}\"" if args.cases else "")
                       + (f" --preset {args.preset}" if args.preset else ""),
            "machine": machine()}


def planned(args):
    import cases  # numpy: not needed to compare
    names = args.cases.split(",") if args.cases else None
    unknown = set(names or ()) - {row.case for row in rows.ROWS}
    if unknown:
        raise table.TableError(f"--cases: there is no {', '.join(sorted(unknown))}")
    plan = rows.plan(args.form, cases.seeds_of(args.seeds) if args.seeds else None, names,
                     args.preset)
    if not args.campaign and any(row.kind == "campaign" for row, _ in plan):
        print("regression: the campaign is left out, --campaign names its program", file=sys.stderr)
        plan = [(row, seed) for row, seed in plan if row.kind != "campaign"]
    return plan


def print_estimate(plan):
    total = sum(row.cpu_s for row, _ in plan)
    print(f"regression: {len(plan)} runs, about {total / 60:.0f} CPU minutes", file=sys.stderr)


def lines_before(args, head):
    """Rows of a table that is continued."""
    out = pathlib.Path(args.out)
    if not out.exists():
        return {}
    if not args.resume:
        raise table.TableError(f"{out}: is there already. Use --resume, or another name")
    before, lines = table.read(out)
    if before.get("binary") != head["binary"]:
        raise table.TableError(f"{out}: was made by another binary, {before.get('binary')}")
    return lines


def run(args):
    if not os.access(args.binary, os.X_OK):
        raise table.TableError(f"{args.binary}: no program")
    sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cases"))
    import runs
    plan = planned(args)
    head = head_of(args)
    lines = lines_before(args, head)
    plan = [(row, seed) for row, seed in plan if (row.case, row.preset, seed) not in lines]
    print_estimate(plan)
    if args.estimate:
        return 0
    folder = pathlib.Path(args.folder or f"{args.out}.work")
    runner = runs.Runner(pathlib.Path(args.binary).resolve(), folder.resolve(),
                         pathlib.Path(args.recordings or folder).resolve(), args.limit, args.campaign)
    with ThreadPoolExecutor(max_workers=args.jobs) as pool:
        try:
            return measure(pool, runner, plan, lines, lambda: table.write(
                args.out, head, lines.values(), rows.order_of))
        except KeyboardInterrupt:
            pool.shutdown(wait=False, cancel_futures=True)
            print(f"regression: interrupted; --resume goes on with {args.out}", file=sys.stderr)
            return INTERRUPTED


def measure(pool, runner, plan, lines, save):
    """Fills `lines` and saves after each run. Exit code: 1 if a run could not be measured."""
    failed = 0
    jobs = {pool.submit(runner.run, row, seed): (row, seed) for row, seed in plan}
    for done, job in enumerate(as_completed(jobs), 1):
        row, seed = jobs[job]
        name = f"{row.case} {row.preset} {seed}"
        try:
            line = job.result()
        except (Exception, SystemExit) as error:  # one run must not end the others
            failed += 1
            print(f"regression: {name}: not measured: {error}", file=sys.stderr, flush=True)
            continue
        lines[table.key_of(line)] = line
        save()
        print(f"{done} of {len(plan)}: {name}", file=sys.stderr, flush=True)
    return 1 if failed else 0


def compare(args):
    base_head, base = table.read(args.base)
    new_head, new = table.read(args.new)
    for name in ("commit", "binary", "command", "machine"):
        same = base_head.get(name) == new_head.get(name)
        print(f"{name}: {base_head.get(name)}" + ("" if same else f"; NEW: {new_head.get(name)}"))
    print()
    result = comparison.compare(base, new, base_head.get("machine") == new_head.get("machine"))
    if not result.lines:
        raise table.TableError(f"{args.base} and {args.new}: no row in common")
    print(comparison.text_of(result, args.all), end="")
    both = len(base.keys() & new.keys())
    print(f"{both} runs compared, {len(base) - both} only in BASE, {len(new) - both} only in NEW: "
          + ("WORSE" if result.worse else "nothing is worse"))
    return 1 if result.worse else 0


def arguments():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    sub = parser.add_subparsers(dest="what", required=True)
    go = sub.add_parser("run", help="measure")
    go.add_argument("--binary", required=True, help="rali")
    go.add_argument("--form", choices=("short", "long"), default="short")
    go.add_argument("--out", required=True, help="table.csv")
    go.add_argument("--jobs", type=int, default=1, help="runs at a time")
    go.add_argument("--resume", action="store_true", help="go on with a table of the same binary")
    go.add_argument("--seeds", help="901,905-910 instead of those of the form")
    go.add_argument("--cases", help="names of rows, by commas")
    go.add_argument("--preset", help="only rows of this preset")
    go.add_argument("--folder", help="of outputs (default: OUT.work)")
    go.add_argument("--recordings", help="where recordings are kept and used again")
    go.add_argument("--campaign", help="program of bench/campaign, built by make bench")
    go.add_argument("--commit", help="of the binary, if it lies outside of its repository")
    go.add_argument("--limit", type=int, default=3600, help="seconds after which a run has failed")
    go.add_argument("--estimate", action="store_true", help="only print the CPU time it takes")
    against = sub.add_parser("compare", help="exit code 1 if NEW is worse")
    against.add_argument("base")
    against.add_argument("new")
    against.add_argument("--all", action="store_true", help="figures that are equal, too")
    return parser.parse_args()


def main():
    args = arguments()
    try:
        return run(args) if args.what == "run" else compare(args)
    except (table.TableError, OSError) as error:
        print(f"regression: {error}", file=sys.stderr)
        return USAGE


if __name__ == "__main__":
    sys.exit(main())
