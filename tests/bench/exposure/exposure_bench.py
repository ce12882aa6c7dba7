# programs: kawara-sim kawara-log
"""./run bench exposure: does every picture carry the pose of its own exposure? Missions in virtual time with a picture at each
epoch of 10 Hz, one trigger in a hundred lost and one in a hundred doubled, by cameras that do not name the trigger a frame
is of; without and with the receiver's pulses, without and with the shutter wired to its event input.

The judge does not ask the robot which picture is which: a PHASE1 picture (passed through) is recognised by its compressed
bytes among the FRAMEs, whose number the truth has with the instant of the exposure. Prints a Markdown table; figures also as
JSON. With --into README.md the table takes the place of the one between the marks there."""
import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from lcm_log import records

BIN = pathlib.Path(os.environ.get("KAWARA_BIN", "build/release/bin"))
SOURCE = pathlib.Path(__file__).resolve().parents[3]
WRONG_S = 0.005  # a picture whose time is farther off is another one's
EXPOSURE_S = 0.004
SETTLE_S = 15.0  # the filter aligns, the pulses lock
EARTH_M = 6371008.8
NO_PPS = ("--onboard-set", "gps.pps.device=")
MARKED = ("--camera-strobe", "--onboard-set", "camera.event_mark=exposure")
# A camera whose stamps are those of the frame's arrival, as many drivers give them.
BLUNT = ("--camera-stamp-late", "0.025", "--camera-stamp-jitter", "0.003")
CASES = (
    ("no pulses", "stamps true", NO_PPS, 1e-3),
    ("pulses", "stamps true", (), 50e-6),
    ("pulses", "stamps 25 ms late, 3 ms scatter", BLUNT, None),
    ("no pulses, event mark", "stamps 25 ms late, 3 ms scatter", NO_PPS + BLUNT + MARKED, 1e-3),
    ("pulses, event mark", "stamps 25 ms late, 3 ms scatter", BLUNT + MARKED, 50e-6),
)


def run(program, *arguments):
    done = subprocess.run([BIN / program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program}: {done.stderr.strip()}")
    return done.stdout


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


def entropy(message):
    """The compressed part of the JPEG in a message: no metadata changes it."""
    begin, end = message.find(b"\xff\xda"), message.rfind(b"\xff\xd9")
    return message[begin:end]


def mission(folder, seed, options, seconds):
    log, truth = folder / "mission.lcm", folder / "truth"
    # A site of which little is drawn: small pictures suffice to tell one from another.
    run("kawara-sim", "site", "--site", SOURCE / "configs/sites/factory_road.yaml", "--robot",
        SOURCE / "configs/vehicles/survey_robot.yaml", "--run-dir", truth, "--virtual", log, "--onboard-config",
        SOURCE / "configs/survey_robot.yaml", "--duration", seconds, "--seed", seed, "--doughnut-px", 256, "--samples", 1,
        "--light-cell", 5, "--exposure", EXPOSURE_S, "--camera-nameless", "--fault", "t=0 camera.miss=0.01 100000s",
        "--fault", "t=0 camera.double=0.01 100000s", "--onboard-set", "picture.camera=equirectangular", "--onboard-set",
        "schedule.every_epochs=1", "--onboard-set", f"camera.exposure_s={EXPOSURE_S}", *options)
    return log, truth


def table_of(log, channel):
    out = log.with_suffix(f".{channel}.csv")
    run("kawara-log", "export", log, "--channel", channel, "--out", out)
    return rows(out)


def place(row, prefix="pose."):
    return np.array([float(row[prefix + k]) for k in ("lat_deg", "lon_deg")] + [float(row[prefix + "h_ellipsoidal_m"])])


class Track:
    """The true path of the body, to look up at any instant."""

    def __init__(self, path):
        table = rows(path)
        self.t = np.array([int(r["gps_ns"]) for r in table])
        self.p = np.array([[float(r["lat_deg"]), float(r["lon_deg"]), float(r["h_ellipsoidal_m"])] for r in table])

    def miss_m(self, gps_ns, where):
        true = [np.interp(gps_ns - self.t[0], self.t - self.t[0], self.p[:, k]) for k in range(3)]
        d = np.radians(where[:2] - true[:2]) * EARTH_M
        d[1] *= np.cos(np.radians(true[0]))
        return float(np.hypot(np.hypot(*d), where[2] - true[2]))


def judge(log, truth):
    """Of one mission: pictures sent, those with a wrong exposure's pose, errors [s], misses of pictures and of the filter [m]."""
    frames, packets = [], []
    for _, _, channel, data in records(log.read_bytes()):
        if channel == "FRAME":
            frames.append(entropy(data))
        elif channel == "PHASE1":
            packets.append(entropy(data))
    number = {picture: int(row["sequence"]) for picture, row in zip(frames, table_of(log, "FRAME"), strict=True)}
    exposed = {int(r["frame_sequence"]): int(r["gps_ns"]) for r in rows(truth / "truth_exposures.csv")}
    first = min(exposed.values())
    track = Track(truth / "truth_trajectory.csv")
    body = {r["pose.gps_ns"]: r for r in table_of(log, "POSE.EPOCH")}
    sent, wrong, errors, misses = 0, 0, [], []
    for packet, row in zip(packets, table_of(log, "PHASE1"), strict=True):
        if packet not in number:
            continue  # a preview
        middle = exposed[number[packet]] + round(EXPOSURE_S / 2 * 1e9)
        error = (int(row["pose.gps_ns"]) - middle) / 1e9
        if middle - first < SETTLE_S * 1e9:
            continue
        sent += 1
        wrong += abs(error) > WRONG_S
        errors.append(error)
        pose = body[row["pose.gps_ns"]]
        misses.append(track.miss_m(middle, place(pose)))
    filter_misses = [track.miss_m(int(r["pose.gps_ns"]), place(r)) for r in table_of(log, "POSE")
                     if int(r["pose.gps_ns"]) - first > SETTLE_S * 1e9]
    return sent, wrong, errors, misses, filter_misses


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--json")
    parser.add_argument("--into")
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--seconds", type=float, default=115.0)
    options = parser.parse_args()
    lines, figures = [], {}
    for clock, stamps, arguments, must_s in CASES:
        sent, wrong, errors, misses, filter_misses = 0, 0, [], [], []
        for seed in range(1, options.seeds + 1):
            with tempfile.TemporaryDirectory(prefix="kawara-exposure-") as folder:
                found = judge(*mission(pathlib.Path(folder), seed, arguments, options.seconds))
            sent, wrong = sent + found[0], wrong + found[1]
            errors += found[2]
            misses += found[3]
            filter_misses += found[4]
        late = np.abs(errors)
        rms = lambda values: float(np.sqrt(np.mean(np.square(values))))
        ratio = rms(misses) / rms(filter_misses)
        figures[f"{clock}; {stamps}"] = {
            "pictures": sent, "wrong": wrong, "median_s": float(np.median(late)), "p99_s": float(np.quantile(late, 0.99)),
            "worst_s": float(late.max()), "bias_s": float(np.mean(errors)), "pose_rms_m": rms(misses),
            "filter_rms_m": rms(filter_misses)}
        missed = must_s is not None and (np.quantile(late, 0.99) > must_s or wrong > 0.001 * sent)
        unit = lambda s: f"{s * 1e6:.0f} us" if s < 1e-3 else f"{s * 1e3:.1f} ms"
        lines.append((clock, stamps, f"{100 * (sent - wrong) / sent:.2f} % of {sent}",
                      f"{unit(np.median(late))} / {unit(np.quantile(late, 0.99))} / {unit(late.max())}" + (" (!)" if missed else ""),
                      unit(must_s) if must_s else "-", f"{1e3 * rms(misses):.1f} / {1e3 * rms(filter_misses):.1f} mm = {ratio:.2f}"))
        print("  " + " | ".join(lines[-1]), file=sys.stderr, flush=True)
    head = ("clock", "camera", "pictures with their own exposure's pose", "time error median / p99 / worst", "must",
            "position of pictures / of the filter, rms")
    table = "\n".join("| " + " | ".join(row) + " |" for row in (head, tuple("---" for _ in head), *lines))
    print(table)
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(figures, indent=1))
    if options.into:
        readme = pathlib.Path(options.into)
        text = readme.read_text()
        begin, end = "<!-- exposure -->\n", "<!-- /exposure -->"
        head_text, rest = text.split(begin)
        readme.write_text(head_text + begin + table + "\n" + end + rest.split(end, 1)[1])


main()
