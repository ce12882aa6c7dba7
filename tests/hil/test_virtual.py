"""kawara-sim --virtual: a mission takes as long as the computation needs, is the same byte for byte, and is taken by the other
programs as any mission; and truth.lcm beside it."""
import csv
import json
import pathlib
import shutil
import tempfile
import unittest

from processes import SOURCE, run

SITE = SOURCE / "configs/sites/warehouse_yard.yaml"
DRIVE = SOURCE / "data/drive_0708"
ROBOT = SOURCE / "configs/survey_robot.yaml"
BLIND = ("--no-camera", "--onboard-set", "camera.source=none")
SMALL = ("--doughnut-px", "256", "--samples", "1", "--light-cell", "5")
SMALL_OPTICS = [f"picture.doughnut.{key}={value}" for key, value in
                {"width_px": 256, "height_px": 256, "center_u_px": 127.5, "center_v_px": 127.5, "l_in_px": 30,
                 "l_base_px": 65.625, "l_out_px": 125}.items()] + ["picture.panorama.width_px=512",
                                                                  "picture.preview_width_px=128"]
SEEING = SMALL + tuple(x for setting in SMALL_OPTICS for x in ("--onboard-set", setting))


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class VirtualTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-virtual-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def site(self, name, *more):
        """Returns the log and the run-dir."""
        log, truth = self.folder / f"{name}.lcm", self.folder / name
        done = run("kawara-sim", "site", "--site", SITE, "--run-dir", truth, "--virtual", log, "--onboard-config", ROBOT, *more,
                   timeout=500)
        self.assertEqual(done.returncode, 0, done.stderr)
        print(done.stdout.strip())
        return log, truth

    def export(self, log, channel):
        out = self.folder / f"{log.stem}-{channel}.csv"
        done = run("kawara-log", "export", log, "--channel", channel, "--out", out, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        return rows(out)

    def replay(self, log):
        again = log.with_suffix(".again.lcm")
        done = run("kawara-onboard", "--log", log, "--out", again, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return again

    def assert_same(self, log, again, channel):
        strip = lambda table: [{k: v for k, v in row.items() if k not in ("event_number", "recorded_utc")} for row in table]
        self.assertEqual(strip(self.export(log, channel)), strip(self.export(again, channel)), channel)

    def test_the_same_seed_gives_the_same_bytes_and_another_does_not(self):
        first, truth = self.site("a", "--duration", "30", *BLIND)
        second, truth_again = self.site("b", "--duration", "30", *BLIND)
        other, _ = self.site("c", "--duration", "30", "--seed", "2", *BLIND)
        self.assertEqual(first.read_bytes(), second.read_bytes())
        self.assertNotEqual(first.read_bytes(), other.read_bytes())
        for name in ("truth.lcm", "truth_epochs.csv"):
            self.assertEqual((truth / name).read_bytes(), (truth_again / name).read_bytes(), name)
        done = run("kawara-log", "check", first, timeout=60)
        self.assertEqual(done.returncode, 0, done.stdout)

    def test_replayed_and_stored_it_lies_on_the_truth(self):
        log, truth = self.site("a", "--duration", "60", *BLIND)
        again = self.replay(log)
        for channel in ("POSE", "GNSS", "CLOCK", "EVENT"):
            self.assert_same(log, again, channel)
        store = self.folder / "mission.gpkg"
        done = run("kawara-station", "--config", SOURCE / "configs/station.yaml", "--log", again, "--store", store, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        done = run("kawara-evaluate", "poses", "--truth", truth / "truth_trajectory.csv", "--result", store, "--json",
                   self.folder / "errors.json", timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        errors = json.loads((self.folder / "errors.json").read_text())
        self.assertGreater(errors["3D"]["n"], 30)
        self.assertLess(errors["horizontal"]["rms"], 0.03)
        self.assertLess(errors["3D"]["median"], 0.05)
        for angle in ("roll", "pitch"):
            self.assertLess(errors[angle]["rms"], 0.5, angle)
        self.assertLess(errors["yaw"]["rms"], 2.0)

    def test_the_filter_betters_fix_and_attitude_unit(self):
        log, truth = self.site("a", "--duration", "60", *BLIND)
        plain, plain_truth = self.site("b", "--duration", "60", "--onboard-set", "navigation.filter=false", *BLIND)
        filtered, composed = (self.errors(l, t) for l, t in ((log, truth), (plain, plain_truth)))
        for quantity in ("horizontal", "roll", "pitch"):
            self.assertLess(filtered[quantity]["rms"], 0.7 * composed[quantity]["rms"], quantity)
        done = run("kawara-log", "export", plain, "--channel", "NAV", "--out", self.folder / "nav.csv", timeout=60)
        self.assertIn("no messages on channel 'NAV'", done.stderr)

    def test_nav_says_how_the_solution_stands(self):
        log, _ = self.site("a", "--duration", "45", "--fault", "t=30 gps.silent 4s", *BLIND)
        said = [row["text"] for row in self.export(log, "NAV")]
        for state in ("none, no-fix-yet", "fixed, nominal", "dead-reckoning, no-gnss"):
            self.assertIn(state, said)
        self.assertEqual(said[-1], "fixed, nominal")

    def errors(self, log, truth):
        poses = log.with_suffix(".poses.csv")
        self.assertEqual(run("kawara-log", "export", log, "--channel", "POSE", "--out", poses, timeout=60).returncode, 0)
        out = log.with_suffix(".errors.json")
        done = run("kawara-evaluate", "poses", "--truth", truth / "truth_trajectory.csv", "--result", poses, "--json", out, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        return json.loads(out.read_text())

    def test_pictures_come_as_they_were_triggered_and_pulses_make_their_times_sharp(self):
        first, truth = self.site("a", "--start", "15", "--duration", "20", *SEEING)
        second, _ = self.site("b", "--start", "15", "--duration", "20", *SEEING)
        self.assertEqual(first.read_bytes(), second.read_bytes())
        exposures = rows(truth / "truth_exposures.csv")
        self.assertGreaterEqual(len(exposures), 10)
        self.assertEqual(len(self.export(first, "FRAME")), len(exposures))
        again = self.replay(first)
        for channel in ("PHASE1", "POSE.EPOCH"):
            self.assert_same(first, again, channel)
        self.assertEqual(len(self.export(truth / "truth.lcm", "TRUTH.EXPOSURE")), len(exposures))

        blunt, blunt_truth = self.site("c", "--start", "15", "--duration", "20", "--onboard-set", "gps.pps.device=", *SEEING)
        with_pulses, without = self.time_errors(first, truth), self.time_errors(blunt, blunt_truth)
        print(f"GPS time of exposures, worst error: {max(with_pulses) * 1e6:.0f} us with pulses, {max(without) * 1e6:.0f} us without")
        self.assertLess(max(with_pulses), 100e-6)
        self.assertLess(max(without), 30e-3)
        self.assertGreater(max(without), max(with_pulses))

    def time_errors(self, log, truth):
        """[s] of the poses' times against the middle of the exposures; the first seconds, before the pulses rule, left out."""
        true = [int(row["gps_ns"]) + 2_000_000 for row in rows(truth / "truth_exposures.csv")]
        said = [int(row["pose.gps_ns"]) for row in self.export(log, "POSE.EPOCH")][10:]
        self.assertGreater(len(said), 3)
        return [min(abs(t - s) for t in true) / 1e9 for s in said]

    def test_faults_happen_and_pass(self):
        log, _ = self.site("a", "--duration", "40", "--fault", "t=15 gps.unplug 3s", "--fault", "t=15 ahrs.silent 2s", *BLIND)
        said = " | ".join(row["name"] + " " + row["text"] for row in self.export(log, "EVENT"))
        for text in ("gps.port lost gps", "ahrs.stalled"):
            self.assertIn(text, said)
        times = [int(row["gps_ns"]) for row in self.export(log, "GNSS")]
        gaps = sorted(b - a for a, b in zip(times, times[1:]))
        self.assertGreater(gaps[-1], 3e9, "unplugged")
        self.assertLess(gaps[-2], 2e9, "and back")

    def test_a_recorded_drive_runs_in_virtual_time_too(self):
        log = self.folder / "drive.lcm"
        done = run("kawara-sim", "drive", "--data", DRIVE, "--run-dir", self.folder / "drive", "--start", "5", "--virtual", log,
                   "--onboard-config", SOURCE / "configs/demo.yaml", "--onboard-set", "camera.source=none", timeout=500)
        self.assertEqual(done.returncode, 0, done.stderr)
        print(done.stdout.strip())
        fixes = self.export(log, "GNSS")
        self.assertGreater(len(fixes), 2000, "nine minutes at 4 Hz")

    def test_truth_is_a_log_like_any(self):
        _, truth = self.site("a", "--duration", "5", *BLIND)
        done = run("kawara-log", "info", truth / "truth.lcm", timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        for channel in ("TRUTH.POSE", "TRUTH.OBJECT"):
            self.assertIn(channel, done.stdout)
        boxes, objects = self.export(truth / "truth.lcm", "TRUTH.OBJECT"), rows(truth / "truth_objects.csv")
        self.assertEqual([row["name"] for row in boxes], [row["name"] for row in objects])
        self.assertAlmostEqual(float(boxes[0]["centre_lat_deg"]), float(objects[0]["centre_lat_deg"]), places=9)
        poses = self.export(truth / "truth.lcm", "TRUTH.POSE")
        self.assertGreaterEqual(len(poses), 500)
        track = {row["gps_ns"]: row for row in rows(truth / "truth_trajectory.csv")}
        for pose in poses[::100]:
            self.assertAlmostEqual(float(pose["pose.lat_deg"]), float(track[pose["pose.gps_ns"]]["lat_deg"]), places=9)

    def test_mistakes_are_said_in_one_line(self):
        there = self.folder / "there.lcm"
        there.write_bytes(b"")
        base = ("site", "--site", SITE, "--run-dir", self.folder / "x", "--no-camera")
        for args, why in (
                ((*base, "--virtual", self.folder / "a.lcm"), "--onboard-config"),
                ((*base, "--virtual", self.folder / "a.lcm", "--onboard-config", SITE), "warehouse_yard.yaml:"),
                ((*base, "--virtual", self.folder / "a.lcm", "--onboard-config", ROBOT, "--lcm-url", ""), "--fault"),
                ((*base, "--virtual", there, "--onboard-config", ROBOT), "there.lcm")):
            done = run("kawara-sim", *args, timeout=300)
            self.assertEqual(done.returncode, 2, args)
            self.assertIn(why, done.stderr, args)
        self.assertEqual(there.read_bytes(), b"")


if __name__ == "__main__":
    unittest.main()
