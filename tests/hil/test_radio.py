"""kawara-sim radio as a process: what of one LCM bus arrives on the other, in a network namespace of its own."""
import os
import pathlib
import re
import signal
import socket
import sqlite3
import struct
import subprocess
import tempfile
import time
import unittest

import mission_packets
from processes import Processes, run, wait_for

NAMESPACE = "_KAWARA_TEST_NAMESPACE"
GROUP, ROBOT_PORT, BASE_PORT = "239.255.76.67", 7667, 7668
ROBOT = f"udpm://{GROUP}:{ROBOT_PORT}?ttl=0"
SO_RCVBUFFORCE = 33  # Linux; root may pass net.core.rmem_max
BASE = f"udpm://{GROUP}:{BASE_PORT}?ttl=0"


def heard(s, quiet_s=1.0):
    """All datagrams (bytes, sender) that are not LCM's until it has been quiet for so long."""
    s.settimeout(quiet_s)
    got = []
    while True:
        try:
            datagram, sender = s.recvfrom(65536)
        except socket.timeout:
            return got
        if not datagram.startswith(b"LC0"):
            got.append((datagram, sender))


@unittest.skipUnless(os.geteuid() == 0, "needs root for a network namespace")
class Radio(unittest.TestCase):
    def run(self, result=None):
        if not os.environ.get(NAMESPACE):
            setattr(self, self._testMethodName, self.in_own_network)
        return super().run(result)

    def in_own_network(self):
        script = ("ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo && exec /usr/bin/python3 -B -m unittest "
                  f"test_radio.Radio.{self._testMethodName}")
        done = subprocess.run(["unshare", "-n", "sh", "-c", script], env={**os.environ, NAMESPACE: "1"},
                              cwd=pathlib.Path(__file__).parent, capture_output=True, text=True, timeout=300)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)

    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory(prefix="kawara-radio-")
        self.addCleanup(self.temporary.cleanup)
        self.processes = Processes(self.temporary.name)
        self.addCleanup(self.processes.stop_all)

    def start(self, *options):
        before = self.processes.output("radio").count("radio between")
        self.processes.start("radio", "kawara-sim", "radio", "--robot", ROBOT, "--base", BASE, *options)
        wait_for(lambda: self.processes.output("radio").count("radio between") > before, 30, "the radio")

    def stop(self):
        """Counts of the summary: (robot to base, base to robot), each (in, packets, delivered, single, fades, down, queue)."""
        self.assertEqual(self.processes.stop("radio"), 0)
        line = self.processes.output("radio").splitlines()[-1]
        numbers = re.findall(r"(\d+) datagrams \((\d+) packets, [\d.]+ MB\) in, (\d+) delivered; lost: (\d+) for single "
                             r"packets, (\d+) in fades, (\d+) while down, (\d+) for a full queue", line)
        self.assertEqual(len(numbers), 2, line)
        return [tuple(map(int, n)) for n in numbers]

    def mouth(self):
        s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(s.close)
        s.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        s.bind(("", 0))
        return s

    def ear(self, port):
        """A socket that hears the bus."""
        s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.addCleanup(s.close)
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        s.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        s.setsockopt(socket.SOL_SOCKET, SO_RCVBUFFORCE, 1 << 23)
        s.bind((GROUP, port))
        s.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, struct.pack("4s4s", socket.inet_aton(GROUP), bytes(4)))
        return s

    @staticmethod
    def say(s, port, count, size=200, first=0):
        for i in range(first, first + count):
            s.sendto(struct.pack(">I", i) + bytes(size - 4), (GROUP, port))
            time.sleep(0.001)

    def test_both_ways_in_order_every_sender_kept_apart_and_no_echo(self):
        robot, base = self.ear(ROBOT_PORT), self.ear(BASE_PORT)
        self.start()
        one, two, station = self.mouth(), self.mouth(), self.mouth()
        for i in range(0, 100, 10):
            self.say(one, ROBOT_PORT, 10, first=i)
            self.say(two, ROBOT_PORT, 10, first=1000 + i)
        self.say(station, BASE_PORT, 50, first=2000)
        at_base = heard(base)
        sent_by_station = [d for d, a in at_base if a[1] == station.getsockname()[1]]
        carried = [(struct.unpack(">I", d[:4])[0], a) for d, a in at_base if a[1] != station.getsockname()[1]]
        self.assertEqual(len(sent_by_station), 50)
        self.assertEqual([n for n, _ in carried if n < 1000], list(range(100)))
        self.assertEqual([n for n, _ in carried if n >= 1000], list(range(1000, 1100)))
        first, second = {a for n, a in carried if n < 1000}, {a for n, a in carried if n >= 1000}
        self.assertEqual((len(first), len(second), first & second), (1, 1, set()))
        at_robot = [struct.unpack(">I", d[:4])[0] for d, _ in heard(robot)]
        self.assertEqual(len(at_robot), 250)  # what was said there, and the station's, once
        self.assertEqual([n for n in at_robot if n >= 2000], list(range(2000, 2050)))
        down, up = self.stop()
        self.assertEqual((down[0], down[2], up[0], up[2]), (200, 200, 50, 50))

    def test_the_same_seed_loses_the_same_datagrams(self):
        def arrived(*options):
            base = self.ear(BASE_PORT)
            self.start("--loss", 0.3, "--burst", 0.2, *options)
            self.say(self.mouth(), ROBOT_PORT, 300)
            numbers = [struct.unpack(">I", d[:4])[0] for d, _ in heard(base)]
            base.close()
            down, _ = self.stop()
            self.assertEqual(down[0], down[2] + down[3] + down[4])
            self.assertEqual(down[2], len(numbers))
            return numbers
        once, again, otherwise = arrived(), arrived(), arrived("--seed", 5)
        self.assertTrue(60 < len(once) < 260, len(once))
        self.assertEqual(once, again)
        self.assertNotEqual(once, otherwise)

    def test_a_fault_on_order_silences_it_and_passes(self):
        base = self.ear(BASE_PORT)
        self.start("--fault", "t=0 radio.down 4s")
        robot = self.mouth()
        self.say(robot, ROBOT_PORT, 20)
        self.assertEqual(heard(base), [])

        def comes_through():
            self.say(robot, ROBOT_PORT, 1, first=77)
            return heard(base, 0.1)
        wait_for(comes_through, 60, "the end of the fault")
        down, _ = self.stop()
        self.assertGreaterEqual(down[5], 20)

    def test_faults_can_be_ordered_while_it_runs(self):
        base = self.ear(BASE_PORT)
        self.start()
        robot = self.mouth()
        self.say(robot, ROBOT_PORT, 5)
        self.assertEqual(len(heard(base)), 5)
        done = run("kawara-sim", "fault", "radio.loss=1 3600s", "--lcm-url", ROBOT)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("radio.loss=1", done.stdout)
        heard(base)
        self.say(robot, ROBOT_PORT, 20)
        self.assertEqual(heard(base), [])
        done = run("kawara-sim", "fault", "gps.unplug; radio.down", "--lcm-url", ROBOT)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("give two", done.stdout + done.stderr)
        self.assertNotEqual(run("kawara-sim", "fault", "gps.unplug", "--lcm-url", ROBOT, "--timeout", 1).returncode, 0)
        self.assertEqual(run("kawara-sim", "fault", "clear", "--lcm-url", ROBOT).returncode, 0)
        heard(base)
        self.say(robot, ROBOT_PORT, 20)
        self.assertEqual(len(heard(base)), 20)
        down, _ = self.stop()
        self.assertGreaterEqual(down[3], 20)

    def test_a_narrow_air_delivers_a_picture_late_and_a_flood_not_at_all(self):
        base = self.ear(BASE_PORT)
        self.start("--rate", 2e6, "--queue", 100000)
        begin = time.monotonic()
        self.say(self.mouth(), ROBOT_PORT, 1, size=60000)
        base.settimeout(30)
        while len(base.recv(65536)) != 60000:
            pass
        self.assertGreater(time.monotonic() - begin, 60000 * 8 / 2e6)
        flood = self.mouth()
        for i in range(40):
            flood.sendto(bytes(60000), (GROUP, ROBOT_PORT))
        heard(base)
        down, _ = self.stop()
        self.assertGreater(down[6], 20)
        self.assertEqual(down[0], down[2] + down[6])

    def test_a_mission_across_a_perfect_radio_is_stored_whole(self):
        store = pathlib.Path(self.temporary.name) / "store.gpkg"
        self.start("--delay", 0.05, "--jitter", 0.01)
        self.processes.start("station", "kawara-station", "--store", store, "--lcm-url", BASE)
        wait_for(store.exists, 60, "the store")
        time.sleep(1)  # the subscription follows the store
        publisher = mission_packets.Publisher()
        self.addCleanup(publisher.socket.close)
        mission = mission_packets.Mission(pictures=6)
        for _, channel, data in mission.messages:
            publisher.send(channel, data)
            time.sleep(0.003)

        def pictures():
            try:
                with sqlite3.connect(f"file:{store}?mode=ro", uri=True) as connection:
                    return connection.execute("select count(*) from obs_panorama where stage='full'").fetchone()[0]
            except sqlite3.OperationalError:
                return 0
        wait_for(lambda: pictures() == 6, 60, "six pictures in the store")
        self.assertEqual(self.processes.stop("station", sig=signal.SIGTERM), 0)
        self.assertIn("6 pictures", self.processes.output("station"))

    def test_mistakes_are_told_in_one_line(self):
        for arguments, must_say in ((["--base", ROBOT], "same bus"),
                                    (["--base", "tcp://x"], "udpm://"),
                                    (["--fault", "t=1 gps.unplug"], "kawara-sim drive or site"),
                                    (["--fault", "t=1 radio.loss=2"], "a share of 0 to 1"),
                                    (["--loss", "2"], "--loss")):
            done = run("kawara-sim", "radio", "--robot", ROBOT, *arguments)
            self.assertEqual(done.returncode, 2, done.stdout)
            self.assertIn(must_say, done.stderr)
        done = run("kawara-sim", "drive", "--data", "x", "--run-dir", self.temporary.name, "--fault", "t=1 radio.down")
        self.assertEqual(done.returncode, 2)
        self.assertIn("kawara-sim radio", done.stderr)


if __name__ == "__main__":
    unittest.main()
