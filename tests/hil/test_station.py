"""kawara-station as a program: live from LCM in a network namespace of its own, from a log, on a bad disk."""
import csv
import os
import pathlib
import resource
import signal
import sqlite3
import subprocess
import sys
import tempfile
import time
import unittest

import mission_packets

BIN = os.path.join(os.environ["KAWARA_BIN"], "kawara-station")
NAMESPACE = "_KAWARA_TEST_NAMESPACE"


def in_own_network(test_id):
    """Runs this test again inside its own network namespace, where multicast goes over loopback."""
    script = ("ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && "
              "exec /usr/bin/python3 -B -m unittest %s" % test_id)
    return subprocess.run(["unshare", "-n", "sh", "-c", script], env=dict(os.environ, **{NAMESPACE: "1"}),
                          cwd=os.path.dirname(os.path.abspath(__file__)), capture_output=True, text=True, timeout=300)


def own_network(method):
    def wrapper(self):
        if os.environ.get(NAMESPACE):
            return method(self)
        probe = subprocess.run(["unshare", "-n", "true"], capture_output=True)
        if probe.returncode != 0:
            self.skipTest("no right to make a network namespace (unshare -n)")
        done = in_own_network("test_station.%s.%s" % (type(self).__name__, method.__name__))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
    wrapper.__name__ = method.__name__
    return wrapper


def dump(store, pictures=None):
    command = [BIN, "--dump", str(store)] + (["--pictures", str(pictures)] if pictures else [])
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return done.stdout


def rows(store, sql):
    connection = sqlite3.connect("file:%s?mode=ro" % store, uri=True)
    try:
        return connection.execute(sql).fetchall()
    finally:
        connection.close()


def wait_for(condition, seconds=30):
    deadline = time.monotonic() + seconds
    while time.monotonic() < deadline:
        if condition():
            return True
        time.sleep(0.02)
    return False


def count(store, table):
    try:
        return rows(store, "select count(*) from " + table)[0][0]
    except sqlite3.OperationalError:
        return -1


class StationCase(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.mission = mission_packets.Mission(pictures=12)

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="kawara-station-")
        self.addCleanup(self.temporary.cleanup)
        self.folder = pathlib.Path(self.temporary.name)

    def write_log(self):
        path = self.folder / "mission.log"
        if not path.exists():
            self.mission.write_log(path)
        return path

    def run_log(self, store, *more, **kwargs):
        return subprocess.run([BIN, "--log", str(self.write_log()), "--store", str(store), *map(str, more)],
                              capture_output=True, text=True, timeout=120, **kwargs)

    def start(self, *arguments, **kwargs):
        process = subprocess.Popen([BIN, *map(str, arguments)], stdout=subprocess.PIPE, stderr=subprocess.PIPE,
                                   text=True, **kwargs)
        self.addCleanup(self.end, process)
        return process

    @staticmethod
    def end(process):
        if process.poll() is None:
            process.kill()
        process.communicate()


class FromLog(StationCase):
    def test_a_log_fills_the_store_and_says_so_in_one_line(self):
        done = self.run_log(self.folder / "store.gpkg")
        self.assertEqual((done.returncode, done.stderr), (0, ""))
        self.assertIn("12 pictures (12 full and 12 preview packets)", done.stdout)
        self.assertIn("pictures missing 0, late 0; packets repeated 0, refused 0, dropped 0", done.stdout)
        self.assertEqual(done.stdout.count("\n"), 1)
        store = self.folder / "store.gpkg"
        self.assertEqual([count(store, t) for t in ("obs_panorama", "obs_pose", "trajectory", "event_log")],
                         [12, 12 + 12, 1, 2])
        for (uri, size) in rows(store, "select uri, jpeg_bytes from obs_panorama"):
            self.assertEqual((self.folder / uri).stat().st_size, size)

    def test_the_same_log_twice_is_the_same_store(self):
        for name in ("a", "b"):
            self.assertEqual(self.run_log(self.folder / name / "store.gpkg").returncode, 0)
        again = self.run_log(self.folder / "b/store.gpkg")
        self.assertIn("0 pictures (12 full and 12 preview packets), 0 poses", again.stdout)
        self.assertEqual(dump(self.folder / "a/store.gpkg"), dump(self.folder / "b/store.gpkg"))

    def test_the_poses_that_came_before_the_first_picture_are_kept(self):
        self.run_log(self.folder / "store.gpkg")
        first = rows(self.folder / "store.gpkg", "select min(gps_ns), mission from obs_pose")[0]
        self.assertLess(first[0], mission_packets.GPS_START_NS + 1_000_000_000 * 2)
        self.assertEqual(first[1], mission_packets.MISSION)

    def test_a_map_is_drawn(self):
        from PIL import Image
        self.assertEqual(self.run_log(self.folder / "store.gpkg", "--map", self.folder / "map.png").returncode, 0)
        colours = Image.open(self.folder / "map.png").convert("RGB").getcolors(1 << 24)
        shown = {colour: n for n, colour in colours}
        for name, colour in (("fixed", (26, 152, 80)), ("float", (253, 174, 97)), ("picture", (49, 54, 149))):
            self.assertGreater(shown.get(colour, 0), 100, name)

    def test_damage_and_strangers_on_the_channels_are_refused_and_the_rest_is_stored(self):
        path = self.folder / "mission.log"
        with open(path, "wb") as f:
            for n, (t, channel, data) in enumerate(self.mission.messages):
                f.write(mission_packets.log_record(2 * n, n, channel, data))
                for m, bad in enumerate((b"", b"x", data[:-1], data + b"x", data[8:] + data[:8])):
                    if n % 40 == m:
                        f.write(mission_packets.log_record(2 * n + 1, n, channel, bad))
        done = self.run_log(self.folder / "store.gpkg")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stdout, r"refused [1-9]")
        self.assertEqual(count(self.folder / "store.gpkg", "obs_panorama"), 12)

    def test_start_up_mistakes_are_one_line_and_exit_2(self):
        config = self.folder / "bad.yaml"
        config.write_text("store:\n  targt: x.gpkg\npose_rate_hz: -1\n")
        (self.folder / "text.gpkg").write_text("no database, but a little longer than nothing\n" * 40)
        for arguments, expected in (
                (["--config", config, "--log", self.write_log()], "bad.yaml:2:3: store.targt"),
                (["--config", config, "--log", self.write_log()], "bad.yaml:3:15: pose_rate_hz = -1"),
                (["--log", self.folder / "nothing.log", "--store", self.folder / "s.gpkg"], "nothing.log"),
                (["--log", self.write_log(), "--store", self.folder / "text.gpkg"], "not a GeoPackage"),
                (["--log", self.write_log(), "--store", "/proc/x/s.gpkg"], "/proc/x"),
                (["--log", self.write_log(), "--store", "PG:host=127.0.0.1 port=1"], "is the server running?"),
                (["--log", self.write_log(), "--store", self.folder / "s.gpkg", "--latency", "/proc/x"], "/proc/x")):
            with self.subTest(expected):
                done = subprocess.run([BIN, *map(str, arguments)], capture_output=True, text=True, timeout=60,
                                      cwd=self.folder)
                self.assertEqual(done.returncode, 2, done.stderr)
                self.assertIn(expected, done.stderr)

    def test_a_full_disk_is_said_in_one_line_and_what_was_stored_stays(self):
        """A file system of 1.2 MB in a mount namespace of its own; the mission needs more."""
        probe = subprocess.run(["unshare", "-m", "true"], capture_output=True)
        if probe.returncode != 0:
            self.skipTest("no right to mount (unshare -m)")
        disk = self.folder / "disk"
        disk.mkdir()
        script = ("mount -t tmpfs -o size=1200k none {d} && {bin} --log {log} --store {d}/store.gpkg --set give_up_s=1; "
                  "echo exit $?; cp -r {d}/. {keep}/").format(d=disk, bin=BIN, log=self.write_log(),
                                                              keep=self.folder / "kept")
        (self.folder / "kept").mkdir()
        done = subprocess.run(["unshare", "-m", "sh", "-c", script], capture_output=True, text=True, timeout=120)
        self.assertIn("exit 1", done.stdout)
        self.assertIn("NOT STORED", done.stdout)
        self.assertRegex(done.stderr, r"(No space left on device|disk is full).*\(free some space\)")
        self.assertLessEqual(done.stderr.count("\n"), 3, done.stderr)
        dump(self.folder / "kept/store.gpkg")  # opens, and no row without its picture


class Live(StationCase):
    def start_live(self, *arguments, **kwargs):
        process = self.start("--store", self.folder / "live/store.gpkg", *arguments, **kwargs)
        self.assertTrue(wait_for((self.folder / "live/store.gpkg").exists), "no store")
        time.sleep(1.0)  # the subscription follows the store
        return process

    def publish(self, messages, rate_hz=250):
        publisher = mission_packets.Publisher()
        self.addCleanup(publisher.socket.close)
        for _, channel, data in messages:
            publisher.send(channel, data)
            time.sleep(1.0 / rate_hz)

    @own_network
    def test_live_and_log_give_the_same_store(self):
        live = self.start_live("--latency", self.folder / "latency.csv")
        self.publish(self.mission.messages)
        store = self.folder / "live/store.gpkg"
        self.assertTrue(wait_for(lambda: rows(store, "select count(*) from obs_panorama where stage='full'") == [(12,)]))
        time.sleep(0.5)
        live.send_signal(signal.SIGTERM)
        out, err = live.communicate(timeout=30)
        self.assertEqual(live.returncode, 0, err)
        self.assertIn("12 pictures (12 full and 12 preview packets)", out)
        self.assertRegex(out, r"packet to disk median \d+\.\d ms, p99 \d+\.\d ms")
        self.assertEqual(self.run_log(self.folder / "log/store.gpkg").returncode, 0)
        self.assertEqual(dump(store), dump(self.folder / "log/store.gpkg"))
        with open(self.folder / "latency.csv", newline="") as f:
            latency = list(csv.DictReader(f))
        self.assertEqual(sorted((int(r["epoch"]), r["stage"]) for r in latency),
                         sorted((e, s) for e in range(1, 13) for s in ("full", "preview")))
        for r in latency:
            self.assertGreaterEqual(int(r["mono_ns"]), int(r["received_mono_ns"]))

    @own_network
    def test_a_reader_sees_a_picture_while_the_station_runs(self):
        live = self.start_live()
        self.publish(self.mission.messages[:120])
        store = self.folder / "live/store.gpkg"
        self.assertTrue(wait_for(lambda: count(store, "obs_panorama") > 0))
        self.assertIsNone(live.poll())

    @own_network
    def test_killed_and_started_again_it_goes_on(self):
        store = self.folder / "live/store.gpkg"
        publisher = mission_packets.Publisher()
        self.addCleanup(publisher.socket.close)
        half = len(self.mission.messages) // 2
        live = self.start_live()
        for i, (_, channel, data) in enumerate(self.mission.messages):
            if i == half:
                live.kill()
                live.communicate()
                self.assertGreater(len(dump(store)), 0)  # what is there is whole
                live = self.start_live()
            publisher.send(channel, data)
            time.sleep(0.004)
        time.sleep(0.5)
        live.send_signal(signal.SIGTERM)
        live.communicate(timeout=30)
        self.run_log(store)  # the robot's log fills what the station missed while it was dead
        self.run_log(self.folder / "log/store.gpkg")
        self.assertEqual(dump(store), dump(self.folder / "log/store.gpkg"))

    @own_network
    def test_a_locked_store_costs_nothing(self):
        live = self.start_live("--set", "retry_period_s=0.05")
        store = self.folder / "live/store.gpkg"
        self.publish(self.mission.messages[:60])
        self.assertTrue(wait_for(lambda: count(store, "obs_panorama") > 0))
        editor = sqlite3.connect(store, isolation_level=None)
        editor.execute("begin immediate")
        self.publish(self.mission.messages[60:])
        time.sleep(1.5)
        editor.execute("rollback")
        editor.close()
        self.assertTrue(wait_for(lambda: rows(store, "select count(*) from obs_panorama where stage='full'") == [(12,)]))
        live.send_signal(signal.SIGTERM)
        out, err = live.communicate(timeout=30)
        self.assertEqual(live.returncode, 0, err)
        self.assertIn("database is locked (another program is writing to it)", err)
        self.assertIn("store works again", err)
        self.assertIn("dropped 0", out)
        self.run_log(self.folder / "log/store.gpkg")
        self.assertEqual(dump(store), dump(self.folder / "log/store.gpkg"))

    @own_network
    def test_it_ends_by_itself_when_told_so(self):
        for arguments in (["--duration", "1"], ["--idle-exit", "1"]):
            live = self.start("--store", self.folder / "live/store.gpkg", *arguments)
            live.communicate(timeout=30)
            self.assertEqual(live.returncode, 0)


if __name__ == "__main__":
    unittest.main()
