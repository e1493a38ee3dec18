"""The rows of the table: which case, how it is mapped, in which form."""

from dataclasses import dataclass

FIRST_SEED = 901  # used by no other bench


@dataclass(frozen=True)
class Row:
    """One row per seed. `recording` names a case of bench/cases, or the scene of a mission."""
    case: str
    recording: str
    preset: str = "robust"
    kind: str = "replay"  # replay, mission or campaign
    duration_s: float = None  # of the recording instead of the case's own
    vehicles: int = 1
    noise: str = "none"
    lidar_only: bool = False
    settings: tuple = ()
    short: int = 3  # seeds in either form; 0: not in it
    long: int = 20
    cpu_s: float = 60.0  # of one seed, recording included, on a core of 2.5 GHz


ROWS = (
    Row("single corridor", "single_corridor", cpu_s=17),
    Row("single floor", "floor", cpu_s=19),
    Row("LiDAR only", "floor", lidar_only=True, cpu_s=12),
    Row("corridor", "pair_corridor", vehicles=2, duration_s=100, cpu_s=37),
    Row("floor", "fleet_floor", vehicles=3, cpu_s=50),
    Row("tunnel from portal", "portal", vehicles=2, duration_s=120, cpu_s=45),
    Row("tunnel middle", "middle", vehicles=2, duration_s=120, cpu_s=45),
    Row("single floor", "floor", preset="paper", cpu_s=12),
    Row("corridor", "pair_corridor", preset="paper", vehicles=2, duration_s=100, cpu_s=27),
    Row("tunnel from portal", "portal", preset="paper", vehicles=2, duration_s=120, cpu_s=30),
    Row("mission corridor", "corridor", kind="mission", vehicles=2, cpu_s=100),
    Row("mission floor", "floor", kind="mission", vehicles=3, short=1, cpu_s=250),
    Row("shaken corridor", "corridor", noise="sheet", short=0, cpu_s=35),
    *(Row(f"single {scene}", f"single_{scene}", short=0, cpu_s=25)
      for scene in ("loop", "yard", "garage", "mine", "ramp", "hall", "warehouse")),
    Row("floor", "fleet_floor", preset="paper", vehicles=3, short=0, cpu_s=30),
    Row("curved tunnel", "leap_frog", vehicles=4, short=0, long=5, cpu_s=800),
    Row("kilometre", "kilometre", vehicles=4, settings=("fleet.solve=rounds",), short=0, long=5,
        cpu_s=4000),
    Row("campaign", "campaign", kind="campaign", short=0, long=100, cpu_s=90),
)


def plan(form, seeds=None, cases=None, preset=None):
    """(row, seed) of a form, seed by seed: an interrupted run has some seeds of each row.

    seeds: instead of those of the form. cases: names of rows, None for all; preset alike.
    """
    out = []
    for row in ROWS:
        count = row.short if form == "short" else row.long
        if count == 0 or (cases and row.case not in cases) or (preset and row.preset != preset):
            continue
        own = seeds or range(FIRST_SEED, FIRST_SEED + count)
        out += [(index, row, seed) for index, seed in enumerate(own)]
    out.sort(key=lambda item: item[0])
    return [(row, seed) for _, row, seed in out]


def order_of(line):
    """Sorting key of a row of the table: as in ROWS, then by seed."""
    names = [(row.case, row.preset) for row in ROWS]
    key = (line["case"], line["preset"])
    return (names.index(key) if key in names else len(names), key, line["seed"])
