"""kawara-sim as a process: what a host on the other end of its ports sees. Times are never asserted, only order and content."""
import csv
import os
import select
import shutil
import signal
import socket
import struct
import subprocess
import tempfile
import termios
import time
import unittest

BIN = os.environ["KAWARA_BIN"]
SOURCE = os.environ["KAWARA_SOURCE_DIR"]
PATIENCE_S = 60  # a busy machine may be slow; no test waits this long when all is well


def checksum_good(line):
    body, _, digits = line[1:].partition("*")
    total = 0
    for character in body:
        total ^= ord(character)
    return "%02X" % total == digits


class Port:
    """A serial port opened the way a host program does: raw, 8N1, at a rate."""

    def __init__(self, link, speed):
        self.fd = os.open(link, os.O_RDWR | os.O_NOCTTY | os.O_NONBLOCK)
        self.received = b""
        self.set_speed(speed)

    def set_speed(self, speed):
        a = termios.tcgetattr(self.fd)
        a[0] = a[1] = a[3] = 0
        a[2] = termios.CS8 | termios.CREAD | termios.CLOCAL
        a[4] = a[5] = speed
        termios.tcsetattr(self.fd, termios.TCSANOW, a)

    def read(self, seconds):
        """Everything that comes within that time; None once the port is gone."""
        end = time.monotonic() + seconds
        got = b""
        while time.monotonic() < end:
            if not select.select([self.fd], [], [], 0.02)[0]:
                continue
            try:
                piece = os.read(self.fd, 4096)
            except OSError:
                return None
            if not piece:
                return None
            got += piece
        self.received += got
        return got

    def read_until(self, wanted):
        got = b""
        end = time.monotonic() + PATIENCE_S
        while wanted not in got and time.monotonic() < end:
            piece = self.read(0.05)
            if piece is None:
                raise AssertionError("port gone while waiting for %r" % wanted)
            got += piece
        if wanted not in got:
            raise AssertionError("no %r in %r" % (wanted, got[-300:]))
        return got

    def write(self, data):
        os.write(self.fd, data)

    def close(self):
        os.close(self.fd)


class SimCase(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.mkdtemp(prefix="kawara_sim_")
        self.process = None

    def tearDown(self):
        if self.process is not None:
            if self.process.poll() is None:
                self.process.kill()
            self.process.communicate()
        shutil.rmtree(self.folder)

    def path(self, name):
        return os.path.join(self.folder, name)

    def start(self, *options):
        self.process = subprocess.Popen(
            [os.path.join(BIN, "kawara-sim"), "drive", "--data", os.path.join(SOURCE, "data/drive_0708"), "--run-dir",
             self.folder, *options],
            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True)
        end = time.monotonic() + PATIENCE_S
        while not os.path.exists(self.path("ready")):
            self.assertIsNone(self.process.poll(), "ended before it was ready")
            self.assertLess(time.monotonic(), end)
            time.sleep(0.01)

    def finish(self):
        output, _ = self.process.communicate(timeout=PATIENCE_S)
        self.assertEqual(self.process.returncode, 0, output)
        return output


class Streaming(SimCase):
    def test_sentences_are_the_recording_and_the_run_ends_by_itself(self):
        self.start("--start", "60", "--duration", "4", "--gps-baud", "115200", "--gps-preset", "streaming",
                   "--gga-quality", "nmea23")
        gps = Port(self.path("gps"), termios.B115200)
        data = b""
        while (piece := gps.read(0.1)) is not None:
            data += piece
        output = self.finish()
        gps.close()
        self.assertIn("16 epochs", output)
        self.assertIn("0 overrun bytes", output)
        lines = data.decode("ascii").split("\r\n")
        self.assertEqual(lines.pop(), "")
        for line in lines:
            self.assertTrue(checksum_good(line), line)
        with open(self.path("truth_epochs.csv")) as truth_file:
            truth = list(csv.DictReader(truth_file))
        gga = [line.split(",") for line in lines if line.startswith("$GPGGA")]
        self.assertEqual(len(gga), len(truth))
        for sentence, epoch in zip(gga, truth):
            self.assertEqual(sentence[6], "4" if epoch["q"] == "1" else "5")
            latitude = int(sentence[2][:2]) + float(sentence[2][2:]) / 60
            longitude = int(sentence[4][:3]) + float(sentence[4][3:]) / 60
            self.assertAlmostEqual(latitude, float(epoch["lat_deg"]), delta=1e-9)
            self.assertAlmostEqual(-longitude, float(epoch["lon_deg"]), delta=1e-9)
            self.assertAlmostEqual(float(sentence[9]) + float(sentence[11]), float(epoch["h_m"]), delta=2e-4)
            utc_s = int(epoch["gps_ns"]) / 1e9 - 18
            day_s = int(sentence[1][:2]) * 3600 + int(sentence[1][2:4]) * 60 + float(sentence[1][4:])
            self.assertAlmostEqual(utc_s % 86400, day_s, places=3)
        for name in ("ready", "gps", "ahrs", "camera.sock"):
            self.assertFalse(os.path.lexists(self.path(name)), name)

    def test_now_moves_the_recording_to_the_present(self):
        self.start("--duration", "1", "--now")
        self.finish()
        with open(self.path("truth_epochs.csv")) as truth_file:
            first = next(csv.DictReader(truth_file))
        gps_now_s = time.time() - 315964800 + 18
        self.assertAlmostEqual(int(first["gps_ns"]) / 1e9, gps_now_s, delta=2 * PATIENCE_S)
        self.assertEqual(int(first["gps_ns"]) % 1_000_000_000 // 1_000_000 % 250, 249)

    def test_sigterm_ends_cleanly(self):
        self.start()
        self.process.send_signal(signal.SIGTERM)
        self.assertIn("(stopped)", self.finish())
        self.assertFalse(os.path.lexists(self.path("gps")))


class Commands(SimCase):
    def test_wrong_rate_is_garbage_right_rate_a_dialogue(self):
        self.start("--duration", "120")
        gps = Port(self.path("gps"), termios.B38400)
        gps.write(b"$PASHQ,RID\r\n")
        self.assertEqual(gps.read(0.5), b"", "a receiver at 9600 does not understand 38400")
        gps.set_speed(termios.B9600)
        gps.write(b"$PASHQ,RID\r\n")
        self.assertIn(b"$PASHR,RID,UZ", gps.read_until(b"\r\n"))
        gps.write(b"$PASHS,NME,GGA,A,ON*FF\r\n")
        gps.read_until(b"$PASHR,NAK*30\r\n")
        gps.write(b"$PASHS,NME,GGA,A,ON\r\n")
        gps.read_until(b"$PASHR,ACK*3D\r\n")
        gps.read_until(b"$GPGGA,")
        gps.write(b"$PASHS,SPD,A,9\r\n")
        gps.read_until(b"$PASHR,ACK*3D\r\n")
        gps.read(2.5)  # at the old rate: what comes is wrong
        self.assertNotIn(b"GPGGA", gps.received[-100:])
        gps.set_speed(termios.B115200)
        gps.read_until(b"$GPGGA,")
        gps.write(b"$PASHS,NME,ALL,A,OFF\r\n")
        gps.read_until(b"$PASHR,ACK*3D\r\n")
        self.assertEqual(gps.read(1.5), b"")
        gps.close()
        self.process.send_signal(signal.SIGTERM)
        self.finish()

    def test_ahrs_streams_from_the_last_run_and_obeys(self):
        self.start("--duration", "120")
        ahrs = Port(self.path("ahrs"), termios.B38400)
        data = b""
        while len(data) < 300:
            data += ahrs.read(0.1)
        start = next(i for i in range(30) if all(
            data[i + 30 * k] == 0xFF and sum(data[i + 30 * k + 1:i + 30 * k + 29]) & 0xFF == data[i + 30 * k + 29]
            for k in range(5)))
        counters = [struct.unpack(">H", data[i + 27:i + 29])[0] for i in range(start, len(data) - 30, 30)]
        for before, after in zip(counters, counters[1:]):
            self.assertIn((before - after) & 0xFFFF, range(9000, 17000), "100 Hz of 0.79 us, counting down")
        ahrs.write(b"P")
        ahrs.read(0.3)
        self.assertEqual(ahrs.read(0.3), b"")
        ahrs.write(b"R")
        self.assertEqual(ahrs.read_until(b"H"), b"H")
        ahrs.write(b"v")
        self.assertIn(b"AHRS400CC-100", ahrs.read_until(b"-100"))
        ahrs.close()
        self.process.send_signal(signal.SIGTERM)
        self.finish()


class Faults(SimCase):
    def test_unplug_gives_end_of_file_and_another_number_behind_the_same_link(self):
        self.start("--start", "60", "--duration", "60", "--gps-baud", "115200", "--gps-preset", "streaming", "--fault",
                   "t=2 gps.unplug 1s")
        gps = Port(self.path("gps"), termios.B115200)
        before = os.path.realpath(self.path("gps"))
        end = time.monotonic() + PATIENCE_S
        while gps.read(0.1) is not None:
            self.assertLess(time.monotonic(), end)
        while not os.path.lexists(self.path("gps")):
            self.assertLess(time.monotonic(), end)
            time.sleep(0.02)
        after = os.path.realpath(self.path("gps"))
        self.assertNotEqual(before, after)
        gps.close()
        gps = Port(self.path("gps"), termios.B115200)
        gps.read_until(b"$GPGGA,")
        gps.close()
        self.process.send_signal(signal.SIGTERM)
        self.finish()

    def test_mistyped_options_say_what_and_exit_2(self):
        for options, must_say in (
                (["--fault", "t=1 gps.explode"], "is none of gps.unplug"),
                (["--start", "9999"], "the recording has"),
                (["--panorama", "/no/such.jpg"], "no such file"),
                (["--gps-baud", "12345"], "--gps-baud"),
        ):
            done = subprocess.run(
                [os.path.join(BIN, "kawara-sim"), "drive", "--data", os.path.join(SOURCE, "data/drive_0708"), "--run-dir",
                 self.folder, *options], capture_output=True, text=True, timeout=PATIENCE_S)
            self.assertEqual(done.returncode, 2, options)
            self.assertIn(must_say, done.stderr)


class Camera(SimCase):
    def test_frames_answer_triggers_and_stand_in_the_truth_file(self):
        panorama = os.path.join(SOURCE, "data/panorama/R0014760_3072.jpg")
        self.start("--start", "60", "--duration", "120", "--panorama", panorama, "--doughnut-px", "512", "--gps-baud",
                   "115200", "--gps-preset", "streaming")
        gps = Port(self.path("gps"), termios.B115200)
        camera = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        camera.settimeout(PATIENCE_S)
        camera.connect(self.path("camera.sock"))
        frames = []
        gps.read_until(b"$GPGGA,")  # without a position the receiver tags no events
        for sequence in (1, 2, 3):
            triggered_ns = time.monotonic_ns()
            camera.sendall(struct.pack("<IIq", 0x4752544B, sequence, triggered_ns))
            header = struct.unpack("<IIIIqIIII", self.receive(camera, 40))
            jpeg = self.receive(camera, header[7])
            self.assertEqual(header[0], 0x4D52464B)
            self.assertEqual(header[2], sequence)
            self.assertEqual(header[5:7], (512, 512))
            self.assertEqual(jpeg[:3], b"\xff\xd8\xff")
            self.assertGreaterEqual(header[4], triggered_ns)
            frames.append(header)
            gps.read_until(b"$PASHR,TTT,")
            time.sleep(0.3)  # only the first event between two epochs is tagged
        with open(self.path("truth_exposures.csv")) as truth_file:
            truth = list(csv.DictReader(truth_file))
        self.assertEqual([int(row["trigger_sequence"]) for row in truth], [1, 2, 3])
        self.assertEqual([int(row["mono_ns"]) for row in truth], [header[4] for header in frames])
        camera.close()
        gps.close()
        self.process.send_signal(signal.SIGTERM)
        self.assertIn("3 frames, 0 missed, 0 lost", self.finish())

    def receive(self, camera, size):
        data = b""
        while len(data) < size:
            piece = camera.recv(size - len(data))
            self.assertTrue(piece, "camera closed")
            data += piece
        return data


if __name__ == "__main__":
    unittest.main()
