"""The whole chain as processes: simulated instruments on pseudo-terminals -> kawara-onboard -> LCM -> kawara-station."""
import csv
import os
import pathlib
import shutil
import signal
import sqlite3
import tempfile
import time
import unittest

from processes import SOURCE, Processes, run, wait_for

DRIVE = SOURCE / "data/drive_0708"
PANORAMA = SOURCE / "data/panorama/R0014760_3072.jpg"


class Chain:
    """One run of all three programs in a folder of its own."""

    def __init__(self, folder):
        self.folder = pathlib.Path(folder)
        (self.folder / "live").mkdir()
        self.ports = self.folder / "ports"
        # A bus of its own, should tests run side by side outside of a namespace.
        self.url = f"udpm://239.255.76.67:{7700 + os.getpid() % 2000}?ttl=0"
        self.processes = Processes(self.folder / "output")

    def start_sim(self, seconds, *extra, start=100):
        self.processes.start("sim", "kawara-sim", "drive", "--data", DRIVE, "--panorama", PANORAMA, "--run-dir", self.ports,
                             "--start", start, "--duration", seconds, "--doughnut-px", 1024, *extra)
        wait_for(lambda: (self.ports / "ready").exists(), 60, "the simulator's ports")

    def start_station(self):
        self.processes.start("station", "kawara-station", "--config", SOURCE / "configs/station.yaml", "--lcm-url", self.url,
                             "--store", self.folder / "live/mission.gpkg", "--latency", self.folder / "latency.csv")
        time.sleep(1)

    def onboard_args(self, **settings):
        values = {"gps.device": self.ports / "gps", "ahrs.device": self.ports / "ahrs", "camera.path": self.ports / "camera.sock",
                  "record.folder": self.folder / "log", "lcm_url": self.url,
                  # the small doughnut of start_sim
                  "picture.doughnut.width_px": 1024, "picture.doughnut.height_px": 1024, "picture.doughnut.center_u_px": 511.5,
                  "picture.doughnut.center_v_px": 511.5, "picture.doughnut.l_in_px": 120, "picture.doughnut.l_base_px": 262.5,
                  "picture.doughnut.l_out_px": 500, "picture.panorama.width_px": 1200, **settings}
        args = ["--config", SOURCE / "configs/demo.yaml"]
        for key, value in values.items():
            args += ["--set", f"{key}={value}"]
        return args

    def start_onboard(self, name="onboard", **settings):
        self.processes.start(name, "kawara-onboard", *self.onboard_args(**settings))

    def finish(self, seconds):
        """Waits for the drive to end, then stops everything in the order of the data flow; exit codes by name."""
        self.processes.wait("sim", seconds + 60)
        time.sleep(2)
        return {name: self.processes.stop(name) for name in ("onboard", "station", "sim") if name in self.processes.running}

    def log(self):
        return sorted((self.folder / "log").iterdir())[-1]

    def replay(self, name):
        """The messages of the robot once more, from its log alone."""
        out = self.folder / f"{name}.lcm"
        run("kawara-onboard", "--log", self.log(), "--out", out, check=True)
        return out

    def store_log(self, log, store):
        (self.folder / store).parent.mkdir()
        run("kawara-station", "--config", SOURCE / "configs/station.yaml", "--log", log, "--store", self.folder / store, check=True)

    def events(self):
        rows = self.query("select name, text from event_log")
        return [f"{name}: {text}" for name, text in rows]

    def query(self, sql, store="live/mission.gpkg"):
        with sqlite3.connect(self.folder / store) as db:
            return db.execute(sql).fetchall()

    def pictures(self):
        return self.query("select epoch, stage, gps_ns from obs_panorama order by epoch")

    def dump(self, store):
        return run("kawara-station", "--dump", self.folder / store, check=True).stdout


class ChainTest(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="kawara-chain-")
        self.chain = Chain(self.folder)

    def tearDown(self):
        self.chain.processes.stop_all()
        failed = any(e for _, e in getattr(getattr(self, "_outcome", None), "errors", []) if e)
        if failed:
            for file in (pathlib.Path(self.folder) / "output").glob("*.out"):
                print(f"--- {file.name}\n{file.read_text(errors='replace')[-3000:]}")
        shutil.rmtree(self.folder, ignore_errors=True)

    def test_a_drive_arrives_and_comes_again_from_the_log(self):
        self.chain.start_station()
        self.chain.start_sim(20)
        self.chain.start_onboard()
        codes = self.chain.finish(20)
        self.assertEqual(set(codes.values()), {0}, codes)

        pictures = self.chain.pictures()
        self.assertGreaterEqual(len(pictures), 8, self.chain.events())
        self.assertEqual([p[0] for p in pictures], list(range(1, len(pictures) + 1)), "epochs have no gap")

        # Every picture was taken at one of the receiver's epochs, and its time is right.
        with open(self.chain.ports / "truth_exposures.csv", newline="") as file:
            truth = [int(row["gps_ns"]) for row in csv.DictReader(file)]
        # (One taken before there was a time line bears the computer's time, and no place.)
        placed = self.chain.query("select epoch, gps_ns from obs_panorama where geom is not null")
        self.assertGreaterEqual(len(placed), 8, self.chain.events())
        for epoch, gps_ns in placed:
            error_ms = min(abs(gps_ns - t) for t in truth) / 1e6
            self.assertLess(error_ms, 60, f"picture {epoch}")

        # The same from the log alone, twice: through the onboard program and the station.
        once, again = (self.chain.replay(name) for name in ("replay1", "replay2"))
        self.assertEqual(once.read_bytes(), again.read_bytes())
        for store, log in (("replay/mission.gpkg", once), ("direct/mission.gpkg", self.chain.log())):
            self.chain.store_log(log, store)
            self.assertEqual(self.chain.dump("live/mission.gpkg"), self.chain.dump(store), store)

    def test_unplugged_receiver_comes_back_by_itself(self):
        self.chain.start_station()
        self.chain.start_sim(30, "--fault", "t=10 gps.unplug 4s")
        self.chain.start_onboard()
        codes = self.chain.finish(30)
        self.assertEqual(set(codes.values()), {0}, codes)
        events = "\n".join(self.chain.events())
        self.assertRegex(events, r"gps\.port: .*(gone|lost|unplugged|hung up)")
        times = [row[0] for row in self.chain.query("select gps_ns from obs_pose order by gps_ns")]
        self.assertGreater((times[-1] - times[0]) / 1e9, 20, "positions before and after the gap")
        # Pictures went on at the receiver's epochs, carried by the clock alone (a busy machine may miss one, not four).
        gaps = [b[2] - a[2] for a, b in zip(self.chain.pictures(), self.chain.pictures()[1:])]
        self.assertLess(max(gaps) / 1e9, 3.5, events)

    def test_receiver_without_a_fix_still_gives_pictures(self):
        self.chain.start_station()
        self.chain.start_sim(25, "--fault", "t=0 gps.nofix 60s")
        self.chain.start_onboard()
        codes = self.chain.finish(25)
        self.assertEqual(set(codes.values()), {0}, codes)
        rows = self.chain.query("select epoch, geom is null from obs_panorama")
        self.assertGreater(len(rows), 3, self.chain.events())
        self.assertTrue(all(no_place for _, no_place in rows), "no place is better than a wrong one")

    def test_killed_onboard_loses_nothing_recorded(self):
        self.chain.start_sim(30)
        self.chain.start_onboard("first")
        time.sleep(12)
        self.chain.processes.stop("first", sig=signal.SIGKILL)
        done = run("kawara-log", "info", "--json", self.chain.log())
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("RAW.GPS", done.stdout)
        # and a second start finds the instruments still streaming from the first
        self.chain.start_onboard("second")
        time.sleep(10)
        self.assertEqual(self.chain.processes.stop("second"), 0)
        self.assertIn("fixes", self.chain.processes.output("second"))
        self.assertNotIn(" 0 fixes", self.chain.processes.output("second"))
        self.assertNotIn(" 0 AHRS packets", self.chain.processes.output("second"))

    def test_what_the_recorder_has_to_tell_is_heard_at_the_station_and_again_from_the_log(self):
        if shutil.disk_usage(self.folder).free > 1e12:
            self.skipTest("this disk is never low: the largest record.disk_reserve_mb is less than what is free")
        self.chain.start_station()
        self.chain.start_onboard(**{"record.disk_reserve_mb": 1048576})
        wait_for(lambda: (self.chain.folder / "log").exists(), 20, "the robot's log")
        time.sleep(3)
        self.assertEqual(self.chain.processes.stop("onboard"), 0)
        self.assertEqual(self.chain.processes.stop("station"), 0)
        self.assertRegex("\n".join(self.chain.events()), r"recorder\.pictures_paused: ")
        self.chain.store_log(self.chain.replay("replay"), "replay/mission.gpkg")
        self.assertEqual(self.chain.dump("live/mission.gpkg"), self.chain.dump("replay/mission.gpkg"))


class StartTest(unittest.TestCase):
    """What a user meets on the first day: one clear line each, exit code 2."""

    def complaint(self, *args):
        done = run("kawara-onboard", *args)
        self.assertEqual(done.returncode, 2, done.stderr)
        return done.stderr

    def test_no_arguments(self):
        self.assertIn("--config", self.complaint())

    def test_missing_configuration(self):
        self.assertIn("nowhere.yaml", self.complaint("--config", "nowhere.yaml"))

    def test_every_mistake_of_a_configuration_at_once(self):
        text = (SOURCE / "configs/demo.yaml").read_text()
        with tempfile.NamedTemporaryFile("w", suffix=".yaml") as file:
            file.write(text.replace("baud_bps: 115200", "baud_bps: 115201").replace("model: 100", "modell: 100"))
            file.flush()
            complaint = self.complaint("--config", file.name)
        self.assertRegex(complaint, r":\d+:\d+: gps\.baud_bps = 115201: expected")
        self.assertRegex(complaint, r"ahrs\.modell")
        self.assertRegex(complaint, r"ahrs\.model\b")

    def test_missing_and_foreign_logs(self):
        self.assertIn("nothing-here", self.complaint("--log", "nothing-here", "--out", "/tmp/never.lcm"))
        self.assertIn("README.md", self.complaint("--log", SOURCE / "README.md", "--out", "/tmp/never.lcm"))

    def test_log_folder_that_cannot_be_made(self):
        complaint = self.complaint("--config", SOURCE / "configs/demo.yaml", "--set", "record.folder=/proc/log", "--duration", "1")
        self.assertIn("/proc/log", complaint)


if __name__ == "__main__":
    unittest.main()
