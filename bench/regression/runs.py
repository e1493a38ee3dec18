"""One run: recording, map, evaluation, and the figures of its row."""

import hashlib
import json
import pathlib
import subprocess
import sys
import threading
from types import SimpleNamespace

HERE = pathlib.Path(__file__).resolve().parent
for bench in ("cases", "nees"):
    sys.path.insert(0, str(HERE.parent / bench))

import cases  # noqa: E402
import coverage  # noqa: E402
import nees  # noqa: E402
import truth  # noqa: E402

DONE, WITH_GAPS = 0, 3


class Runner:
    """Runs rows with one binary. Recordings are shared between binaries, outputs are not."""

    def __init__(self, binary, folder, recordings, limit_s=3600, campaign=None):
        self.binary, self.folder, self.limit_s = pathlib.Path(binary), pathlib.Path(folder), limit_s
        self.recordings, self.campaign = pathlib.Path(recordings), campaign
        self.locks, self.guard = {}, threading.Lock()
        self.folder.mkdir(parents=True, exist_ok=True)

    def run(self, row, seed):
        """The row of the table as a dict."""
        line = {"case": row.case, "preset": row.preset, "seed": seed}
        if row.kind == "campaign":
            line.update(self.campaign_figures(seed))
            return line
        line["vehicles"] = row.vehicles
        name = f"{row.case} {row.preset} {seed}".replace(" ", "_")
        if row.kind == "mission":
            recording = self.folder / "missions" / name
            used = self.mission(row, seed, recording)
            line.update(exit=used["exit"], mission_cpu_s=used["cpu_s"])
            if not cases.is_whole(recording):
                return line
            fleet = recording / "fleet.yaml"
            line.update(mission_figures(recording), seen=coverage.seen_fraction(recording / "truth"))
        else:
            recording, fleet = self.recording_of(row, seed)
            line["input"] = input_hash(recording)
        out = self.folder / "out" / name
        used = self.map(row, fleet, out)
        line.update(cpu_s=used["cpu_s"], memory_mb=used["memory_mb"],
                    exit=line.get("exit") or used["exit"])
        if used["exit"] in (DONE, WITH_GAPS):
            line.update(self.evaluated(recording, out))
        cases.drop_big_files(out)
        return line

    def recording_of(self, row, seed):
        """Folder and fleet.yaml; one thread at a time makes a recording."""
        args = SimpleNamespace(rali=self.binary, folder=self.recordings, noise=row.noise,
                               priors="given")
        with self.guard:
            lock = self.locks.setdefault((row.recording, row.duration_s, seed), threading.Lock())
        with lock:
            recording = cases.recorded(args, row.recording, seed, row.duration_s)
            fleet = cases.fleet_file(args, recording, seed)
            return recording, nees.without_imu(fleet) if row.lidar_only else fleet

    def command(self, name, words):
        """Exit code, CPU s and peak memory of a command of the binary."""
        usage = self.folder / "usage" / f"{name}.json"
        usage.parent.mkdir(exist_ok=True)
        log = usage.with_suffix(".log")
        with open(log, "w", encoding="utf-8") as file:
            subprocess.run([sys.executable, "-S", "-E", HERE / "measured.py", usage,
                            str(self.limit_s), self.binary, *map(str, words)],
                           stdout=subprocess.DEVNULL, stderr=file, check=False)
        return json.loads(usage.read_text(encoding="utf-8"))

    def mission(self, row, seed, recording):
        recording.parent.mkdir(exist_ok=True)
        return self.command(recording.name + "_drive",
                            ["simulate", row.recording, "--closed-loop", "--vehicles", row.vehicles,
                             "--seed", seed, "-o", recording, "--overwrite", "-q", "--threads", 1])

    def map(self, row, fleet, out):
        words = ["map", fleet, "-o", out, "--overwrite", "-q", "--preset", row.preset, "--threads", 1,
                 "--no-mcap", "--no-report", "--no-keyframes", "--formats", "pcd"]
        settings = list(row.settings)
        if row.recording in cases.CASES and cases.CASES[row.recording][2]:
            settings.append("map.dynamic.remove=false")
        for setting in settings:
            words += ["--set", setting]
        return self.command(out.name + "_map", words)

    def evaluated(self, recording, out):
        used = self.command(out.name + "_evaluate",
                            ["evaluate", out, "--truth", recording / "truth", "-q", "--threads", 1])
        if used["exit"] != DONE:
            return {"exit": used["exit"]}
        return figures_of(out, recording / "truth")

    def campaign_figures(self, seed):
        """One run of bench/campaign."""
        path = self.folder / "campaign" / f"{seed}.jsonl"
        path.parent.mkdir(exist_ok=True)
        path.unlink(missing_ok=True)
        done = subprocess.run([str(self.campaign), "--seeds", str(seed), "--out", str(path), "--jobs",
                               "1", "--limit", str(self.limit_s)], stdout=subprocess.DEVNULL,
                              stderr=subprocess.PIPE, text=True, check=False)
        if not path.exists():
            raise RuntimeError(f"campaign, seed {seed}: {done.stderr}")
        return campaign_line(json.loads(path.read_text(encoding="utf-8").splitlines()[-1]))


def input_hash(recording):
    """Of truth and ranges: tells whether two binaries mapped the same recording."""
    digest = hashlib.sha256()
    for path in [*sorted((recording / "truth").glob("*.tum")), recording / "ranges.csv"]:
        if path.exists():
            digest.update(path.read_bytes())
    return digest.hexdigest()[:12]


def mission_figures(recording):
    rounds = truth.csv_rows(recording / "rounds.csv")
    frontiers = truth.csv_rows(recording / "frontiers.csv")
    left = [f for f in frontiers if f["round"] == str(len(rounds)) and f["state"] == "open"]
    traffic = sum(int(r["bytes"]) for r in truth.csv_rows(recording / "traffic.csv"))
    return {"rounds": len(rounds), "explored": 0 if left else 1, "traffic_bytes": traffic}


def mean_of(values):
    known = [v for v in values if v is not None]
    return sum(known) / len(known) if known else None


def track_figures(result, kind, name):
    """APE of the fleet under one alignment, NEES per degree of freedom over the vehicles."""
    out = {}
    track = result["fleet"].get(kind)
    if track and track["ape_m"]:
        out[f"ape_{name}_m"], out[f"ape_{name}_max_m"] = track["ape_m"]["rmse"], track["ape_m"]["max"]
    for which in ("position", "pose"):
        out[f"nees_{name}_{which}"] = mean_of(
            nees.per_dof(v.get(kind), which) for v in result["vehicles"].values())
    return out


def figures_of(out, true):
    """The figures of an output folder that `rali evaluate` has judged."""
    result = truth.read_json(out / "evaluation.json")
    metrics = truth.read_json(out / "metrics.json")
    names = list(metrics["vehicles"])
    line = {"findings": truth.findings(metrics)}
    for kind, name in (("live", "live"), ("trajectory", "final")):
        line.update(track_figures(result, kind, name))
        along = cases.along_errors(out, true, kind)
        line[f"along_{name}_m"] = max(along.values()) if along else None
    cloud = (result.get("cloud") or {}).get("to_mesh")
    if cloud:
        line.update(to_mesh_m=cloud["mean_m"], complete=cloud["completeness"])
    groups = (metrics.get("fleet") or {}).get("groups") or [names[:1]]
    line["frames"] = max(len(group) for group in groups)
    line["frames_wrong"] = sum(truth.wrong_frames(out, true, group) for group in groups)
    line["loops"], line["loops_wrong"] = truth.wrong_loops(out, true, names)
    if len(names) > 1:
        line.update(range_figures(out, true, names, metrics))
    return line


def range_figures(out, true, names, metrics):
    return {"ranges": metrics["ranges"]["total"], "ranges_used": metrics["ranges"]["used"],
            "nis": truth.nis(out), "ranges_applied": truth.applied_ranges(out, true, names)}


def campaign_line(record):
    """A record of bench/campaign as a row."""
    score = record["score"]
    line = {"exit": WITH_GAPS if score["gaps"] or score["lost"] else DONE,
            "silent": len(score["silent"]), "ranges": score["ranges"],
            "ranges_used": score["ranges_used"], "findings": " ".join(sorted(score["said"])),
            "cpu_s": record["cpu_mapped_s"]}
    if score["error"]:
        line.update(exit=5, findings=score["error"].replace(",", ";"))
        return line
    if score["solvable_joint"]:
        line["vehicles"] = record["vehicles"]
        line["frames"] = record["vehicles"] - score["groups"] + 1
    for kind in ("live", "final"):
        tracks = [v[kind] for v in score["vehicles"] if v[kind]]
        if tracks:
            line[f"ape_{kind}_m"] = max(t["rmse_m"] for t in tracks)
            line[f"ape_{kind}_max_m"] = max(t["max_m"] for t in tracks)
            line[f"nees_{kind}_position"] = mean_of(t["nees"] for t in tracks)
    return line
