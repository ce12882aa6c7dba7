"""kawara-navigate as its users meet it: what it writes, and what it answers to every mistake."""
import csv
import gzip
import json
import os
import pathlib
import signal
import subprocess
import tempfile
import time
import unittest

from processes import BIN, SOURCE, run

DRIVE = SOURCE / "data" / "drive_0708"
END = 243261.729 + 90.0  # the first minute and a half of the drive


def lines_until(path, end):
    """The header and the rows of a recording up to a time."""
    with gzip.open(path, "rt") as file:
        lines = file.read().splitlines()
    return [lines[0]] + [line for line in lines[1:] if float(line.split(",")[0]) <= end]


class NavigateTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.imu_lines = lines_until(DRIVE / "imu.csv.gz", END)
        cls.gnss_lines = lines_until(DRIVE / "gnss.csv.gz", END)

    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="kawara-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.imu = self.file("imu.csv", self.imu_lines)
        self.gnss = self.file("gnss.csv", self.gnss_lines)
        self.out = self.folder / "traj.csv"

    def file(self, name, lines):
        path = self.folder / name
        path.write_text("\n".join(lines) + "\n")
        return path

    def navigate(self, *more, imu=None, gnss=None, out=None, lever="0,-0.05,0", sensor="consumer-mems"):
        return run("kawara-navigate", "--imu", imu or self.imu, "--gnss", gnss or self.gnss, "--sensor", sensor,
                   "--lever", lever, "--out", out or self.out, *more)

    def good(self, *more, **files):
        result = self.navigate(*more, **files)
        self.assertEqual(result.returncode, 0, result.stderr)
        return result

    def rows(self):
        with open(self.out, newline="") as file:
            return list(csv.DictReader(file))

    def assert_mistake(self, result, *expected, status=2):
        """One line that names the program and the matter, the exit status, and no file left."""
        self.assertEqual(result.returncode, status, result.stderr)
        self.assertEqual(result.stdout, "")
        last = result.stderr.splitlines()[-1]
        self.assertTrue(last.startswith("kawara-navigate: "), result.stderr)
        for text in expected:
            self.assertIn(text, last)
        self.assertEqual([p.name for p in self.folder.glob("traj*")], [])

    def test_trajectory(self):
        result = self.good()
        rows = self.rows()
        self.assertEqual(list(rows[0]), "t,lat,lon,h,vN,vE,vD,roll,pitch,yaw,sd_n,sd_e,sd_d,sd_vN,sd_vE,sd_vD,sd_roll,"
                         "sd_pitch,sd_yaw,state,reason".split(","))
        times = [float(row["t"]) for row in rows]
        self.assertEqual(times, sorted(set(times)))
        # The car moves off 30 s after the start of the record; from then on a row a sample.
        self.assertGreater(len(rows), 0.4 * len(self.imu_lines))
        self.assertAlmostEqual(times[-1], float(self.imu_lines[-1].split(",")[0]), delta=0.2)
        last = rows[-1]
        self.assertRegex(last["lat"], r"^40\.\d{10}$")
        self.assertRegex(last["h"], r"^\d+\.\d{4}$")
        self.assertEqual((last["state"], last["reason"]), ("fixed", "nominal"))
        for word in ("rtk fixed", "NIS/dof", "time offset", "us an IMU sample"):
            self.assertIn(word, result.stdout)
        self.assertEqual(result.stderr, "")

    def test_the_same_twice(self):
        self.good()
        once = self.out.read_bytes()
        self.good()
        self.assertEqual(self.out.read_bytes(), once)

    def test_gzip_columns_in_any_order_and_unknown_ones(self):
        self.good()
        once = self.out.read_bytes()
        shuffled = self.folder / "gnss.csv.gz"
        with gzip.open(shuffled, "wt") as file:
            for i, line in enumerate(self.gnss_lines):
                file.write(",".join(reversed(line.split(","))) + ("," + ("weather" if i == 0 else "fair")) + "\n")
        result = self.good(gnss=shuffled)
        self.assertEqual(self.out.read_bytes(), once)
        self.assertEqual(result.stderr, f"kawara-navigate: {shuffled}: not used: weather\n")

    def test_antenna_instead_of_imu(self):
        self.good(lever="0,0,-2.5")
        imu = float(self.rows()[-1]["h"])
        self.good("--at", "antenna", lever="0,0,-2.5")
        self.assertAlmostEqual(float(self.rows()[-1]["h"]) - imu, 2.5, delta=0.05)

    def test_bad_rows_cost_themselves_only(self):
        lines = list(self.imu_lines)
        lines[2000] = "garbage"
        lines[3000] = lines[3000].replace(",", ",x", 1)
        result = self.good(imu=self.file("imu.csv", lines))
        self.assertIn("imu.csv:2001: expected 7 fields, found 1; row left out", result.stderr)
        self.assertIn("imu.csv:3001: wx is 'x", result.stderr)
        self.assertIn("input rows left out: 2", result.stdout)

    def test_smoothed_blanked_and_held_out(self):
        held_out = [line.split(",")[0] for line in self.gnss_lines[1:]][1::2]
        window = (243340.0, 243345.0)
        result = self.good("--smooth", "--json", "--hold-out", self.file("holdout.csv", ["t", *held_out]),
                           "--blank", self.file("blank.csv", ["t_start,t_end", "%s,%s" % window]))
        summary = json.loads(result.stdout)
        for which in ("real_time", "smoothed"):
            self.assertEqual(summary[which]["windows"][0]["t_start"], window[0])
            self.assertEqual(summary[which]["windows"][0]["n"], 20)
            held = summary[which]["held_out_fixed"]
            self.assertGreater(held["n"], 50)
            self.assertLess(max(held["rms_n_m"], held["rms_e_m"], held["rms_d_m"]), 0.2)
        self.assertLess(summary["smoothed"]["rms_of_worst_m"], summary["real_time"]["rms_of_worst_m"])
        self.assertEqual(summary["rows"], len(self.rows()))

    def test_report(self):
        plot = self.folder / "report.html"
        self.good("--plot", plot)
        page = plot.read_text()
        self.assertTrue(page.startswith("<!DOCTYPE html>"))
        self.assertTrue(page.rstrip().endswith("</html>"))
        self.assertNotIn("http", page)
        self.assertIn("NIS/dof", page)

    def test_no_motion_no_heading(self):
        """A car that only stands: no solution, said so, an empty trajectory."""
        result = self.good(imu=self.file("imu.csv", self.imu_lines[:1001]))
        self.assertIn("no solution", result.stdout)
        self.assertEqual(self.rows(), [])

    def test_wrong_paths(self):
        missing = self.folder / "missing.csv"
        for option in ("--odo", "--attitude", "--blank", "--hold-out"):
            self.assert_mistake(self.navigate(option, missing), "missing.csv", "No such file")
        self.assert_mistake(self.navigate(imu=missing), "missing.csv", "No such file")
        self.assert_mistake(self.navigate(gnss=missing), "missing.csv", "No such file")
        self.assert_mistake(self.navigate(imu=self.folder), "is a directory")

    def test_files_that_are_not_what_they_should_be(self):
        empty = self.file("empty.csv", [])
        self.assert_mistake(self.navigate(imu=empty), "empty.csv", "empty, expected a header line with t, wx")
        self.assert_mistake(self.navigate(imu=self.gnss), "gnss.csv:1: no column 'wx'")
        self.assert_mistake(self.navigate(gnss=self.imu), "imu.csv:1: no column 'q'")
        self.assert_mistake(self.navigate(imu=self.file("x.csv", self.imu_lines[1:])), "x.csv:1: expected a header line")
        words = ["t,wx,wy,wz,ax,ay,az"] + ["one,two,three,four,five,six,seven"] * 20
        self.assert_mistake(self.navigate(imu=self.file("x.csv", words)), "x.csv:2: t is 'one': not a number",
                            "20 of 20 rows")
        noise = self.folder / "noise.csv"
        noise.write_bytes(bytes(range(256)) * 1000)
        self.assert_mistake(self.navigate(imu=noise), "noise.csv:")
        cut = self.folder / "cut.csv.gz"
        cut.write_bytes((DRIVE / "imu.csv.gz").read_bytes()[:300_000])
        self.assert_mistake(self.navigate(imu=cut), "cut.csv.gz: damaged or cut gzip")

    def test_words_that_mean_nothing(self):
        mistakes = [
            (["--sensor", "brick"], ["'brick': no such profile", "ahrs400cc-100", "consumer-mems", "industrial-mems"]),
            (["--lever", "1,2"], ["--lever '1,2'", "forward"]),
            (["--lever", "1,2,x"], ["--lever '1,2,x'"]),
            (["--lever", "1,2,3,4"], ["--lever '1,2,3,4'"]),
            (["--lever", "nan,0,0"], ["--lever"]),
            (["--at", "roof"], ["--at 'roof': expected imu or antenna"]),
            (["--constraint", "on"], ["--constraint 'on': expected auto or off"]),
            (["--blank-run", "3"], ["--blank-run without --blank"]),
            (["--use-arrival-times"], ["no column 't_rx', which --use-arrival-times needs"]),
            (["--fly"], ["--fly"]),
        ]
        for words, expected in mistakes:
            with self.subTest(words):
                self.assert_mistake(run("kawara-navigate", "--imu", self.imu, "--gnss", self.gnss, "--out", self.out,
                                        *words), *expected)
        self.assert_mistake(run("kawara-navigate", "--imu", self.imu, "--out", self.out), "give --imu and --gnss")
        self.assert_mistake(run("kawara-navigate", self.imu, "--imu", self.imu, "--out", self.out), "one or the other")
        self.assert_mistake(run("kawara-navigate", self.imu, "--out", self.out), "not an LCM log")
        self.assert_mistake(run("kawara-navigate", self.folder / "no.lcm", "--out", self.out), "No such file")

    def test_figures_of_a_sensor(self):
        self.good()
        as_profile = self.out.read_bytes()
        self.good(sensor=self.file("same.yaml", ["profile: consumer-mems"]))
        self.assertEqual(self.out.read_bytes(), as_profile)
        self.good(sensor=self.file("own.yaml", ["profile: consumer-mems", "angle_walk_deg_per_sqrt_h: 0.2",
                                                "gyro_instability_degph: 8"]))
        self.assertNotEqual(self.out.read_bytes(), as_profile)

    def test_mistakes_in_the_figures_of_a_sensor(self):
        for lines, expected in (
                (["profile: brick"], ["x.yaml:1:10: profile = brick", "consumer-mems"]),
                (["angle_walk_deg_per_sqrt_h: 0"], ["x.yaml:1:28: angle_walk_deg_per_sqrt_h = 0: expected"]),
                (["gyro_scale: 0.01", "gyro_bais_degps: 1"], ["x.yaml:2:1: gyro_bais_degps", "gyro_bias_degps"])):
            with self.subTest(lines):
                self.assert_mistake(self.navigate(sensor=self.file("x.yaml", lines)), *expected)
        self.assert_mistake(self.navigate(sensor=self.folder / "none.yaml"), "none.yaml")

    def test_hold_out_that_fits_nothing(self):
        self.assert_mistake(self.navigate("--hold-out", self.file("holdout.csv", ["t", "17.5"])),
                            "holdout.csv: none of its 1 epochs is among")

    def test_windows_of_several_runs(self):
        windows = DRIVE / "outage_windows.csv"
        self.assert_mistake(self.navigate("--blank", windows), "choose one with --blank-run")
        self.assert_mistake(self.navigate("--blank", windows, "--blank-run", "99"), "no window of run 99")
        self.good("--blank", windows, "--blank-run", "4")

    def test_outputs_that_cannot_be_written(self):
        self.assert_mistake(self.navigate(out=self.folder / "no" / "traj.csv"), "No such file", status=1)
        self.assert_mistake(self.navigate(out=self.folder), "is a directory", status=1)
        self.assert_mistake(self.navigate(out="/dev/full"), "No space left", status=1)
        result = self.navigate("--plot", self.folder / "no" / "report.html")
        self.assertEqual(result.returncode, 1)
        self.assertIn("report.html: No such file", result.stderr)

    def test_killed_in_the_middle(self):
        """An old trajectory stays as it was, and no half file is left beside it."""
        self.out.write_text("old\n")
        fifo = self.folder / "slow.csv"
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGKILL):
            os.mkfifo(fifo)
            process = subprocess.Popen([BIN / "kawara-navigate", "--imu", fifo, "--gnss", self.gnss, "--out", self.out,
                                        "--sensor", "consumer-mems"], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE)
            with open(fifo, "w") as imu:
                imu.write("\n".join(self.imu_lines[:8000]) + "\n")
                imu.flush()
                deadline = time.monotonic() + 30
                while not (self.folder / "traj.csv.part").exists() and time.monotonic() < deadline:
                    time.sleep(0.01)
                self.assertTrue((self.folder / "traj.csv.part").exists())
                process.send_signal(number)
                process.wait(30)
                process.stderr.close()
            self.assertEqual(process.returncode, -number)
            self.assertEqual(self.out.read_text(), "old\n")
            if number != signal.SIGKILL:  # of which nobody can clean up after
                self.assertFalse((self.folder / "traj.csv.part").exists(), number)
            fifo.unlink()
        self.good()
        self.assertEqual(sorted(p.name for p in self.folder.glob("traj*")), ["traj.csv"])

    def test_from_the_robots_log(self):
        """A robot of the simulator, its log alone, against the simulator's truth."""
        log, truth = self.folder / "mission.lcm", self.folder / "truth"
        done = run("kawara-sim", "site", "--site", SOURCE / "configs/sites/warehouse_yard.yaml", "--run-dir", truth,
                   "--virtual", log, "--onboard-config", SOURCE / "configs/survey_robot.yaml", "--no-camera",
                   "--onboard-set", "camera.source=none", timeout=500)
        self.assertEqual(done.returncode, 0, done.stderr)
        result = run("kawara-navigate", log, "--out", self.out)
        self.assertEqual(result.returncode, 0, result.stderr)
        once = self.out.read_bytes()
        run("kawara-navigate", log, "--out", self.out, check=True)
        self.assertEqual(self.out.read_bytes(), once)
        true = {}
        with open(truth / "truth_trajectory.csv", newline="") as file:
            for row in csv.DictReader(file):  # 10 ms apart
                true[round(int(row["gps_ns"]) % (604800 * 10**9) / 1e7)] = row
        rows = self.rows()
        last = float(rows[-1]["t"])
        settled = [row for row in rows if float(row["t"]) > float(rows[0]["t"]) + 30.0]
        self.assertGreater(len(settled), 5000)
        for row in settled[::100]:
            at = true[round(float(row["t"]) * 100)]
            self.assertAlmostEqual(float(row["lat"]), float(at["lat_deg"]), delta=0.1 / 111e3, msg=row["t"])
            self.assertAlmostEqual(float(row["h"]), float(at["h_ellipsoidal_m"]), delta=0.15, msg=row["t"])
            yaw = (float(row["yaw"]) - float(at["yaw_deg"]) + 180.0) % 360.0 - 180.0
            self.assertAlmostEqual(yaw, 0.0, delta=3.0, msg=row["t"])

        (self.folder / "blank.csv").write_text(f"{last - 20.0},{last - 10.0}\n")
        result = run("kawara-navigate", log, "--blank", self.folder / "blank.csv", "--json", "--out", self.out, check=True)
        summary = json.loads(result.stdout)
        self.assertEqual(summary["outages"], 1)
        self.assertGreater(summary["real_time"]["windows"][0]["n"], 50)

        log.write_bytes(log.read_bytes()[:200])
        self.out.unlink()
        self.assert_mistake(run("kawara-navigate", log, "--out", self.out), "CONFIG")

    def test_help_names_the_profiles(self):
        result = run("kawara-navigate", "--help")
        self.assertEqual(result.returncode, 0)
        for name in ("ahrs400cc-100", "consumer-mems", "industrial-mems", "--use-arrival-times"):
            self.assertIn(name, result.stdout)


if __name__ == "__main__":
    unittest.main()
