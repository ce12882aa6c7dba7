"""./run demo: a drive arrives as pictures and track in a GIS, live; then the same from the log alone.

kawara-sim plays a simulated drive, or a recorded one (real RTK-GNSS and IMU measurements), on pseudo-terminals at true pace, kawara-onboard reads them
as it would read the instruments, kawara-station stores what comes over LCM, on request across a bad radio. Runs inside a network namespace (see ./run).
"""
import argparse
import bisect
import csv
import json
import pathlib
import shlex
import shutil
import subprocess
import sys
import threading
import time

ROOT = pathlib.Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT / "tests" / "support"))
from processes import Processes, run, wait_for  # noqa: E402

FACTORY_ROAD = ROOT / "configs/sites/factory_road.yaml"
DRIVE_S = 540  # the recording's length, less its first seconds without IMU


def percentile(values, share):
    """Nearest-rank percentile."""
    ordered = sorted(values)
    return ordered[min(len(ordered) - 1, int(share * len(ordered)))] if ordered else float("nan")


def read_csv(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def nearest(rows, gps_ns, tolerance_ns=100_000_000):
    """The row whose gps_ns is nearest (rows ascending), or None."""
    keys = nearest.keys.setdefault(id(rows), [int(r["gps_ns"]) for r in rows])
    i = bisect.bisect_left(keys, gps_ns)
    best = min((j for j in (i - 1, i) if 0 <= j < len(keys)), key=lambda j: abs(keys[j] - gps_ns), default=None)
    return rows[best] if best is not None and abs(keys[best] - gps_ns) <= tolerance_ns else None


nearest.keys = {}


class Recorded:
    """A drive that was: real measurements of a car, and one real panorama round it."""
    name = "a real drive"
    config = ROOT / "configs/demo.yaml"
    simulator = ["drive", "--data", ROOT / "data/drive_0708", "--panorama", ROOT / "data/panorama/R0014760_3072.jpg"]
    usual_start_s, usual_seconds = 100, 60
    longest_wait_s = 60

    def wiring(self, ports):
        return []  # as on many receivers, nobody has soldered the PPS wire


class Site:
    """A drive that never was: exposures are drawn before it begins where this machine is too slow to draw them live."""
    name = "a simulated drive"
    config = ROOT / "configs/survey_robot.yaml"
    usual_start_s, usual_seconds = 0, 120
    longest_wait_s = 3600

    def __init__(self, site):
        self.simulator = ["site", "--site", site, "--ahead", 1, "--samples", 1]

    def wiring(self, ports):
        return ["--set", f"gps.pps.device={ports}/pps.sock"]


ROBOT_BUS = "udpm://239.255.76.67:7667?ttl=0"
BASE_BUS = "udpm://239.255.76.67:7668?ttl=0"  # beyond the radio, if there is one


def live(out, drive, seconds, start, faults, radio, quiet):
    """Runs the chain; returns the mission's log folder."""
    ports = out / "ports"
    with Processes(out / "output") as chain:
        if radio is not None:
            chain.start("radio", "kawara-sim", "radio", "--robot", ROBOT_BUS, "--base", BASE_BUS, *shlex.split(radio))
        sim_args = [*drive.simulator, "--run-dir", ports, "--start", start, "--duration", seconds]
        for fault in faults:
            sim_args += ["--fault", fault]
        chain.start("station", "kawara-station", "--config", ROOT / "configs/station.yaml", "--store", out / "live/mission.gpkg",
                    "--latency", out / "latency.csv", "--map", out / "track.png",
                    "--lcm-url", BASE_BUS if radio is not None else ROBOT_BUS)
        chain.start("sim", "kawara-sim", *sim_args)
        wait_for_ports(chain, ports, drive.longest_wait_s, quiet)
        chain.start("onboard", "kawara-onboard", "--config", drive.config, "--set", f"gps.device={ports}/gps",
                    "--set", f"ahrs.device={ports}/ahrs", "--set", f"camera.path={ports}/camera.sock",
                    *drive.wiring(ports), "--set", f"record.folder={out}/log", "--set", f"lcm_url={ROBOT_BUS}")
        end = time.monotonic() + seconds + 60
        while chain.running["sim"].poll() is None and time.monotonic() < end:
            time.sleep(1)
            if not quiet and sys.stdout.isatty():
                pictures = len(list((out / "live/pictures").rglob("*.jpg")))
                print(f"\r  live: {pictures} pictures in the store", end="", flush=True)
        if not quiet and sys.stdout.isatty():
            print()
        time.sleep(1.5)  # the last epoch's sentences, poses and pictures
        codes = {name: chain.stop(name) for name in ("onboard", "radio", "station", "sim") if name in chain.running}
        for name in codes:
            text = chain.output(name).strip().splitlines()
            for line in text[-1:] if codes[name] == 0 else text[-5:]:
                print(f"  {line}")
        if any(codes.values()):
            sys.exit(f"demo: a program failed: {codes}; see {out}/output")
    missions = sorted((out / "log").iterdir())
    return missions[-1]


def wait_for_ports(chain, ports, longest_s, quiet):
    said = ""

    def ready():
        nonlocal said
        lines = chain.output("sim").splitlines()
        if lines and lines[-1] != said and not quiet:
            said = lines[-1]
            print(f"  {said}", flush=True)
        return (ports / "ready").exists() or chain.running["sim"].poll() is not None

    wait_for(ready, longest_s, "the simulator's ports")


def judge(out):
    """Trajectory in the store against the simulator's truth; prints the table."""
    truth = out / "ports/truth_trajectory.csv"
    if not truth.exists():
        return
    done = run("kawara-evaluate", "poses", "--truth", truth, "--result", out / "live/mission.gpkg",
               "--json", out / "pose_errors.json")
    print("\nposes in the store against the truth (kawara-evaluate poses)")
    print(done.stdout if done.returncode == 0 else done.stderr)


def replay(out, log):
    """The same from the log alone; returns how many times faster than the drive it was."""
    begin = time.monotonic()
    for args in (("kawara-onboard", "--log", log, "--out", out / "replay.lcm"),
                 ("kawara-station", "--config", ROOT / "configs/station.yaml", "--log", out / "replay.lcm",
                  "--store", out / "replay/mission.gpkg")):
        done = run(*args, timeout=1200)
        print("  " + (done.stdout or done.stderr).strip().splitlines()[-1])
        if done.returncode != 0:
            sys.exit(f"demo: {args[0]} failed: {done.stderr.strip()}")
    return time.monotonic() - begin


def dump(store):
    done = run("kawara-station", "--dump", store, timeout=300)
    if done.returncode != 0:
        sys.exit(f"demo: dump of {store} failed: {done.stderr.strip()}")
    return done.stdout


def counters(log):
    """The last values of the onboard counters."""
    done = run("kawara-log", "export", log, "--channel", "COUNTERS", "--out", log.parent / "counters.csv")
    if done.returncode != 0:
        return {}
    rows = read_csv(log.parent / "counters.csv")
    last = rows[-1] if rows else {}
    names = [last[k] for k in last if k.startswith("name")]
    values = [last[k] for k in last if k.startswith("value")]
    return {n: int(v) for n, v in zip(names, values) if n}


class StolenTime(threading.Thread):
    """Watches how much of this machine's processors its host gives to others (virtual machines): no program can
    answer while it is not being run, so a latency is only this software's own where nothing was stolen meanwhile."""

    def __init__(self):
        super().__init__(daemon=True)
        self.instants, self.stolen, self.done = [], [], threading.Event()

    def run(self):
        while not self.done.wait(0.02):
            fields = pathlib.Path("/proc/stat").read_text().split("\n", 1)[0].split()
            self.instants.append(time.monotonic_ns())
            self.stolen.append(int(fields[8]) if len(fields) > 8 else 0)

    def between(self, begin_ns, end_ns):
        """In clock ticks, widened to the samples around."""
        first = max(bisect.bisect_left(self.instants, begin_ns) - 1, 0)
        last = min(bisect.bisect_right(self.instants, end_ns), len(self.instants) - 1)
        return self.stolen[last] - self.stolen[first] if self.instants else 0


def latencies(out, stolen):
    """Per stage: from the true instant of the epoch to the picture durable in the store [ms], all of them and
    ("... undisturbed") those during which the host stole nothing; and clock errors [ms]."""
    exposures = read_csv(out / "ports/truth_exposures.csv")
    result, clock_errors = {"preview": [], "full": [], "full undisturbed": []}, []
    for row in read_csv(out / "latency.csv"):
        truth = nearest(exposures, int(row["gps_ns"]))
        if truth is None:
            continue
        latency_ms = (int(row["mono_ns"]) - int(truth["mono_ns"])) / 1e6
        result[row["stage"]].append(latency_ms)
        if row["stage"] == "full":
            if stolen.between(int(truth["mono_ns"]), int(row["mono_ns"])) == 0:
                result["full undisturbed"].append(latency_ms)
            clock_errors.append((int(row["gps_ns"]) - int(truth["gps_ns"])) / 1e6)
    return result, clock_errors, len(exposures)


def main():
    parser = argparse.ArgumentParser(prog="./run demo")
    parser.add_argument("--site", nargs="?", const=FACTORY_ROAD, default=FACTORY_ROAD, help="the simulated place (configs/sites/; the factory road)")
    parser.add_argument("--recorded", action="store_true", help="a recorded drive instead: real measurements of a car")
    parser.add_argument("--full", action="store_true", help="all nine minutes of the recorded drive")
    parser.add_argument("--seconds", type=int, help="of the drive (120; recorded 60)")
    parser.add_argument("--start", type=float, help="seconds into the drive (0; recorded 100)")
    parser.add_argument("--radio", metavar="OPTIONS",
                        help='a bad radio between robot and base, e.g. "--rate 20e6 --queue 2000000 --loss 0.0005" (see kawara-sim radio --help)')
    parser.add_argument("--fault", action="append", default=[], help='e.g. "t=20 gps.unplug 5s" (see kawara-sim drive --help)')
    parser.add_argument("--out", default="out/demo")
    parser.add_argument("--quiet", action="store_true")
    args = parser.parse_args()
    if args.full:
        args.recorded, args.start, args.seconds = True, 5, DRIVE_S
    drive = Recorded() if args.recorded else Site(args.site)
    if args.start is None:
        args.start = drive.usual_start_s
    if args.seconds is None:
        args.seconds = drive.usual_seconds
    out = pathlib.Path(args.out).resolve()
    if out.exists():
        shutil.rmtree(out)
    for folder in ("live", "replay"):
        (out / folder).mkdir(parents=True)

    print(f"live: {args.seconds} s of {drive.name} at true pace, instruments on pseudo-terminals", flush=True)
    stolen = StolenTime()
    stolen.start()
    log = live(out, drive, args.seconds, args.start, args.fault, args.radio, args.quiet)
    stolen.done.set()
    print("again, from the log alone")
    took = replay(out, log)

    stages, clock_errors, exposed = latencies(out, stolen)
    live_dump = dump(out / "live/mission.gpkg")
    replay_dump = dump(out / "replay/mission.gpkg")
    (out / "live.txt").write_text(live_dump)
    (out / "replay.txt").write_text(replay_dump)
    epochs = len(read_csv(out / "ports/truth_epochs.csv"))
    count = counters(log)
    summary = {
        "GNSS epochs of the drive / decoded (the first pass while the receiver is set up)": f"{epochs} / {count.get('gps.fixes', 0)}",
        "AHRS packets decoded": count.get("ahrs.packets", 0),
        "exposures / pictures in the store": f"{exposed} / {len(stages['full'])}",
        "preview in the store, median / p99 after its epoch": "%.0f / %.0f ms" % (
            percentile(stages["preview"], 0.5), percentile(stages["preview"], 0.99)),
        "picture in the store, median / p99 after its epoch": "%.0f / %.0f ms" % (
            percentile(stages["full"], 0.5), percentile(stages["full"], 0.99)),
        f"the same, of the {len(stages['full undisturbed'])} undisturbed by the machine's host": "%.0f / %.0f ms" % (
            percentile(stages["full undisturbed"], 0.5), percentile(stages["full undisturbed"], 0.99)),
        "GPS time of exposures, worst error": "%.1f ms" % max((abs(e) for e in clock_errors), default=float("nan")),
        "triggers without frame / frames left out": f"{count.get('camera.missed', 0)} / {count.get('phase1.skipped_busy', 0)}",
        "records lost / messages not sent": "%d / %d" % (
            count.get("rt.output_refused", 0) + count.get("recorder.refused", 0), count.get("bus.not_sent", 0)),
        "replay": f"{args.seconds / took:.1f} times faster than the drive",
        "store from the log": "identical" if live_dump == replay_dump else
                              "has what the radio lost" if args.radio is not None else "DIFFERENT (live.txt, replay.txt)",
    }
    width = max(map(len, summary))
    print()
    for key, value in summary.items():
        print(f"  {key:<{width}}  {value}")
    (out / "summary.json").write_text(json.dumps(summary, indent=1))
    judge(out)
    print(f"\ndemo: {len(stages['full'])} pictures of {drive.name} in {out}/live/mission.gpkg (open it in QGIS), map {out}/track.png, "
          f"log {log}")
    # What a bad radio swallowed is in the log alone: a picture needs each of its packets.
    ok = len(stages["full"]) > 0 and live_dump == replay_dump if args.radio is None else len(stages["preview"]) > 0
    return 0 if ok else 1


if __name__ == "__main__":
    try:
        sys.exit(main())
    except (subprocess.TimeoutExpired, TimeoutError) as error:
        sys.exit(f"demo: {error}")
