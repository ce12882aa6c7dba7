"""The 3rd update while the model grows, whole: a street rendered on two days, kawara-mapper with a reference, kawara-station."""
import contextlib
import csv
import os
import pathlib
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import tempfile
import time
import unittest

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
SOURCE = pathlib.Path(os.environ["KAWARA_SOURCE_DIR"])
HOUR_NS = 3600 * 10**9


def run(program, *words):
    return subprocess.run([BIN / program, *map(str, words)], capture_output=True, text=True, timeout=300)


def must(program, *words):
    done = run(program, *words)
    assert done.returncode == 0, done.stderr
    return done


def later(poses):
    """An hour after the simulator's own time."""
    with open(poses, newline="", encoding="ascii") as file:
        rows = list(csv.reader(file))
    at = rows[0].index("gps_ns")
    for row in rows[1:]:
        row[at] = str(int(row[at]) + HOUR_NS)
    with open(poses, "w", newline="", encoding="ascii") as file:
        csv.writer(file, lineterminator="\n").writerows(rows)


class WatchTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-watch-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        site = SOURCE / "configs/sites/factory_road.yaml"
        without = cls.folder / "wagon_left.yaml"
        lines = site.read_text().splitlines(keepends=True)
        without.write_text("".join(line for line in lines if "name: wagon" not in line))
        for day, (place, seed) in {"monday": (site, 1), "tuesday": (without, 2)}.items():
            must("kawara-sim", "--render", cls.folder / day, "--site", place, "--seed", seed, "--doughnut-px", "512", "--every",
                 "0.34", "--start", "54", "--duration", "38", "--light-cell", "5", "--light-cache", "", "--no-body")
        later(cls.folder / "tuesday/poses.csv")
        monday = cls.folder / "monday"
        cls.reference = cls.folder / "before.kwref"
        must("kawara-reference", "--out", cls.reference, "--buildings", monday / "reference_city.json", "--road",
             monday / "reference_road.geojson", "--road-name", "carriageway", "--ground", monday / "reference_ground.asc",
             "--date", "2026-01-01T00:00:00Z")
        cls.said = cls.watch("monday", "model").stdout
        cls.watch("tuesday", "model_2", "--known", cls.folder / "model/changes.lcm")

    @classmethod
    def watch(cls, survey, model, *words):
        return must("kawara-mapper", cls.folder / survey, "--out", cls.folder / model, "--reference", cls.reference, "--step",
                    "0.3", *words)

    def station(self, store, *models):
        logs = [word for model in models for word in ("--log", self.folder / model / "changes.lcm")]
        return must("kawara-station", *logs, "--store", self.folder / store).stdout

    def rows(self, store, query):
        with contextlib.closing(sqlite3.connect(self.folder / store)) as db:
            return db.execute(query).fetchall()

    def standing(self, store):
        return {uid: (length, width) for uid, length, width in
                self.rows(store, "SELECT id, length_m, width_m FROM changed_object WHERE t_end IS NULL")}

    def test_truck_and_wagon_reach_the_store_with_pictures_and_the_road_they_leave(self):
        self.assertRegex(self.said, r"\d+ changed objects stand")
        said = self.station("one.gpkg", "model")
        self.assertRegex(said, r"[1-9]\d* revisions of changed objects, [1-9]\d* with pictures of their sides, and [1-9]\d* road")
        sizes = sorted(self.standing("one.gpkg").values(), reverse=True)
        self.assertAlmostEqual(sizes[0][0], 6.1, delta=0.5)   # truck
        self.assertAlmostEqual(sizes[0][1], 2.16, delta=0.4)
        self.assertAlmostEqual(sizes[1][0], 4.79, delta=0.5)  # wagon
        self.assertAlmostEqual(sizes[1][1], 1.96, delta=0.4)
        self.assertLessEqual(len(sizes), 5)  # and what fell on the road
        for uid, length, uri in self.rows("one.gpkg", "SELECT id, length_m, texture_uri FROM changed_object WHERE t_end IS NULL"):
            if length > 3:
                self.assertEqual((self.folder / uri).read_bytes()[:3], b"\xff\xd8\xff", uid)
        narrow, = self.rows("one.gpkg", "SELECT min(passable_m) FROM road_station WHERE t_end IS NULL")[0]
        wide, = self.rows("one.gpkg", "SELECT max(passable_m) FROM road_station WHERE t_end IS NULL")[0]
        self.assertLess(narrow, wide - 1.5)

    def test_a_second_mission_closes_only_what_has_left(self):
        self.station("two.gpkg", "model")
        before = self.standing("two.gpkg")
        self.station("two.gpkg", "model_2")
        after = self.standing("two.gpkg")
        wagon, = (uid for uid, (length, _) in before.items() if 4.2 < length < 5.3)
        truck, = (uid for uid, (length, _) in before.items() if length > 5.3)
        self.assertNotIn(wagon, after)
        self.assertLessEqual(set(before) - {wagon}, set(after))
        self.assertAlmostEqual(after[truck][0], 6.1, delta=0.5)
        self.assertEqual(self.rows("two.gpkg", f"SELECT ended_as FROM changed_object WHERE id = '{wagon}' AND ended_as = 'gone'"),
                         [("gone",)])
        # The same history from both logs at once.
        self.station("both.gpkg", "model", "model_2")
        history = "SELECT id, revision, state, begin_ns, end_ns, ended_as FROM changed_object ORDER BY id, revision"
        self.assertEqual(self.rows("two.gpkg", history), self.rows("both.gpkg", history))
        # Told again, nothing changes.
        self.station("two.gpkg", "model", "model_2")
        self.assertEqual(self.rows("two.gpkg", history), self.rows("both.gpkg", history))

    def test_killed_at_any_moment_the_objects_keep_their_uids(self):
        out = self.folder / "killed"
        words = [BIN / "kawara-mapper", self.folder / "monday", "--out", out, "--reference", self.reference, "--step", "0.3"]
        dice = random.Random(5)
        kills = 0
        for _ in range(6):
            with subprocess.Popen(list(map(str, words)), stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL) as mapper:
                try:
                    mapper.wait(dice.uniform(1.5, 5.0))
                except subprocess.TimeoutExpired:
                    mapper.kill()
                    kills += 1
        self.watch("monday", "killed")
        self.station("killed.gpkg", "killed")
        self.station("whole.gpkg", "model")
        whole, killed = self.standing("whole.gpkg"), self.standing("killed.gpkg")
        self.assertEqual(len(killed), len(whole), (kills, killed, whole))
        for mine, theirs in zip(sorted(killed.values()), sorted(whole.values())):
            self.assertAlmostEqual(mine[0], theirs[0], delta=0.5)
        revisions = self.rows("killed.gpkg", "SELECT id, count(*), max(revision) FROM changed_object GROUP BY id")
        for uid, rows, newest in revisions:
            self.assertEqual(rows, newest, uid)  # no revision was left out or told twice

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("lcm-logplayer"), "needs root and Debian's liblcm-bin")
    def test_station_killed_while_objects_come_loses_nothing_it_has_shown(self):
        store = self.folder / "live.gpkg"
        with subprocess.Popen(["unshare", "-n", "sh", "-c", "ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && "
                               "echo ready && exec sleep 3600"], stdout=subprocess.PIPE) as holder:
            try:
                self.assertEqual(holder.stdout.readline(), b"ready\n")
                network = ["nsenter", "-t", str(holder.pid), "-n", "env", "LCM_DEFAULT_URL=udpm://239.255.76.67:7667?ttl=0"]
                shown = 0
                for speed in (8.0, 8.0, 20.0):
                    with subprocess.Popen([*network, BIN / "kawara-station", "--store", store], stdout=subprocess.DEVNULL,
                                          stderr=subprocess.DEVNULL) as station:
                        time.sleep(1.0)
                        subprocess.run([*network, "lcm-logplayer", f"--speed={speed}", self.folder / "model/changes.lcm"],
                                       check=True, stdout=subprocess.DEVNULL, timeout=120)
                        if speed < 10.0:
                            station.kill()
                        else:
                            time.sleep(1.0)
                            station.send_signal(signal.SIGTERM)
                        station.wait(60)
                    count, = self.rows("live.gpkg", "SELECT count(*) FROM changed_object")[0]
                    self.assertGreaterEqual(count, shown)
                    shown = count
            finally:
                holder.kill()
        self.station("log.gpkg", "model")
        self.assertEqual(self.standing("live.gpkg"), self.standing("log.gpkg"))
        files = self.rows("live.gpkg", "SELECT texture_uri FROM changed_object WHERE texture_uri IS NOT NULL")
        self.assertTrue(files)
        for uri, in files:
            self.assertGreater((self.folder / uri).stat().st_size, 0)

    def test_mistakes_are_answered_in_one_line(self):
        bad = self.folder / "bad.kwref"
        bad.write_bytes(b"not a reference")
        elsewhere = self.folder / "elsewhere.kwref"
        monday = self.folder / "monday"
        must("kawara-reference", "--out", elsewhere, "--road", monday / "reference_road.geojson", "--origin", "35,139,0")
        roadless = self.folder / "roadless.kwref"
        must("kawara-reference", "--out", roadless, "--buildings", monday / "reference_city.json")
        for words, said in (
                (("--reference", self.folder / "none.kwref"), "none.kwref"),
                (("--reference", bad), "bad.kwref"),
                (("--reference", roadless), "no road to look at"),
                (("--reference", self.reference, "--known", self.folder / "none.lcm"), "none.lcm"),
                (("--reference", elsewhere), "make the reference with --origin")):
            with self.subTest(words=words):
                out = self.folder / ("model" if elsewhere in words else "mistakes")
                done = run("kawara-mapper", monday, "--out", out, *words)
                self.assertIn(done.returncode, (1, 2), done.stderr)
                self.assertIn(said, done.stderr)
                self.assertEqual(len(re.findall("^kawara-mapper: ", done.stderr, re.M)), 1, done.stderr)


if __name__ == "__main__":
    unittest.main()
