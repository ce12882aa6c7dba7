"""kawara-decode --as gps on the recordings: counts, values, exit statuses, memory."""
import json
import os
import random
import resource
import subprocess
import tempfile
import unittest

PROGRAM = os.path.join(os.environ["KAWARA_BIN"], "kawara-decode")
DATA = os.path.join(os.environ["KAWARA_SOURCE_DIR"], "data", "gnss")


def run(*arguments, stdin=None):
    return subprocess.run([PROGRAM, *arguments], input=stdin, capture_output=True, timeout=120, check=False)


def decode(name, *options):
    result = run("--as", "gps", *options, os.path.join(DATA, name))
    lines = [json.loads(line) for line in result.stdout.splitlines()]
    return lines[:-1], lines[-1]["summary"]


def checked_by_gpsd(name):
    """TPV reports of the .chk file: what gpsd made of the same bytes."""
    reports = []
    with open(os.path.join(DATA, name), "rb") as chk:
        for line in chk:
            if line.startswith(b'{"class":"TPV"'):
                reports.append(json.loads(line))
    return reports


class Recordings(unittest.TestCase):
    def test_every_byte_and_every_type_of_the_ac12(self):
        messages, summary = decode("ac12_binary.log")
        self.assertEqual(summary["good"], 64)
        self.assertEqual(summary["bad_checksum"], 0)
        self.assertEqual(summary["skipped_bytes"], 0)
        self.assertEqual(summary["comment_bytes"], 510)
        self.assertEqual(summary["total_bytes"], os.path.getsize(os.path.join(DATA, "ac12_binary.log")))
        self.assertEqual(summary["types"]["PASHR"], 13)
        self.assertEqual(summary["types"]["PBN"], 4)
        self.assertEqual(summary["pashr"], {"POS": 5, "SAT": 4, "XMG": 4})
        self.assertEqual(len(messages), 64)

    def test_offsets_point_at_the_messages(self):
        with open(os.path.join(DATA, "ac12_binary.log"), "rb") as file:
            recording = file.read()
        for message in decode("ac12_binary.log")[0]:
            start = recording[message["offset"]:message["offset"] + 10]
            expected = "$PASHR," + message["type"] if message["type"] in ("PBN", "MCA") else "$" + message["type"]
            self.assertTrue(start.startswith(expected.encode()), (message, start))

    def test_pbn_as_unpacked_independently(self):
        with open(os.path.join(DATA, "ac12_binary.pbn.json")) as file:
            expected = json.load(file)
        found = [m for m in decode("ac12_binary.log")[0] if m["type"] == "PBN"]
        self.assertEqual(len(found), len(expected))
        for message, record in zip(found, expected):
            self.assertEqual(message["offset"], record["offset"])
            self.assertAlmostEqual(message["gps_time_of_week_s"], record["gps_ms_of_week"] / 1000)
            for ours, theirs in zip(message["ecef_m"], record["ecef_m"]):
                self.assertAlmostEqual(ours, theirs, delta=1e-4)

    def test_trimble_positions_as_gpsd_has_them(self):
        messages, summary = decode("nmea-rtk.log")
        self.assertEqual((summary["good"], summary["bad_checksum"], summary["skipped_bytes"]), (244, 0, 0))
        gga = [m for m in messages if m["type"].endswith("GGA")]
        self.assertEqual([m["quality"] for m in gga].count(2), 104)
        self.assertEqual([m["quality"] for m in gga].count(4), 18)
        theirs = [(r["lat"], r["lon"], r["altHAE"]) for r in checked_by_gpsd("nmea-rtk.log.chk") if "lat" in r]
        for m in gga:
            # gpsd prints nine decimals of a degree (0.1 mm) and four of a metre.
            near = [r for r in theirs if abs(m["lat_deg"] - r[0]) < 1.01e-9 and abs(m["lon_deg"] - r[1]) < 1.01e-9
                    and abs(m["height_ellipsoidal_m"] - r[2]) < 1.01e-4]
            self.assertTrue(near, m)

    def test_ublox_binary_as_gpsd_has_it(self):
        pvt = [m for m in decode("ublox-zed-f9p-rtk.log")[0] if m["type"] == "UBX.01.07"]
        reports = {r["time"]: r for r in checked_by_gpsd("ublox-zed-f9p-rtk.log.chk")}
        compared = 0
        for message in pvt:
            report = reports.get("%sT%s.000Z" % (message["date"], message["time_utc"]))
            if report is None:
                continue
            compared += 1
            self.assertAlmostEqual(message["lat_deg"], report["lat"], delta=1e-9)
            self.assertAlmostEqual(message["lon_deg"], report["lon"], delta=1e-9)
            self.assertAlmostEqual(message["height_ellipsoidal_m"], report["altHAE"], delta=1e-4)
            self.assertAlmostEqual(message["speed_mps"], report["speed"], delta=1e-3)
            self.assertEqual(message["rtk_state"], "float")
        self.assertEqual(compared, 9)

    def test_rtcm_of_both_generations(self):
        messages, summary = decode("rtcm3.log")
        station = [m for m in messages if m["type"] == "RTCM3.1005"][0]
        self.assertEqual(station["station"], 2003)
        self.assertEqual(station["ecef_m"], [1114104.5999, -4850729.7108, 3975521.4643])
        self.assertEqual(decode("rtcm3-2.log", "--summary")[1]["good"], 199)
        types = decode("testglo.rtcm2", "--summary")[1]["types"]
        self.assertEqual(types, {"RTCM2.1": 185, "RTCM2.3": 18, "RTCM2.18": 744, "RTCM2.19": 744, "RTCM2.22": 36})


class Program(unittest.TestCase):
    def test_standard_input_is_a_file_too(self):
        with open(os.path.join(DATA, "nmea-rtk.log"), "rb") as file:
            result = run("--as", "gps", "--summary", "-", stdin=file.read())
        self.assertEqual(json.loads(result.stdout)["summary"], decode("nmea-rtk.log", "--summary")[1])

    def test_receiver_profile_changes_the_meaning(self):
        line = b"$GPGGA,120000.00,3510.0,N,13658.0,E,3,09,0.9,+00087.500,M,,M,03.045,0001*41\r\n"
        for receiver, state in (("nmea", "autonomous"), ("ashtech-legacy", "fixed")):
            result = run("--as", "gps", "--receiver", receiver, "-", stdin=line)
            gga = json.loads(result.stdout.splitlines()[0])
            self.assertEqual(gga["rtk_state"], state, result.stdout)
            self.assertEqual(gga["height_ellipsoidal_m"], 87.5)

    def test_what_cannot_be_decoded_is_one_line_and_status_2(self):
        unreadable = [("--as", "gps", "/nonexistent/file"), ("--as", "gps", "/tmp"), ("--as", "radar", "/dev/null"),
                      ("--as", "gps"), ("/dev/null",), ("--as", "gps", "--wrong", "/dev/null")]
        for arguments in unreadable:
            result = run(*arguments)
            self.assertEqual(result.returncode, 2, arguments)
            self.assertEqual(result.stdout, b"", arguments)
            self.assertEqual(len(result.stderr.strip().splitlines()), 1, result.stderr)

    def test_an_empty_file_is_no_error(self):
        result = run("--as", "gps", "/dev/null")
        self.assertEqual(result.returncode, 0)
        self.assertEqual(json.loads(result.stdout)["summary"]["good"], 0)

    def test_remarks_without_an_end_are_remarks(self):
        result = run("--as", "gps", "-", stdin=b"# one\n# two, and the file ends here")
        summary = json.loads(result.stdout)["summary"]
        self.assertEqual((summary["comment_bytes"], summary["skipped_bytes"]), (35, 0))

    def test_memory_stays_constant(self):
        noise = random.Random(1).randbytes(1 << 20)
        with tempfile.NamedTemporaryFile() as file:
            for _ in range(128):
                file.write(noise)
            file.flush()
            # The most it may ever have at once; a quarter of what goes through. (The system's own figure of a child's
            # memory begins with that of whoever started it.)
            done = subprocess.run([PROGRAM, "--as", "gps", "--summary", file.name], capture_output=True, timeout=300, check=False,
                                  preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_DATA, (32 << 20, 32 << 20)))
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(json.loads(done.stdout)["summary"]["total_bytes"], 128 << 20)


if __name__ == "__main__":
    unittest.main()
