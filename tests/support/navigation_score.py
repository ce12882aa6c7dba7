"""Runs kawara-navigate on the project's navigation data and measures what came out against the truth."""
import csv
import functools
import gzip
import json
import os
import pathlib
import tempfile
import time

import numpy as np

from processes import BIN, SOURCE

SIM = SOURCE / "data" / "sim_ahrs400_spec"
DRIVE = SOURCE / "data" / "drive_0708"
SIM_LEVER = "0.12,-0.18,-0.92"
DRIVE_LEVER = "0,-0.05,0"

# Clean: what is neither start nor event, nor the seconds after one in which the filter recovers.
SIM_START = 300000.0
START_S = 130.0
AFTER_EVENT_S = 20.0


def read(path):
    """A CSV file of numbers (plain or .gz): column name -> array; columns of text stay text."""
    path = pathlib.Path(path)
    return dict(_project_data(path) if SOURCE / "data" in path.parents else _parse(path))


@functools.cache
def _project_data(path):
    return _parse(path)


def _parse(path):
    opener = gzip.open if str(path).endswith(".gz") else open
    with opener(path, "rt", newline="") as file:
        rows = csv.reader(file)
        names = next(rows)
        columns = list(zip(*rows)) or [()] * len(names)
    table = {}
    for name, column in zip(names, columns):
        try:
            table[name] = np.array(column, dtype=float)
        except ValueError:
            table[name] = np.array(column)
    return table


def write(path, table, digits=None):
    """The reverse; `digits` behind the point by column name, 9 where it does not say."""
    digits = digits or {}
    formats = [f"%.{digits.get(name, 9)}f" for name in table]
    with open(path, "w") as file:
        file.write(",".join(table) + "\n")
        np.savetxt(file, np.column_stack(list(table.values())), fmt=formats, delimiter=",")


def rows_where(table, mask):
    return {name: column[mask] for name, column in table.items()}


class Outcome:
    """One run: its summary, trajectory, wall time and peak memory."""

    def __init__(self, summary, trajectory, wall_s, peak_mb):
        self.summary, self.trajectory, self.wall_s, self.peak_mb = summary, trajectory, wall_s, peak_mb


def navigate(*args, out=None, timeout=300):
    """Runs the program; raises with what it said if it fails."""
    with tempfile.TemporaryDirectory(prefix="kawara-") as folder:
        out = out or pathlib.Path(folder) / "traj.csv"
        said = pathlib.Path(folder) / "said"
        command = [str(BIN / "kawara-navigate"), *map(str, args), "--json", "--out", str(out)]
        start = time.monotonic()
        with open(said, "wb") as stdout, open(str(said) + ".err", "wb") as stderr:
            pid = os.posix_spawn(command[0], command, os.environ, file_actions=[
                (os.POSIX_SPAWN_DUP2, stdout.fileno(), 1), (os.POSIX_SPAWN_DUP2, stderr.fileno(), 2)])
            _, status, usage = os.wait4(pid, 0)
        wall_s = time.monotonic() - start
        if status != 0:
            raise RuntimeError(" ".join(command) + ": " + pathlib.Path(str(said) + ".err").read_text())
        return Outcome(json.loads(said.read_text()), read(out), wall_s, usage.ru_maxrss / 1024)


def sim_arguments(*more, imu=None, gnss=None, odo=True, attitude=True):
    args = ["--imu", imu or SIM / "imu.csv.gz", "--gnss", gnss or SIM / "gnss.csv.gz", "--lever", SIM_LEVER,
            "--sensor", "ahrs400cc-100"]
    if odo:
        args += ["--odo", SIM / "odo.csv.gz"]
    if attitude:
        args += ["--attitude", SIM / "ahrs.csv.gz"]
    return [*args, *more]


def drive_arguments(*more):
    return ["--imu", DRIVE / "imu.csv.gz", "--gnss", DRIVE / "gnss.csv.gz", "--lever", DRIVE_LEVER,
            "--sensor", "consumer-mems", *more]


def metres(lat_deg, lon_deg, h, from_lat_deg, from_lon_deg, from_h):
    """North, east, down from one place to another nearby (WGS 84 radii of curvature)."""
    phi = np.radians(from_lat_deg)
    e2 = 6.69437999014e-3
    w2 = 1 - e2 * np.sin(phi) ** 2
    meridian = 6378137.0 * (1 - e2) / w2 ** 1.5
    normal = 6378137.0 / np.sqrt(w2)
    return np.column_stack([np.radians(lat_deg - from_lat_deg) * (meridian + from_h),
                            np.radians(lon_deg - from_lon_deg) * (normal + from_h) * np.cos(phi),
                            from_h - h])


def wrap_deg(angle):
    return (angle + 180.0) % 360.0 - 180.0


class SimErrors:
    """A trajectory minus the truth of the synthetic set, at the truth's instants it covers."""

    def __init__(self, trajectory, truth=None, events=None):
        truth = truth or read(SIM / "truth.csv.gz")
        events = events or read(SIM / "events.csv.gz")
        self.events = [(str(k), a, b) for k, a, b in zip(events["kind"], events["t_start"], events["t_end"])]
        begin, end = trajectory["t"][0], trajectory["t"][-1]
        inside = (truth["t"] >= begin) & (truth["t"] <= end)
        truth = rows_where(truth, inside)
        self.t = truth["t"]

        def at(name):
            return np.interp(self.t, trajectory["t"], trajectory[name])

        self.ned = metres(at("lat"), at("lon"), at("h"), truth["lat"], truth["lon"], truth["h"])
        self.horizontal = np.hypot(self.ned[:, 0], self.ned[:, 1])
        yaw = np.degrees(np.interp(self.t, trajectory["t"], np.unwrap(np.radians(trajectory["yaw"]))))
        self.attitude = np.column_stack([at("roll") - truth["roll"], at("pitch") - truth["pitch"],
                                         wrap_deg(yaw - truth["yaw"])])
        self.sd_ned = np.column_stack([at("sd_n"), at("sd_e"), at("sd_d")])
        self.sd_attitude = np.column_stack([at("sd_roll"), at("sd_pitch"), at("sd_yaw")])
        self.speed = np.hypot(truth["vN"], truth["vE"])

    def during(self, begin, end):
        return (self.t >= begin) & (self.t <= end)

    def clean(self):
        mask = self.t >= SIM_START + START_S
        for _, begin, end in self.events:
            mask &= ~self.during(begin, end + AFTER_EVENT_S)
        return mask

    def clean_position_rms(self):
        return rms(self.ned[self.clean()])

    def clean_attitude_rms(self):
        return rms(self.attitude[self.clean()])

    def clean_nees(self):
        """Mean of the squared errors in units of the variances given: position (3), attitude (3)."""
        clean = self.clean()
        return (np.mean(np.sum((self.ned[clean] / self.sd_ned[clean]) ** 2, axis=1)),
                np.mean(np.sum((self.attitude[clean] / self.sd_attitude[clean]) ** 2, axis=1)))

    def worst_outage(self, length_s):
        return max(self.horizontal[self.during(a, b)].max() for kind, a, b in self.events
                   if kind == "rtk_lost" and round(b - a) == length_s)

    def worst_wrong_fix(self):
        return max(self.horizontal[self.during(a, b)].max() for kind, a, b in self.events if kind == "rtk_wrong_fix")

    def wrong_fix_yaw(self):
        """How far the yaw error moves during a wrong fix from what it was before."""
        worst = 0.0
        for kind, a, b in self.events:
            if kind == "rtk_wrong_fix":
                yaw = self.attitude[self.during(a, b), 2]
                worst = max(worst, np.abs(yaw - yaw[0]).max())
        return worst

    def after_wrong_fix(self):
        """The largest horizontal error from 3 to 4 s after a wrong fix."""
        return max(self.horizontal[self.during(b + 3.0, b + 4.0)].max() for kind, a, b in self.events
                   if kind == "rtk_wrong_fix")

    def float_rms(self):
        mask = np.zeros(len(self.t), dtype=bool)
        for kind, a, b in self.events:
            if kind == "rtk_float":
                mask |= self.during(a, b)
        return rms(self.ned[mask])


def rms(errors):
    return np.sqrt(np.mean(np.square(errors), axis=0))


def every_other_fixed_epoch(path):
    """Writes the hold-out file of the drive: every second epoch that is RTK fixed."""
    gnss = read(DRIVE / "gnss.csv.gz")
    write(path, {"t": gnss["t"][1::2][gnss["q"][1::2] == 1]}, {"t": 3})
    return path


def outage_runs(length_s):
    """Numbers of the runs of outage_windows.csv with windows of this length."""
    windows = read(DRIVE / "outage_windows.csv")
    return sorted({int(run) for run, length in zip(windows["run"], windows["length_s"]) if length == length_s})


def two_antennas(path, sd_deg=0.25, seed=1):
    """Writes the synthetic set's GNSS file with the heading of a second antenna: truth and white noise."""
    gnss, truth = read(SIM / "gnss.csv.gz"), read(SIM / "truth.csv.gz")
    yaw = np.degrees(np.interp(gnss["t"], truth["t"], np.unwrap(np.radians(truth["yaw"]))))
    noise = np.random.default_rng(seed).normal(0.0, sd_deg, len(yaw))
    gnss["heading"] = (yaw + noise) % 360.0
    gnss["sd_heading"] = np.full(len(yaw), sd_deg)
    write(path, gnss, {"t": 3, "t_rx": 3})
    return path


def turned_start(folder, t_start, angle_deg, length_s):
    """A part of the synthetic set, turned about the vertical: inertial data are what they were (but for the
    Earth's rotation, far below this unit's bias), everything that knows north is turned. Returns the files'
    paths, wheels included, and the truth."""
    folder = pathlib.Path(folder)
    c, s = np.cos(np.radians(angle_deg)), np.sin(np.radians(angle_deg))
    truth = read(SIM / "truth.csv.gz")
    lat0, lon0 = truth["lat"][0], truth["lon"][0]
    m_per_deg_lat, m_per_deg_lon = (metres(lat0 + 1.0, lon0 + 1.0, 0.0, lat0, lon0, 0.0)[0, :2])

    def turn(table):
        north, east = (table["lat"] - lat0) * m_per_deg_lat, (table["lon"] - lon0) * m_per_deg_lon
        table["lat"] = lat0 + (c * north - s * east) / m_per_deg_lat
        table["lon"] = lon0 + (s * north + c * east) / m_per_deg_lon
        table["vN"], table["vE"] = c * table["vN"] - s * table["vE"], s * table["vN"] + c * table["vE"]
        return table

    def part(name):
        table = read(SIM / name)
        return rows_where(table, (table["t"] >= t_start) & (table["t"] <= t_start + length_s))

    write(folder / "imu.csv", part("imu.csv.gz"))
    write(folder / "gnss.csv", turn(part("gnss.csv.gz")), {"lat": 10, "lon": 10})
    write(folder / "odo.csv", part("odo.csv.gz"))
    truth = turn(part("truth.csv.gz"))
    truth["yaw"] = (truth["yaw"] + angle_deg) % 360.0
    return folder, truth
