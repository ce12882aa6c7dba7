"""kawara-decode --as ahrs and --as sick on bytes made here from the published layouts."""
import json
import math
import os
import random
import struct
import subprocess
import tempfile
import unittest

DECODE = os.path.join(os.environ["KAWARA_BIN"], "kawara-decode")


def frame(payload):
    return b"\xff" + payload + bytes([sum(payload) % 256])


def packet(*words):
    return frame(struct.pack(">%dH" % len(words), *(w & 0xFFFF for w in words)))


def angle(counter, roll=0x2000, temperature=1500):
    return packet(roll, -0x1000, 0x4000, 100, -200, 300, 5, -6, -10923, 7, -8, 9, temperature, counter)


def sick_crc(data):
    crc, last = 0, 0
    for byte in data:
        crc <<= 1
        if crc & 0x10000:
            crc = (crc & 0xFFFF) ^ 0x8005
        crc ^= byte | last << 8
        last = byte
    return crc


def telegram(payload, address=0x80):
    body = struct.pack("<BBH", 2, address, len(payload)) + payload
    return body + struct.pack("<H", sick_crc(body))


def scan(ranges, status=0x10, unit=0):
    count = len(ranges) | unit << 14
    return telegram(struct.pack("<BH%dHB" % len(ranges), 0xB0, count, *ranges, status))


class Decode(unittest.TestCase):
    def run_on(self, data, kind, *options):
        with tempfile.NamedTemporaryFile() as f:
            f.write(data)
            f.flush()
            done = subprocess.run([DECODE, "--as", kind, f.name, *options], capture_output=True, timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        lines = [json.loads(line) for line in done.stdout.splitlines()]
        return lines[:-1], lines[-1]["summary"]


class Ahrs(Decode):
    def test_values_in_si_units(self):
        lines, summary = self.run_on(angle(5000) + angle(4000), "ahrs")
        self.assertEqual(summary["types"], {"AHRS.angle": 2})
        first = lines[0]
        self.assertAlmostEqual(first["roll_deg"], 45.0, places=5)
        self.assertAlmostEqual(first["pitch_deg"], -22.5, places=5)
        self.assertAlmostEqual(first["heading_magnetic_deg"], 90.0, places=5)
        self.assertAlmostEqual(first["rate_radps"][2], math.radians(300 * 150 / 32768), places=8)
        self.assertAlmostEqual(first["acceleration_mps2"][2], -10923 * 3 / 32768 * 9.80665, places=7)
        self.assertAlmostEqual(first["magnetic_tesla"][1], -8 * 1.875 / 32768 * 1e-4, places=12)
        self.assertAlmostEqual(first["temperature_degc"], 44.44 * (1500 * 5 / 4096 - 1.375), places=3)
        self.assertAlmostEqual(lines[1]["step_modulo_wrap_s"], 1000 * 0.79e-6, places=9)

    def test_scaling_and_sign_are_options(self):
        data = angle(5000)
        plain = self.run_on(data, "ahrs")[0][0]
        wide = self.run_on(data, "ahrs", "--scaling", "200", "--acceleration-sign", "-1")[0][0]
        for a, b in zip(plain["rate_radps"], wide["rate_radps"]):
            self.assertAlmostEqual(2 * a, b, places=7)
        for a, b in zip(plain["acceleration_mps2"], wide["acceleration_mps2"]):
            self.assertAlmostEqual(-2 * a, b, places=7)

    def test_garbage_and_replies_between_packets(self):
        rng = random.Random(5)
        data, sent = b"", []
        for block in range(20):
            for i in range(5):
                counter = 60000 - 1000 * (block % 4) - 150 * i
                sent.append(counter)
                data += angle(counter, roll=rng.randrange(65536))
            data += bytes(rng.randrange(256) for _ in range(rng.randrange(1, 60)))
        garbage = len(data) - 100 * 30
        data += b"H" + frame(b"AHRS400CC-100 v1.08".ljust(24)) + frame(struct.pack(">I", 4711)) + b"A"
        lines, summary = self.run_on(data, "ahrs")
        self.assertEqual([m["counter"] for m in lines if m["type"] == "AHRS.angle"], sent)
        self.assertEqual(summary["good"], 102)
        self.assertEqual(summary["skipped_bytes"], garbage + 2)
        self.assertEqual(summary["total_bytes"], len(data))
        self.assertIn({"type": "AHRS.version", "version": "AHRS400CC-100 v1.08"},
                      [{k: m[k] for k in m if k != "offset"} for m in lines])
        self.assertEqual([m["serial_number"] for m in lines if m["type"] == "AHRS.serial"], [4711])

    def test_scaled_is_found_by_itself_and_voltage_by_option(self):
        data = b"".join(packet(1, 2, 3, 4, 5, 6, 7, 8, 9, 1500, 9000 - i) for i in range(4))
        self.assertEqual(self.run_on(data, "ahrs")[1]["types"], {"AHRS.scaled": 4})
        lines, summary = self.run_on(data, "ahrs", "--voltage")
        self.assertEqual(summary["types"], {"AHRS.voltage": 4})
        self.assertAlmostEqual(lines[0]["gyro_v"][1], 2 * 5 / 4096, places=6)

    def test_frozen_packets_are_marked(self):
        lines, summary = self.run_on(angle(3) + angle(2) + angle(2) + angle(1), "ahrs")
        self.assertEqual(summary["frozen"], 1)
        self.assertEqual([m.get("frozen", False) for m in lines], [False, False, True, False])

    def test_empty_file_has_a_summary(self):
        self.assertEqual(self.run_on(b"", "ahrs")[1]["total_bytes"], 0)

    def test_wrong_scaling_is_one_line(self):
        done = subprocess.run([DECODE, "--as", "ahrs", "--scaling", "150", "/dev/null"], capture_output=True)
        self.assertEqual(done.returncode, 2)
        self.assertEqual(done.stderr.count(b"\n"), 1)


class Sick(Decode):
    def test_scan_in_metres(self):
        ranges = [(i * 7) % 8000 for i in range(361)]
        ranges[3] |= 0x2000
        lines, summary = self.run_on(b"\x06" + scan(ranges) + scan(ranges, unit=1), "sick")
        self.assertEqual(summary["types"], {"SICK.ACK": 1, "SICK.B0": 2})
        for line, metres in zip(lines[1:], (0.01, 0.001)):
            self.assertEqual(line["points"], 361)
            self.assertEqual(line["step_deg"], 0.5)
            for got, raw in zip(line["range_m"], ranges):
                self.assertAlmostEqual(got, (raw & 0x1FFF) * metres, places=6)
            self.assertEqual(line["flags"][3], 1)

    def test_damage_costs_one_telegram(self):
        good = scan(list(range(181)))
        bad = bytearray(good)
        bad[50] ^= 4
        lines, summary = self.run_on(good + bytes(bad) + b"noise" + good, "sick")
        self.assertEqual(summary["types"], {"SICK.B0": 2})
        self.assertEqual(summary["bad_checksum"], 1)
        self.assertEqual(summary["skipped_bytes"], len(good) + 5)

    def test_known_commands(self):
        path = os.path.join(os.environ["KAWARA_SOURCE_DIR"], "data/laser/known_answer_telegrams.json")
        with open(path) as f:
            known = json.load(f)
        lines, summary = self.run_on(b"".join(bytes.fromhex(h) for h in known.values()), "sick")
        self.assertEqual(summary["good"], len(known))
        self.assertEqual(summary["skipped_bytes"], 0)
        self.assertFalse(any(m["from_scanner"] for m in lines))


if __name__ == "__main__":
    unittest.main()
