"""kawara-log as a user meets it: what it prints, what it writes, how it fails."""
import csv
import json
import os
import pathlib
import subprocess
import tempfile
import unittest

import lcm_log

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
TYPES = pathlib.Path(os.environ["KAWARA_SOURCE_DIR"]) / "comms" / "lcmtypes"
START_US = 1_783_492_200_000_000  # 2026-07-08T06:30:00Z


def run(*arguments):
    return subprocess.run([BIN / "kawara-log", *map(str, arguments)], capture_output=True, text=True, timeout=60)


def type_of(name):
    return lcm_log.Type((TYPES / f"{name}.lcm").read_text())


def pose(i):
    return type_of("pose_t").encode(gps_ns=i, lat_deg=35.0 + i * 1e-6, velocity_enu_mps=[i, 0.5, -1])


class LogTool(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.log = self.folder / "a.lcmlog"
        events = [(START_US, "CONFIG", type_of("config_t").encode(program="test", version="1", yaml="a: 1"))]
        for i in range(100):
            gap = 500_000 if i >= 60 else 0  # half a second is missing
            events.append((START_US + i * 10_000 + gap, "POSE", pose(i)))
        events.append((START_US + 900_000, "COUNTERS", type_of("counters_t").encode(
            program="p", n=2, name=["a", 'b, "c"'], value=[1, -2])))
        events.append((START_US + 910_000, "COUNTERS", type_of("counters_t").encode(program="p", n=1, name=["a"], value=[3])))
        events.append((START_US + 920_000, "FRAME", type_of("frame_t").encode(
            sequence=7, format=3, width=3, height=2, n=6, data=[1, 2, 3, 4, 5, 6])))
        self.events = events
        self.blob = b"".join(lcm_log.record(n, *event) for n, event in enumerate(events))
        self.log.write_bytes(self.blob)

    def damage(self):
        """One bit in the length of the 31st event."""
        at = sum(len(lcm_log.record(0, *event)) for event in self.events[:30])
        blob = bytearray(self.blob)
        blob[at + 27] ^= 1
        self.log.write_bytes(blob)

    def test_info(self):
        result = run("info", self.log)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("program   test 1", result.stdout)
        self.assertIn("2026-07-08T06:30:00.000000Z", result.stdout)
        self.assertRegex(result.stdout, r"POSE +pose_t +100 ")
        self.assertIn("damage: none", result.stdout)
        self.assertEqual(result.stderr, "")

    def test_info_json(self):
        info = json.loads(run("info", "--json", self.log).stdout)
        pose_channel = info["channels"]["POSE"]
        self.assertEqual(info["events"], 104)
        self.assertEqual(pose_channel["count"], 100)
        self.assertAlmostEqual(pose_channel["median_period_s"], 0.01, delta=0.0001)
        self.assertAlmostEqual(pose_channel["largest_gap_s"], 0.51, places=6)
        self.assertEqual(pose_channel["gaps_over_3_periods"], 1)
        self.assertAlmostEqual(pose_channel["rate_per_s"], 99 / 1.49, places=4)
        self.assertEqual(pose_channel["bytes"], 100 * len(pose(0)))
        self.assertEqual(info["damage"]["places"], 0)

    def test_check(self):
        result = run("check", self.log)
        self.assertEqual(result.returncode, 0, result.stdout)
        self.damage()
        result = run("check", self.log)
        self.assertEqual(result.returncode, 1)
        self.assertIn("damage: 1 place(s)", result.stdout)

    def test_check_finds_messages_that_are_none(self):
        self.log.write_bytes(self.blob + lcm_log.record(104, START_US, "POSE", pose(1)[:-1]))
        result = run("check", self.log)
        self.assertEqual(result.returncode, 1)
        self.assertIn("POSE: 1 messages are no", result.stdout)

    def test_cut_by_seconds(self):
        out = self.folder / "cut.lcmlog"
        result = run("cut", self.log, "--from", "0.1", "--to", "0.2", "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        cut = [(t, c, d) for _, t, c, d in lcm_log.records(out.read_bytes()) if c != "LOG.CRC"]
        self.assertEqual(cut, [self.events[0]] + self.events[11:21])

    def test_cut_by_utc_and_channel(self):
        out = self.folder / "cut.lcmlog"
        result = run("cut", self.log, "--from", "2026-07-08T06:30:00.905Z", "--include", "COUNT.*|FRAME",
                     "--exclude", "FRAME", "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        channels = [c for _, _, c, _ in lcm_log.records(out.read_bytes())]
        self.assertEqual(channels, ["CONFIG", "COUNTERS", "LOG.CRC"])

    def test_cut_leaves_damage_out(self):
        self.damage()
        out = self.folder / "cut.lcmlog"
        result = run("cut", self.log, "--out", out)
        self.assertEqual(result.returncode, 0, result.stderr)
        self.assertIn("damage: 1 place(s)", result.stdout)
        self.assertEqual(run("check", out).returncode, 0)
        self.assertEqual(json.loads(run("info", "--json", out).stdout)["channels"]["POSE"]["count"], 99)

    def test_cut_never_overwrites(self):
        result = run("cut", self.log, "--out", self.log)
        self.assertEqual(result.returncode, 2)
        self.assertIn("exists already", result.stderr)
        self.assertEqual(self.log.read_bytes(), self.blob)

    def export(self, channel, *more):
        out = self.folder / "out.csv"
        result = run("export", self.log, "--channel", channel, "--out", out, *more)
        self.assertEqual(result.returncode, 0, result.stderr)
        with open(out, newline="") as file:
            return list(csv.DictReader(file))

    def test_export_every_field(self):
        rows = self.export("POSE")
        self.assertEqual(len(rows), 100)
        self.assertEqual(rows[5]["gps_ns"], "5")
        self.assertEqual(float(rows[5]["lat_deg"]), 35.0 + 5 * 1e-6)
        self.assertEqual([rows[5][f"velocity_enu_mps[{k}]"] for k in range(3)], ["5", "0.5", "-1"])
        self.assertEqual(rows[5]["recorded_utc"], "2026-07-08T06:30:00.050000Z")

    def test_export_arrays_of_different_length(self):
        rows = self.export("COUNTERS")
        self.assertEqual(rows[0]["name[1]"], 'b, "c"')
        self.assertEqual(rows[0]["value[1]"], "-2")
        self.assertEqual((rows[1]["name[0]"], rows[1]["name[1]"], rows[1]["value[0]"]), ("a", "", "3"))

    def test_export_pictures(self):
        rows = self.export("FRAME", "--pictures", self.folder / "pictures")
        self.assertEqual(rows[0]["data"], "frame-000007.pgm")
        self.assertEqual((self.folder / "pictures" / "frame-000007.pgm").read_bytes(), b"P5 3 2 255\n\1\2\3\4\5\6")

    def test_types_from_the_logs_own_config(self):
        """A message type this program has never heard of."""
        text = "package old;\nstruct wind_t\n{\n    int64_t mono_ns;\n    double speed_mps;\n}\n"
        config = type_of("config_t").encode(program="old", lcmtypes=text)
        message = lcm_log.Type(text).encode(mono_ns=3, speed_mps=7.5)
        self.log.write_bytes(lcm_log.record(0, START_US, "CONFIG", config) + lcm_log.record(1, START_US, "WIND", message))
        self.assertEqual(self.export("WIND")[0]["speed_mps"], "7.5")

    def test_folder(self):
        self.assertEqual(json.loads(run("info", "--json", self.folder).stdout)["events"], 104)

    def test_one_line_for_every_mistake(self):
        mistakes = [
            (["info", self.folder / "missing"], "No such file"),
            (["info", "/dev/null"], "not a regular file"),
            (["info", TYPES / "pose_t.lcm"], "not an LCM log"),
            (["info", TYPES], "no LCM log in this folder"),
            (["cut", self.log, "--from", "noon", "--out", self.folder / "x"], "'noon' is neither"),
            (["cut", self.log, "--include", "([", "--out", self.folder / "x"], "not a regular expression"),
            (["cut", self.log, "--out", self.folder / "no" / "x"], "No such file"),
            (["export", self.log, "--channel", "NOPE", "--out", "-"], "no messages on channel 'NOPE'"),
            (["export", self.log, "--channel", "POSE", "--out", "-", "--pictures", "p"], "there are none in pose_t"),
            (["export", self.log, "--channel", "POSE", "--out", "/dev/full"], "No space left"),
            (["shred", self.log], ""),
            ([], ""),
        ]
        for arguments, expected in mistakes:
            with self.subTest(arguments):
                result = run(*arguments)
                self.assertEqual(result.returncode, 2)
                self.assertIn(expected, result.stderr)
                self.assertEqual(result.stderr.count("\n"), 1, result.stderr)
                self.assertTrue(result.stderr.startswith("kawara-log: "))


if __name__ == "__main__":
    unittest.main()
