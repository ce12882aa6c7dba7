"""What ./run bench navigation measures at length, as limits: the synthetic robot as received and the recorded drive."""
import pathlib
import tempfile
import unittest

import navigation_score as score


class SyntheticRobot(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.outcome = score.navigate(*score.sim_arguments("--use-arrival-times"))
        cls.errors = score.SimErrors(cls.outcome.trajectory)

    def test_position(self):
        north, east, down = self.errors.clean_position_rms()
        self.assertLess(max(north, east), 0.012)
        self.assertLess(down, 0.018)

    def test_attitude(self):
        roll, pitch, yaw = self.errors.clean_attitude_rms()
        self.assertLess(max(roll, pitch), 0.11)
        self.assertLess(yaw, 0.40)

    def test_outages_with_wheels(self):
        for length_s, limit_m in ((10, 0.20), (30, 0.50), (60, 0.90)):
            with self.subTest(length_s):
                self.assertLess(self.errors.worst_outage(length_s), limit_m)

    def test_wrong_fixes_are_not_followed(self):
        self.assertLess(self.errors.worst_wrong_fix(), 0.30)
        self.assertLess(self.errors.after_wrong_fix(), 0.05)
        self.assertEqual(self.outcome.summary["wrong_fix_episodes"], 2)
        self.assertEqual(self.outcome.summary["resets"], 0)

    def test_float(self):
        self.assertLess(max(self.errors.float_rms()[:2]), 0.12)

    def test_everything_late_was_fused(self):
        self.assertGreater(self.outcome.summary["late_fused"], 10000)
        self.assertEqual(self.outcome.summary["too_late"], 0)


class RecordedDrive(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        with tempfile.TemporaryDirectory(prefix="kawara-") as folder:
            hold_out = score.every_other_fixed_epoch(pathlib.Path(folder) / "holdout.csv")
            cls.summary = score.navigate(*score.drive_arguments("--hold-out", hold_out, "--smooth")).summary

    def test_hold_out(self):
        held = self.summary["real_time"]["held_out_fixed"]
        self.assertGreater(held["n"], 1000)
        for axis, limit_m in (("n", 0.022), ("e", 0.027), ("d", 0.017)):
            with self.subTest(axis):
                self.assertLess(held[f"rms_{axis}_m"], limit_m)

    def test_smoothed_is_better(self):
        real_time, smoothed = (self.summary[k]["held_out_fixed"] for k in ("real_time", "smoothed"))
        for axis in "ned":
            self.assertLess(smoothed[f"rms_{axis}_m"], real_time[f"rms_{axis}_m"])

    def test_the_clocks_offset_is_found(self):
        self.assertAlmostEqual(self.summary["found"]["time_offset_s"]["value"], -0.09, delta=0.03)


if __name__ == "__main__":
    unittest.main()
