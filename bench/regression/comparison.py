"""Two tables, paired per seed: what became worse by the rule of README.md."""

import math
from dataclasses import dataclass

# Student's t, 97.5 %, for 1 to 30 degrees of freedom.
T_975 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160,
         2.145, 2.131, 2.120, 2.110, 2.101, 2.093, 2.086, 2.080, 2.074, 2.069, 2.064, 2.060, 2.056,
         2.052, 2.048, 2.045, 2.042)
RELATIVE = 0.03
LENGTH_M = 0.001
CPU_RELATIVE = 0.10  # repeated runs of one binary on a shared machine differ by 5 %
# Below ten seeds the worst decile is one seed, and that one alone scatters more.
FEW = 10
FEW_RELATIVE = 0.20
FEW_LENGTH_M = 0.005
NEES_MIN = 1e-6  # the logarithm of a NEES of zero


@dataclass(frozen=True)
class Figure:
    """A column that is judged. rule: length, ratio (smaller is better), gain (larger is), log."""
    name: str
    rule: str
    relative: float = RELATIVE


FIGURES = (
    Figure("ape_live_m", "length"), Figure("ape_live_max_m", "length"),
    Figure("ape_final_m", "length"), Figure("ape_final_max_m", "length"),
    Figure("along_live_m", "length"), Figure("along_final_m", "length"),
    Figure("nees_live_position", "log"), Figure("nees_live_pose", "log"),
    Figure("nees_final_position", "log"), Figure("nees_final_pose", "log"), Figure("nis", "log"),
    Figure("to_mesh_m", "length"), Figure("complete", "gain"), Figure("ranges_applied", "gain"),
    Figure("seen", "gain"), Figure("rounds", "ratio"), Figure("cpu_s", "ratio", CPU_RELATIVE),
    Figure("mission_cpu_s", "ratio", CPU_RELATIVE), Figure("memory_mb", "ratio"),
    Figure("traffic_bytes", "ratio"))
ALL_SEEN = 0.95  # of the floor; the rest is corners behind things
CPU_TIMES = ("cpu_s", "mission_cpu_s")
FAILURES = {
    "exit code not 0": lambda r: r.get("exit") not in (0, None),
    "no trajectory": lambda r: r.get("ape_final_m") is None,
    "vehicles not in one frame": lambda r: (r.get("frames") or 0) < (r.get("vehicles") or 0),
    "frames wrong": lambda r: bool(r.get("frames_wrong")),
    "loops wrong": lambda r: bool(r.get("loops_wrong")),
    "not explored": lambda r: r.get("explored") == 0,
    "not all seen": lambda r: r.get("seen") is not None and r["seen"] < ALL_SEEN,
    "silent failure": lambda r: bool(r.get("silent")),
}


def t_quantile(dof):
    """97.5 %; above the table by its expansion, right to 0.002."""
    return T_975[dof - 1] if dof <= len(T_975) else 1.960 + 2.4 / dof


def badness(figure, value):
    """Larger is worse, in units of the tolerance."""
    if figure.rule == "log":
        return abs(math.log(max(value, NEES_MIN)))
    return -value if figure.rule == "gain" else value


def tolerance(figure, level, few=False):
    """How much `level`, a mean of what is measured, may become worse."""
    relative = max(figure.relative, FEW_RELATIVE) if few else figure.relative
    if figure.rule == "log":
        return math.log(1.0 + relative)
    if figure.rule == "length":
        return max(relative * abs(level), FEW_LENGTH_M if few else LENGTH_M)
    return relative * abs(level)


def mean(values):
    return sum(values) / len(values)


def interval(differences):
    """Mean of the differences and its 95 % interval by Student's t; None for a single seed."""
    n = len(differences)
    middle = mean(differences)
    if n < 2:
        return middle, None
    variance = sum((d - middle) ** 2 for d in differences) / (n - 1)
    half = t_quantile(n - 1) * math.sqrt(variance / n)
    return middle, (middle - half, middle + half)


def worst_decile(values):
    """Mean of the worst tenth, at least of one."""
    k = math.ceil(len(values) / 10)
    return mean(sorted(values)[-k:])


@dataclass
class Line:
    """One figure of one row, BASE against NEW; differences in badness."""
    case: str
    preset: str
    figure: str
    seeds: int
    base: float
    new: float
    difference: float
    bounds: tuple
    decile_base: float
    decile_new: float
    verdict: str


def judge(figure, pairs):
    """Line of the paired values; case and preset are filled in by the caller."""
    base, new = [p[0] for p in pairs], [p[1] for p in pairs]
    bad_base, bad_new = [badness(figure, v) for v in base], [badness(figure, v) for v in new]
    difference, bounds = interval([n - b for b, n in zip(bad_base, bad_new)])
    allowed = tolerance(figure, mean(base))
    low, high = worst_decile(bad_base), worst_decile(bad_new)
    few = len(pairs) < FEW
    tail = high - low > tolerance(figure, low, few)
    if bounds and bounds[0] > 0.0 and difference > allowed:
        verdict = "WORSE"
    elif tail:
        verdict = "WORSE, worst decile"
    elif bounds and bounds[1] < 0.0 and -difference > allowed:
        verdict = "better"
    elif bad_base == bad_new:
        verdict = "equal"
    else:
        verdict = "not worse"
    return Line("", "", figure.name, len(pairs), mean(base), mean(new), difference, bounds, low, high,
                verdict)


def groups_of(base, new):
    """Seeds that both tables have, by (case, preset), in the order of BASE."""
    groups = {}
    for key in base:
        if key in new:
            groups.setdefault(key[:2], []).append(key)
    return groups


@dataclass
class Comparison:
    lines: list
    failures: list  # (case, preset, kind, seeds of BASE, seeds of NEW)
    notes: list

    @property
    def worse(self):
        return (any(line.verdict.startswith("WORSE") for line in self.lines)
                or any(len(new) > len(base) for _, _, _, base, new in self.failures))


def missing_notes(base, new):
    notes = []
    for name, have, other in (("BASE", base, new), ("NEW", new, base)):
        missing = {}
        for key in have:
            if key not in other:
                missing.setdefault(key[:2], []).append(str(key[2]))
        for (case, preset), seeds in missing.items():
            notes.append(f"only in {name}: {case} {preset}, seeds {' '.join(seeds)}")
    return notes


def compare(base, new, same_machine=True):
    """`base` and `new`: rows by (case, preset, seed), as table.read gives them.

    same_machine: else processor times say nothing and are left out.
    """
    out = Comparison([], [], missing_notes(base, new))
    if not same_machine:
        out.notes.append("the tables were made on different machines: CPU time is not compared")
    for (case, preset), keys in groups_of(base, new).items():
        other_input = [str(k[2]) for k in keys if base[k].get("input") != new[k].get("input")]
        if other_input:
            out.notes.append(f"other input: {case} {preset}, seeds {' '.join(other_input)}")
        for kind, failed in FAILURES.items():
            seeds = [[k[2] for k in keys if failed(rows[k])] for rows in (base, new)]
            if seeds[0] or seeds[1]:
                out.failures.append((case, preset, kind, *seeds))
        for figure in FIGURES:
            if figure.name in CPU_TIMES and not same_machine:
                continue
            add_figure(out, case, preset, figure, [(base[k], new[k]) for k in keys])
    return out


def add_figure(out, case, preset, figure, rows):
    pairs, lost = [], []
    for old, fresh in rows:
        a, b = old.get(figure.name), fresh.get(figure.name)
        if a is not None and b is not None:
            pairs.append((a, b))
        elif a != b:
            lost.append(f"{old['seed']} ({'NEW' if b is None else 'BASE'})")
    if lost:
        out.notes.append(f"no {figure.name}: {case} {preset}, seeds {' '.join(lost)}")
    if pairs:
        line = judge(figure, pairs)
        line.case, line.preset = case, preset
        out.lines.append(line)


def seeds_text(seeds):
    return f"{len(seeds)}" + (f" ({' '.join(str(s) for s in seeds)})" if seeds else "")


def text_of(comparison, every=False):
    """Markdown: failures, then figures; equal ones only if `every`."""
    text = "| case | preset | failure | BASE | NEW | |\n|---|---|---|---|---|---|\n"
    for case, preset, kind, base, new in comparison.failures:
        verdict = "WORSE" if len(new) > len(base) else ("better" if len(new) < len(base) else "")
        text += f"| {case} | {preset} | {kind} | {seeds_text(base)} | {seeds_text(new)} | {verdict} |\n"
    text += ("\n| case | preset | figure | seeds | BASE | NEW | worse by | 95 % | worst decile "
             "BASE | NEW | |\n|---|---|---|---|---|---|---|---|---|---|---|\n")
    hidden = 0
    for line in comparison.lines:
        if line.verdict == "equal" and not every:
            hidden += 1
            continue
        bounds = f"{line.bounds[0]:.3g} to {line.bounds[1]:.3g}" if line.bounds else "one seed"
        text += (f"| {line.case} | {line.preset} | {line.figure} | {line.seeds} | {line.base:.4g} | "
                 f"{line.new:.4g} | {line.difference:+.3g} | {bounds} | {abs(line.decile_base):.4g} | "
                 f"{abs(line.decile_new):.4g} | {line.verdict} |\n")
    text += f"\n{hidden} figures are equal in every seed.\n" if hidden else ""
    return text + "".join(f"{note}\n" for note in comparison.notes)
