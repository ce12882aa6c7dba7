"""The 3rd update on a live bus: a drive's own messages, kawara-mapper with a reference that listens to them, and kawara-station
that hears what it tells."""
import contextlib
import os
import pathlib
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import unittest

from processes import wait_for

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
SOURCE = pathlib.Path(os.environ["KAWARA_SOURCE_DIR"])
SIDE_PX = 512  # of the doughnut: what a truck needs at the least


def must(program, *words):
    done = subprocess.run([BIN / program, *map(str, words)], capture_output=True, text=True, timeout=400)
    assert done.returncode == 0, done.stderr
    return done.stdout


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("lcm-logplayer"), "needs root and Debian's liblcm-bin")
class LiveWatchTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-watch-live-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        scale = SIDE_PX / 1024
        optics = {"width_px": SIDE_PX, "height_px": SIDE_PX, "center_u_px": (SIDE_PX - 1) / 2, "center_v_px": (SIDE_PX - 1) / 2,
                  "l_in_px": 120 * scale, "l_base_px": 262.5 * scale, "l_out_px": 500 * scale}
        settings = [f"picture.doughnut.{key}={value}" for key, value in optics.items()] + [
            "picture.panorama.width_px=800", "picture.preview_width_px=128", "schedule.every_m=0.3", "schedule.every_epochs=0"]
        whole, truth = cls.folder / "mission.lcm", cls.folder / "truth"
        must("kawara-sim", "site", "--site", SOURCE / "configs/sites/factory_road.yaml", "--run-dir", truth, "--virtual", whole,
             "--onboard-config", SOURCE / "configs/survey_robot.yaml", "--doughnut-px", SIDE_PX, "--samples", 1, "--light-cell", 5,
             "--light-cache", "", "--duration", 95, *(word for setting in settings for word in ("--onboard-set", setting)))
        # Where the truck and the wagon are passed.
        cls.log = cls.folder / "passing.lcm"
        must("kawara-log", "cut", whole, "--from", 55, "--to", 95, "--out", cls.log)
        cls.reference = cls.folder / "before.kwref"
        must("kawara-reference", "--out", cls.reference, "--buildings", truth / "reference_city.json", "--road",
             truth / "reference_road.geojson", "--road-name", "carriageway", "--ground", truth / "reference_ground.asc",
             "--date", "2026-01-01T00:00:00Z")

    def setUp(self):
        holder = subprocess.Popen(["unshare", "-n", "sh", "-c", "ip link set lo up multicast on && "  # noqa: SIM115
                                   "ip route add 224.0.0.0/4 dev lo && echo ready && exec sleep 3600"], stdout=subprocess.PIPE)
        self.addCleanup(holder.stdout.close)
        self.addCleanup(holder.wait)
        self.addCleanup(holder.kill)
        self.assertEqual(holder.stdout.readline(), b"ready\n")
        self.network = ["nsenter", "-t", str(holder.pid), "-n", "env", "LCM_DEFAULT_URL=udpm://239.255.76.67:7667?ttl=0"]

    @contextlib.contextmanager
    def running(self, name, *words):
        """In the network; what it says is said(). Killed at the end, if it has not ended itself."""
        file = self.folder / f"{name}.said"
        with open(file, "w", encoding="utf-8") as out, \
                subprocess.Popen([*self.network, *map(str, words)], stdout=out, stderr=subprocess.STDOUT) as run:
            run.said = file.read_text
            try:
                yield run
            finally:
                run.kill()

    def station(self, store):
        return self.running(store, BIN / "kawara-station", "--store", self.folder / store)

    def mapper(self, out):
        return self.running(out, BIN / "kawara-mapper", "--live", "--priority", "normal", "--out", self.folder / out,
                            "--reference", self.reference, "--step", "0.3")

    def player(self, speed):
        return self.running("player", "lcm-logplayer", f"--speed={speed}", self.log)

    def rows(self, store, query):
        if not (self.folder / store).exists():
            return []
        with contextlib.closing(sqlite3.connect(self.folder / store, timeout=30)) as db:
            try:
                return db.execute(query).fetchall()
            except sqlite3.OperationalError:  # not yet made, or being made
                return []

    def standing(self, store):
        return {uid: row for uid, *row in self.rows(
            store, "SELECT id, revision, length_m, width_m FROM changed_object WHERE t_end IS NULL")}

    def pictured(self, store):
        return {uid for uid, uri in self.rows(store, "SELECT id, texture_uri FROM changed_object WHERE texture_uri IS NOT NULL")
                if (self.folder / uri).stat().st_size > 0}

    def told(self, model):
        """What the mapper's journal says, in a store of its own: that is what everybody should know."""
        store = f"{model}_journal.gpkg"
        (self.folder / store).unlink(missing_ok=True)
        must("kawara-station", "--log", self.folder / model / "changes.lcm", "--store", self.folder / store)
        return store

    def drive(self, speed, tag):
        """One drive past the truck and the wagon. Empty: this machine is too busy for it at this speed."""
        model, store, late = f"model{tag}", f"live{tag}.gpkg", f"late{tag}.gpkg"
        with self.mapper(model) as mapper:
            wait_for(lambda: "waits for pictures" in mapper.said() or mapper.poll() is not None, 60, "a mapper that listens")
            with self.station(store) as station:
                wait_for(lambda: (self.folder / store).exists() or station.poll() is not None, 60, "a station")
                with self.player(speed) as player:
                    # An object is in the store while the robot still drives.
                    wait_for(lambda: self.standing(store) or player.poll() is not None, 300, "an object")
                    early = player.poll() is None
                    player.wait(300)
                self.assertIsNone(mapper.poll(), mapper.said())
                # The robot stands. Who was not there hears of all that stands, pictures and all, from what is said again.
                with self.station(late) as other:
                    wait_for(lambda: self.standing(late) == self.standing(store) and len(self.pictured(late)) >= 2 or
                             mapper.poll() is not None, 200, "what was said before")
                    self.assertIsNone(mapper.poll(), mapper.said())
                    mapper.send_signal(signal.SIGTERM)
                    mapper.wait(120)
                    self.assertEqual(mapper.returncode, 0, mapper.said())
                    journal = self.told(model)
                    with contextlib.suppress(TimeoutError):
                        wait_for(lambda: self.standing(store) == self.standing(late) == self.standing(journal), 10, "the last word")
                    for run in (station, other):
                        run.send_signal(signal.SIGTERM)
                        run.wait(60)
                        self.assertEqual(run.returncode, 0, run.said())
        if "left out" in mapper.said() or not early or any(self.standing(s) != self.standing(journal) for s in (store, late)):
            return None
        return mapper.said(), store, late, journal

    def test_objects_of_a_live_mapper_reach_live_stations(self):
        for tag, speed in enumerate((2.0, 1.0, 0.5)):
            done = self.drive(speed, tag)
            if done:
                break
        self.assertTrue(done, "objects came late, or not all, at any speed")
        said, store, late, journal = done
        stand = self.standing(store)
        self.assertEqual(int(re.search(r"(\d+) changed objects stand", said)[1]), len(stand))
        sizes = sorted(((length, width) for _, length, width in stand.values()), reverse=True)
        self.assertAlmostEqual(sizes[0][0], 6.1, delta=0.5)   # truck
        self.assertAlmostEqual(sizes[0][1], 2.16, delta=0.4)
        self.assertAlmostEqual(sizes[1][0], 4.79, delta=0.5)  # wagon
        self.assertAlmostEqual(sizes[1][1], 1.96, delta=0.4)
        for heard in (store, late):
            self.assertGreaterEqual(len(self.pictured(heard)), 2)
            self.assertLessEqual(self.pictured(heard), self.pictured(journal))
        self.assertGreater(self.rows(store, "SELECT count(*) FROM road_station")[0][0], 50)
        # Who was there from the beginning has the history that the mapper's journal tells.
        history = "SELECT id, revision, state, begin_ns, end_ns, ended_as FROM changed_object ORDER BY id, revision"
        self.assertEqual(self.rows(store, history), self.rows(journal, history))


if __name__ == "__main__":
    unittest.main()
