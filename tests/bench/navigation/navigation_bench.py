# programs: kawara-navigate
"""./run bench navigation: what kawara-navigate reaches on the recorded drive and on the synthetic set, beside the goals
and what other programs were measured to reach on the same data. Prints a Markdown table; figures also as JSON. With
--into README.md the table takes the place of the one between the marks there."""
import argparse
import json
import pathlib
import sys
import tempfile

import numpy as np

import navigation_score as score

# Other programs on the same data (their noise settings searched for the best of 4 to 9 combinations; "oracle": wrong
# fixes and float were taken out of their input beforehand). KF-GINS f39bc2e, OB_GINS e96c69a, rtklibexplorer/GNSS_IMU
# 8235ee6.
HEADINGS = 36
ALIGN_SECONDS = 60.0
LATE_CUTS = (300200.0, 300450.0, 300660.0, 300905.0, 301255.0)


class Table:
    """The lines of the result: quantity, measured, must, aim, others."""

    def __init__(self):
        self.lines, self.figures, self.failed = [], {}, 0

    def add(self, key, quantity, values, must, aim, others="", digits=3, unit="m", within=None):
        """`must` and `aim` are upper bounds for each value, None where there is none; with `within` they are text and
        it judges the values."""
        values = [float(v) for v in np.atleast_1d(values)]
        self.figures[key] = values
        good = within(values) if within else must is None or all(v <= m for v, m in zip(values, np.atleast_1d(must)))
        self.failed += not good

        def text(numbers):
            return " / ".join(f"{n:.{digits}f}" for n in numbers)

        def goal(bound):
            return bound if isinstance(bound, str) else "-" if bound is None else text(np.atleast_1d(bound))

        self.lines.append((quantity, f"{text(values)} {unit}".strip() + ("" if good else " (!)"), goal(must), goal(aim),
                           others))
        print(f"  {quantity}: {self.lines[-1][1]} (must {self.lines[-1][2]})", file=sys.stderr, flush=True)

    def markdown(self):
        head = ("quantity", "here", "must", "aim", "others on the same data")
        rows = [head, tuple("---" for _ in head), *self.lines]
        return "\n".join("| " + " | ".join(row) + " |" for row in rows)


def sim(table):
    run = score.navigate(*score.sim_arguments("--use-arrival-times"))
    errors = score.SimErrors(run.trajectory)
    n, e, d = errors.clean_position_rms()
    table.add("sim_position", "clean position RMS, worse of N and E / D", [max(n, e), d], [0.012, 0.018],
              [0.010, 0.016], "KF-GINS oracle 0.010 / 0.016, OB_GINS 0.014 / 0.019", 4)
    roll, pitch, yaw = errors.clean_attitude_rms()
    table.add("sim_attitude", "clean roll, pitch (worse) / yaw RMS", [max(roll, pitch), yaw], [0.11, 0.40],
              [0.08, 0.33], "KF-GINS 0.186 / 1.76 as received, 0.174 / 0.60 oracle; OB_GINS 0.151 / 0.63", 3, "deg")
    table.add("sim_outages", "outages of 10/30/60 s with wheels, worst",
              [errors.worst_outage(s) for s in (10, 30, 60)], [0.20, 0.50, 0.90], [0.12, 0.30, 0.60],
              "OB_GINS with wheels 0.18 / 0.55 / 1.08", 2)
    table.add("sim_wrong_fix", "wrong fix reported as 1 cm: worst during / 3 s after",
              [errors.worst_wrong_fix(), errors.after_wrong_fix()], [0.30, 0.05], [0.20, 0.05],
              "KF-GINS 1.05, OB_GINS with culling 0.89 during", 3)
    table.add("sim_wrong_fix_yaw", "yaw excursion during a wrong fix", errors.wrong_fix_yaw(), 0.5, None, "", 2, "deg")
    n, e, _ = errors.float_rms()
    table.add("sim_float", "float RMS, worse of N and E", max(n, e), 0.12, 0.08, "KF-GINS 0.18, OB_GINS 0.16")
    table.add("sim_nees", "NEES of position(3) / attitude(3)", errors.clean_nees(), "1.5-5", "2.1-4.5",
              "KF-GINS 11.4 / 20.5", 2, "", lambda v: all(1.5 <= x <= 5.0 for x in v))
    table.add("sim_cost", "computing time an IMU sample, all updates and replays",
              1e6 * run.summary["filter_s"] / run.summary["imu_samples"], None, None,
              "KF-GINS 11.9 with parsing, nothing late", 1, "us")
    smoothed = score.navigate(*score.sim_arguments("--use-arrival-times", "--smooth"))
    errors = score.SimErrors(smoothed.trajectory)
    n, e, d = errors.clean_position_rms()
    roll, pitch, yaw = errors.clean_attitude_rms()
    table.add("sim_smoothed_position", "smoothed: clean position RMS, worse of N and E", max(n, e), 0.010, 0.0085, "", 4)
    table.add("sim_smoothed_height", "smoothed: clean position RMS, D", d, None, None, "", 4)
    table.add("sim_smoothed_attitude", "smoothed: roll, pitch (worse) / yaw RMS", [max(roll, pitch), yaw],
              [0.08, 0.28], [0.05, 0.20], "", 3, "deg")
    table.add("sim_smoothed_outages", "smoothed: outages of 10/30/60 s, worst",
              [errors.worst_outage(s) for s in (10, 30, 60)], None, None, "", 3)
    table.add("sim_smoothed_nees", "smoothed: NEES of position(3) / attitude(3)", errors.clean_nees(), None, None, "", 2, "")
    table.add("smoothing", "smoothing 21 min at 75 Hz: backward pass", smoothed.summary["smoother_s"], 3.0, 1.0, "", 2, "s")
    table.add("smoothing_all", "the whole program then, files read and written", smoothed.wall_s, None, None, "", 2, "s")
    table.add("smoothing_memory", "smoothing: peak memory", smoothed.peak_mb, 400.0, None, "", 0, "MB")


def second_antenna(table, folder):
    run = score.navigate(*score.sim_arguments("--use-arrival-times", gnss=score.two_antennas(folder / "two.csv")))
    table.add("two_antennas", "yaw with a second antenna (0.25 deg white an epoch)",
              score.SimErrors(run.trajectory).clean_attitude_rms()[2], 0.10, 0.08, "", 3, "deg")


def late_data(table, folder):
    """The last row of a run as received against one in order, cut where some trouble has just been."""
    imu, gnss = score.read(score.SIM / "imu.csv.gz"), score.read(score.SIM / "gnss.csv.gz")
    distance, angle = 0.0, 0.0
    for cut in LATE_CUTS:
        # Nothing may be on its way at the end: the last half second is without GNSS.
        score.write(folder / "imu.csv", score.rows_where(imu, imu["t"] <= cut))
        score.write(folder / "gnss.csv", score.rows_where(gnss, gnss["t"] <= cut - 0.5))
        ends = []
        for more in ([], ["--use-arrival-times"]):
            run = score.navigate(*score.sim_arguments(*more, imu=folder / "imu.csv", gnss=folder / "gnss.csv"))
            ends.append({name: column[-1:] for name, column in run.trajectory.items()})
        a, b = ends
        distance = max(distance, np.linalg.norm(score.metres(a["lat"], a["lon"], a["h"], b["lat"], b["lon"], b["h"])))
        angle = max(angle, *(abs(score.wrap_deg(a[k] - b[k]))[0] for k in ("roll", "pitch", "yaw")))
    table.add("late_position", "late data against data in order, after catching up: position", 1e3 * distance, 1.0, None,
              "", 3, "mm")
    table.add("late_attitude", "late data against data in order: attitude", angle, 0.002, None, "", 4, "deg")


def alignment(table, folder):
    """Thrown in while moving, without wheels and without attitude unit, heading turned to 36 directions."""
    truth = score.read(score.SIM / "truth.csv.gz")
    moving = np.hypot(truth["vN"], truth["vE"]) > 0.5
    lost = [(a, b) for a, b in zip(*(score.read(score.SIM / "events.csv.gz")[k] for k in ("t_start", "t_end")))]

    def fit(t):
        """Motion now, and nothing but good fixes for as long as we look."""
        return moving[np.searchsorted(truth["t"], t)] and not any(a - ALIGN_SECONDS < t < b for a, b in lost)

    starts = [t for t in np.arange(300135.0, 301195.0, 1.0) if fit(t)]
    starts = [starts[i * (len(starts) - 1) // (HEADINGS - 1)] for i in range(HEADINGS)]
    for wheels in (False, True):
        at_15, settled = [], []
        for k, start in enumerate(starts):
            part, turned = score.turned_start(folder, start, 360.0 * k / HEADINGS, ALIGN_SECONDS)
            args = ["--imu", part / "imu.csv", "--gnss", part / "gnss.csv", "--lever", score.SIM_LEVER]
            run = score.navigate(*args, *(["--odo", part / "odo.csv"] if wheels else []))
            motion_s = np.cumsum(np.hypot(turned["vN"], turned["vE"]) > 0.5) * 0.04
            reached = turned["t"][np.searchsorted(motion_s, 15.0)] if motion_s[-1] > 15.0 else turned["t"][-1]
            if len(run.trajectory["t"]) == 0 or run.trajectory["t"][0] > reached:
                at_15.append(180.0)
                settled.append(np.inf)
                continue
            errors = score.SimErrors(run.trajectory, truth=turned)
            yaw = np.abs(errors.attitude[:, 2])
            at_15.append(yaw[np.searchsorted(errors.t, reached)])
            bad = np.flatnonzero(yaw > 3.0)
            since = errors.t[0] if len(bad) == 0 else errors.t[min(bad[-1] + 1, len(errors.t) - 1)]
            settled.append(motion_s[np.searchsorted(turned["t"], since)] if not len(bad) or bad[-1] + 1 < len(yaw)
                           else np.inf)
        name = "with wheels" if wheels else "without wheels"
        table.add(f"alignment_{'wheels' if wheels else 'bare'}",
                  f"start in motion, {HEADINGS} headings, {name}: worst yaw error after 15 s", max(at_15), 3.0, None, "",
                  2, "deg")
        table.add(f"alignment_settled_{'wheels' if wheels else 'bare'}",
                  f"start in motion, {name}: motion until under 3 deg for good, median / worst",
                  [np.median(settled), max(settled)], None, 10.0, "", 1, "s")


def drive(table, folder):
    hold_out = score.every_other_fixed_epoch(folder / "holdout.csv")
    run = score.navigate(*score.drive_arguments("--hold-out", hold_out, "--smooth"))
    for key, name, must, aim, others in (
            ("real_time", "drive: 2 Hz hold-out RMS N/E/D", [0.022, 0.027, 0.017], [0.019, 0.024, 0.015],
             "KF-GINS 0.028 / 0.030 / 0.016, with the offset given 0.019 / 0.025 / 0.015"),
            ("smoothed", "drive, smoothed: 2 Hz hold-out RMS N/E/D", None, None, "")):
        held = run.summary[key]["held_out_fixed"]
        table.add(f"drive_hold_out_{key}", name, [held["rms_n_m"], held["rms_e_m"], held["rms_d_m"]], must, aim, others, 4)
    offset = run.summary["found"]["time_offset_s"]["value"]
    table.add("drive_offset", "drive: time offset of the IMU found", offset, "-0.12..-0.06", "-0.09", "", 3, "s",
              lambda v: abs(v[0] + 0.09) <= 0.03)
    goals = {10: (None, None, ""), 15: ([5.0, 0.45], [3.0, 0.30], "GNSS_IMU 5.5 / 0.46, KF-GINS 12.5"),
             30: (None, None, "GNSS_IMU 50, KF-GINS 56"), 60: (None, None, "KF-GINS 337")}
    for length, (must, aim, others) in goals.items():
        worst = {"real_time": [], "smoothed": []}
        for number in score.outage_runs(length):
            run = score.navigate(*score.drive_arguments("--blank", score.DRIVE / "outage_windows.csv", "--blank-run",
                                                        number, "--smooth"))
            for key, errors in worst.items():
                errors += [w["worst_horizontal_m"] for w in run.summary[key]["windows"] if w["n"] > 0]
        figures = [float(score.rms(np.array(errors))) for errors in worst.values()]
        table.add(f"drive_outages_{length}",
                  f"drive: {length} s without GNSS, RMS of the largest error, real time / smoothed", figures, must, aim,
                  others, 2)


PARTS = {"sim": lambda t, f: sim(t), "antenna": second_antenna, "late": late_data, "alignment": alignment, "drive": drive}


MARKS = ("<!-- ./run bench navigation -->\n", "<!-- end -->")


def put_into(path, text):
    """Replaces what stands between the marks of a file."""
    page = path.read_text()
    begin, end = page.index(MARKS[0]) + len(MARKS[0]), page.index(MARKS[1])
    path.write_text(page[:begin] + text + "\n" + page[end:])


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("parts", nargs="*", help=f"only these of {', '.join(PARTS)}")
    parser.add_argument("--json", help="figures into this file")
    parser.add_argument("--into", help="file whose table is replaced", type=pathlib.Path)
    args = parser.parse_args()
    for part in args.parts:
        if part not in PARTS:
            parser.error(f"no part '{part}'; there are: {', '.join(PARTS)}")
    table = Table()
    for name in args.parts or PARTS:
        with tempfile.TemporaryDirectory(prefix="kawara-") as folder:
            PARTS[name](table, pathlib.Path(folder))
    print(table.markdown())
    if args.into:
        put_into(args.into, table.markdown())
    if args.json:
        pathlib.Path(args.json).write_text(json.dumps(table.figures, indent=1) + "\n")
    if table.failed:
        print(f"{table.failed} of {len(table.lines)} miss their goal: (!)")


if __name__ == "__main__":
    main()
