#!/usr/bin/env python3
"""Live missions over an emulated radio: each vehicle is a `rali run` in a network of its own.

The world (`rali simulate --live`) reaches the vehicles over a clean network, the vehicles reach
each other over the radio of radio_link alone. One JSON line per mission. Needs root, /dev/net/tun
and iproute2. Usage:
    missions.py --rali build/bench/bin/rali --radio build/bench/bin/radio_link \\
        --folder /tmp/missions --cases lossless,bad_radio --seeds 1-3
    missions.py --list
"""

import argparse
import json
import os
import pathlib
import shutil
import signal
import subprocess
import sys
import time
from decimal import Decimal

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "cases"))

from cases import seeds_of  # noqa: E402

BAD_RADIO = (0.2, 0.05, 625_000)  # loss, delay [s], bytes per second: 5 Mbit/s
CLEAN = (0.0, 0.0, 0)
ROS = "10.78.0."  # the clean network of sensors and goals; the world is .254
VIEW_PORT = 8765
POLL_S = 1.0
MEMORY_EVERY_S = 300.0
SETTLE_S = 10.0  # after the mission's end the last facts reach every disk
SMALL_DISK_MB = 2
CLOCK_AHEAD_S = 1  # by the fault clock_jump

# Events: seconds after all vehicles answer, verb, vehicles. "anchor" and "tag" are chosen then.
CASES = {
    "lossless": ("a radio without loss", CLEAN, []),
    "bad_radio": ("20 % loss both ways, 50 ms, 5 Mbit/s", BAD_RADIO, []),
    "anchor_killed": ("kill -9 of the anchor, started again after 60 s", CLEAN,
                      [(60, "kill", "anchor"), (120, "start", "killed")]),
    "tag_killed": ("kill -9 of a tag, started again after 5 s", CLEAN,
                   [(60, "kill", "tag"), (65, "start", "killed")]),
    "split": ("one tag without any link for 20 s", CLEAN,
              [(60, "cut", "tag"), (80, "join", "cut")]),
    "anchor_split": ("the anchor without any link for 20 s", CLEAN,
                     [(60, "cut", "anchor"), (80, "join", "cut")]),
    "one_way": ("nothing from the anchor arrives for 20 s, all messages to it do", CLEAN,
                [(60, "mute", "anchor"), (80, "join", "cut")]),
    "disk_full": (f"a disk of {SMALL_DISK_MB} MB for the state of v2", CLEAN, []),
    "clock": ("the clock of v2 a second ahead", CLEAN, []),
}


class Radio:
    """radio_link: the network namespaces and the links between them."""

    def __init__(self, program, vehicles):
        self.process = subprocess.Popen([program, "--vehicles", str(vehicles + 1)], text=True,
                                        stdin=subprocess.PIPE, stdout=subprocess.PIPE)
        self.spaces = [self.process.stdout.readline().strip() for _ in range(vehicles + 1)]
        if not self.spaces[-1]:
            sys.exit("missions.py: no network namespaces (see the line above)")
        self.vehicles = vehicles
        self._connect_world()

    def _connect_world(self):
        """A bridge in the world's namespace with a cable to each vehicle."""
        world = self.spaces[-1]
        inside = ["nsenter", f"--net={world}"]
        call(inside + ["ip", "link", "add", "ros", "type", "bridge", "mcast_snooping", "0"])
        call(inside + ["ip", "addr", "add", ROS + "254/24", "dev", "ros"])
        call(inside + ["ip", "link", "set", "ros", "up"])
        for v in range(self.vehicles):
            call(inside + ["ip", "link", "add", f"p{v}", "type", "veth", "peer", "name", "ros",
                           "netns", self.spaces[v]])
            call(inside + ["ip", "link", "set", f"p{v}", "master", "ros", "up"])
            there = ["nsenter", f"--net={self.spaces[v]}"]
            call(there + ["ip", "addr", "add", f"{ROS}{v + 1}/24", "dev", "ros"])
            call(there + ["ip", "link", "set", "ros", "up"])

    def say(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def set_all(self, link):
        self.say("all {} {} {}".format(*link))

    def link(self, verb, vehicle, both=True):
        """Cuts or joins a vehicle from all others; both: also what is sent to it."""
        for other in range(self.vehicles):
            if other != vehicle:
                self.say(f"{verb} {vehicle} {other}")
                if both:
                    self.say(f"{verb} {other} {vehicle}")

    def kilobytes(self):
        """Sent between the vehicles."""
        self.say("traffic")
        total = 0
        for line in iter(lambda: self.process.stdout.readline().strip(), "."):
            total += int(line.split()[4])
        return total / 1000

    def close(self):
        self.process.stdin.close()
        self.process.wait()


class Process:
    """A program in the network of a vehicle, with its use of processor and memory.

    Not started by bench/regression/measured.py: kill -9 would end that, not the vehicle.
    """

    def __init__(self, space, command, log):
        with open(log, "a", encoding="utf-8") as out:
            self.process = subprocess.Popen(["nsenter", f"--net={space}"] + command, stdout=out,
                                            stderr=out, stdin=subprocess.DEVNULL)
        self.code, self.used, self.begun_s = None, None, time.monotonic()

    def ended(self):
        if self.code is None:
            pid, status, used = os.wait4(self.process.pid, os.WNOHANG)
            if pid:
                self._take(status, used)
        return self.code is not None

    def memory_mb(self):
        """Resident now [MB]; nsenter has become the program, so the process is the vehicle's."""
        status = pathlib.Path(f"/proc/{self.process.pid}/status").read_text()
        kilobytes = [line.split()[1] for line in status.splitlines() if line.startswith("VmRSS")]
        return round(int(kilobytes[0]) / 1024) if kilobytes else 0

    def stop(self, number=signal.SIGINT, limit_s=60):
        if self.ended():
            return
        os.kill(self.process.pid, number)
        for _ in range(10 * limit_s):
            if self.ended():
                return
            time.sleep(0.1)
        os.kill(self.process.pid, signal.SIGKILL)
        self._take(*os.wait4(self.process.pid, 0)[1:])

    def _take(self, status, used):
        self.code = self.process.returncode = os.waitstatus_to_exitcode(status)
        self.used = {"code": self.code, "memory_mb": round(used.ru_maxrss / 1024),
                     "cores": round((used.ru_utime + used.ru_stime) /
                                    max(1e-3, time.monotonic() - self.begun_s), 3)}


class Watch:
    """What the vehicles say of themselves, once a second."""

    def __init__(self, rali, spaces):
        self.rali, self.spaces = rali, spaces
        self.newest, self.anchors, self.errors = {}, {}, {}
        self.longest_step_s, self.latency = {}, {}
        self.memory_mb, self.drops = {}, {}

    def poll(self):
        asked = {v: subprocess.Popen(["nsenter", f"--net={space}", self.rali, "status", "--json"],
                                     stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, text=True)
                 for v, space in enumerate(self.spaces)}
        self.newest = {}
        for v, process in asked.items():
            try:
                self.newest[v] = json.loads(process.communicate()[0])
            except json.JSONDecodeError:
                continue
            self._note(self.newest[v])

    def _note(self, state):
        name = state["vehicle"]
        if self.role(state) == "anchor":
            self.anchors.setdefault(state.get("term", 0), set()).add(name)
        step = state.get("steps", {}).get("max_s", 0.0)
        self.longest_step_s[name] = max(step, self.longest_step_s.get(name, 0.0))
        if "odometry" in state:
            self.latency[name] = [1e3 * state["odometry"].get(k, 0.0)
                                  for k in ("latency_p50_s", "latency_p99_s")]
        self.drops[name] = {s["name"]: [s.get("drops", 0), s.get("gaps", 0)]
                            for s in state.get("sensors", [])}
        for line in state.get("diagnostics", []):
            if line["level"] == "error":
                self.errors.setdefault(f"{name} {line['name']}", line["message"])

    def note_memory(self, vehicles):
        """What each process holds now; called once in MEMORY_EVERY_S."""
        for v, process in vehicles.items():
            if not process.ended():
                self.memory_mb.setdefault(f"v{v + 1}", []).append(process.memory_mb())

    @staticmethod
    def role(state):
        own = [v for v in state.get("vehicles", []) if v["name"] == state["vehicle"]]
        return own[0].get("role") if own else None

    def all_answer(self):
        return len(self.newest) == len(self.spaces) and all(
            "mission" in s and self.role(s) for s in self.newest.values())

    def choose(self, word):
        """Number of the anchor, or of a tag."""
        for v, state in sorted(self.newest.items()):
            if (self.role(state) == "anchor") == (word == "anchor"):
                return v
        return 0

    def finished(self):
        return any(s.get("mission", {}).get("finished") for s in self.newest.values())


class Mission:
    def __init__(self, args, case, seed):
        self.args, self.case, self.seed = args, case, seed
        _, self.link, self.events = CASES[case]
        self.folder = pathlib.Path(args.folder) / f"{case}_{seed}"
        shutil.rmtree(self.folder, ignore_errors=True)
        (self.folder / "state").mkdir(parents=True)
        self.radio = Radio(args.radio, args.vehicles)
        self.watch = Watch(args.rali, self.radio.spaces[:-1])
        self.vehicles, self.chosen, self.notes = {}, {}, []

    def run(self):
        world = self._start_world()
        try:
            for v in range(self.args.vehicles):
                self._start(v)
            self.radio.set_all(self.link)
            ended = self._drive(world)
            traffic = self.radio.kilobytes()
        finally:
            world.stop()
            for process in self.vehicles.values():
                process.stop()
            self.radio.close()
        return ended, traffic

    def _start_world(self):
        command = [self.args.rali, "simulate", self.args.scene, "--live", "-o",
                   self.folder / "recording", "--seed", str(self.seed), "--vehicles",
                   str(self.args.vehicles), "--duration", str(self.args.duration), "--interface",
                   ROS + "254"]
        if self.case == "clock":
            command += ["--fault", "clock_jump:v2@0-36000"]
        world = Process(self.radio.spaces[-1], [str(c) for c in command], self.folder / "world.log")
        fleet = self.folder / "recording" / "live.yaml"
        while not fleet.exists():
            if world.ended():
                sys.exit((self.folder / "world.log").read_text())
            time.sleep(0.1)
        text = fleet.read_text().replace("127.0.0.", "10.77.0.")
        fleet.write_text(text.replace("live: {ros", "live: {ros_interface: ros, ros"))
        return world

    def _start(self, v):
        name = f"v{v + 1}"
        state = self.folder / "state" / name
        state.mkdir(exist_ok=True)
        if self.case == "disk_full" and name == "v2" and not os.path.ismount(state):
            call(["mount", "-t", "tmpfs", "-o", f"size={SMALL_DISK_MB}m", "tmpfs", str(state)])
        command = [self.args.rali, "run", str(self.folder / "recording" / "live.yaml"), "--vehicle",
                   name, "--state", str(state), "--poses", str(self.folder / "mission"), "--view",
                   str(VIEW_PORT)]
        if self.args.record:
            command += ["--record", str(self.folder / "received")]
        self.vehicles[v] = Process(self.radio.spaces[v], command, self.folder / f"{name}.log")

    def _drive(self, world):
        """Until the mission ends. @return its duration [s]; negative: it did not end by itself"""
        begun, events, noted_s = None, list(self.events), -MEMORY_EVERY_S
        while not world.ended():
            time.sleep(POLL_S)
            self.watch.poll()
            if begun is None and self.watch.all_answer():
                begun = time.monotonic()
            for v, process in self.vehicles.items():
                if process.ended() and v != self.chosen.get("killed"):
                    self.notes.append(f"v{v + 1} ended with {process.code}")
                    return -1.0
            if begun is None:
                continue
            now_s = time.monotonic() - begun
            if now_s >= noted_s + MEMORY_EVERY_S:
                noted_s = now_s
                self.watch.note_memory(self.vehicles)
            while events and events[0][0] <= now_s:
                self._do(*events.pop(0)[1:])
            if self.watch.finished() and not events:
                time.sleep(SETTLE_S)
                return now_s
        return -(time.monotonic() - begun) if begun else -1.0

    def _do(self, verb, whom):
        v = self.chosen[whom] if whom in self.chosen else self.watch.choose(whom)
        self.notes.append(f"{verb} v{v + 1}")
        if verb == "kill":
            self.vehicles[v].stop(signal.SIGKILL)
            self.chosen["killed"] = v
        elif verb == "start":
            self.chosen.pop("killed")
            self._start(v)
        else:
            self.radio.link("join" if verb == "join" else "cut", v, both=verb != "mute")
            self.chosen["cut"] = v


def call(command):
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{' '.join(map(str, command))}: {done.stderr.strip()}")


def to_own_clock(tum, ahead_s):
    """Gives the true poses the stamps of a vehicle whose clock is ahead, as its results have them."""
    lines = [line for line in tum.read_text().splitlines() if not line.startswith("#")]
    poses = [line.split(" ", 1) for line in lines]
    tum.write_text("".join(f"{Decimal(t) + ahead_s} {pose}\n" for t, pose in poses))


def evaluated(args, results, truth):
    """APE rms and largest of the fleet, map to surface, by `rali evaluate`."""
    done = subprocess.run([args.rali, "evaluate", str(results), "--truth", str(truth), "-q"],
                          capture_output=True, text=True, check=False)
    try:
        got = json.loads((results / "evaluation.json").read_text())
    except FileNotFoundError:
        return {"error": done.stderr.strip().split("\n")[-1]}
    out = {}
    for kind, part in (got.get("fleet") or {}).items():
        if isinstance(part, dict) and "ape_m" in part:
            out[kind] = [round(part["ape_m"][k], 4) for k in ("rmse", "max")]
    to_mesh = ((got.get("cloud") or {}).get("to_mesh") or {})
    if to_mesh:
        out["to_mesh_m"] = round(to_mesh["mean_m"], 4)
        out["complete"] = round(to_mesh["completeness"], 3)
    return out


def mapped(args, mission, name, inputs):
    """`rali map` of what the mission left; what it says and how wrong it is."""
    results = mission.folder / "maps" / name
    done = subprocess.run([args.rali, "map"] + [str(i) for i in inputs] +
                          ["-o", str(results), "--overwrite", "-q"], capture_output=True, text=True,
                          check=False)
    out = {"exit": done.returncode}
    if done.returncode not in (0, 3):
        return out | {"error": done.stderr.strip().split("\n")[-1]}
    return out | evaluated(args, results, mission.folder / "recording" / "truth")


def row(args, case, seed):
    mission = Mission(args, case, seed)
    ended_s, traffic_kb = mission.run()
    fleet = mission.folder / "recording"
    if case == "clock":
        to_own_clock(fleet / "truth" / "v2.tum", CLOCK_AHEAD_S)
    states = [mission.folder / "state" / f"v{v + 1}" for v in range(args.vehicles)]
    out = {"case": case, "seed": seed, "ended_s": round(ended_s), "events": mission.notes,
           "terms": len(mission.watch.anchors),
           "two_anchors": [t for t, who in mission.watch.anchors.items() if len(who) > 1],
           "traffic_kb": round(traffic_kb), "errors": mission.watch.errors,
           "longest_step_s": mission.watch.longest_step_s, "latency_ms": mission.watch.latency,
           "memory_mb": mission.watch.memory_mb, "drops_gaps": mission.watch.drops,
           "used": {f"v{v + 1}": p.used for v, p in mission.vehicles.items()},
           "live": evaluated(args, mission.folder / "mission", fleet / "truth"),
           "recording": mapped(args, mission, "recording", [fleet / "fleet.yaml"])}
    for name, folders in [("all", states)] + [(s.name, [s]) for s in states]:
        out[f"state_{name}"] = mapped(args, mission, f"state_{name}", [fleet / "live.yaml"] + folders)
    for state in states:
        if os.path.ismount(state):
            call(["umount", str(state)])
    if args.forget:
        for recorded in mission.folder.glob("*/*.mcap"):
            recorded.unlink()
    return out


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--rali", default="build/bench/bin/rali")
    parser.add_argument("--radio", default="build/bench/bin/radio_link")
    parser.add_argument("--folder", default="/tmp/missions")
    parser.add_argument("--scene", default="floor")
    parser.add_argument("--vehicles", type=int, default=3)
    parser.add_argument("--duration", type=int, default=900, help="limit [s]")
    parser.add_argument("--cases", default="lossless")
    parser.add_argument("--seeds", default="1")
    parser.add_argument("--record", action="store_true", help="keep what each vehicle receives")
    parser.add_argument("--forget", action="store_true", help="remove the recorded sensors after each row")
    parser.add_argument("--list", action="store_true")
    args = parser.parse_args()
    if args.list:
        for name, (what, _, _) in CASES.items():
            print(f"{name:15} {what}")
        return
    unknown = set(args.cases.split(",")) - CASES.keys()
    if unknown:
        parser.error(f"there is no {', '.join(sorted(unknown))}")
    args.rali, args.radio = os.path.abspath(args.rali), os.path.abspath(args.radio)
    for case in args.cases.split(","):
        for seed in seeds_of(args.seeds):
            print(json.dumps(row(args, case, seed)), flush=True)


if __name__ == "__main__":
    main()
