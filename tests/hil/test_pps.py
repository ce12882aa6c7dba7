"""The receiver's pulse over a socket: what GPS time rests on while the pulse is there, lost, and back."""
import csv
import os
import pathlib
import shutil
import tempfile
import unittest

from processes import SOURCE, Processes, run, wait_for

URL = f"udpm://239.255.76.67:{11700 + os.getpid() % 2000}?ttl=0"
PPS, HOLDOVER = 2, 3  # clock_t.source


class PulseTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-pps-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def rows(self, log, channel):
        out = self.folder / f"{channel}.csv"
        done = run("kawara-log", "export", log, "--channel", channel, "--out", out, timeout=60)
        if done.returncode != 0:
            return []
        with open(out, newline="") as file:
            return list(csv.DictReader(file))

    def test_lost_and_back(self):
        ports = self.folder / "ports"
        with Processes(self.folder / "output") as chain:
            chain.start("sim", "kawara-sim", "drive", "--data", SOURCE / "data/drive_0708", "--run-dir", ports, "--start", "100",
                        "--duration", "300", "--gps-baud", "115200", "--gps-preset", "streaming", "--lcm-url", URL)
            wait_for(lambda: (ports / "ready").exists(), 60, "the simulator's ports")
            chain.start("onboard", "kawara-onboard", "--config", SOURCE / "configs/demo.yaml", "--set",
                        f"gps.device={ports}/gps", "--set", f"gps.pps.device={ports}/pps.sock", "--set",
                        f"ahrs.device={ports}/ahrs", "--set", "camera.source=none", "--set", f"record.folder={self.folder}/log",
                        "--set", f"lcm_url={URL}")
            log = wait_for(lambda: next(iter((self.folder / "log").glob("*")), None), 60, "the log")

            def source(expected):
                clocks = self.rows(log, "CLOCK")
                return clocks and int(clocks[-1]["source"]) == expected

            wait_for(lambda: source(PPS), 90, "pulses to rule")
            done = run("kawara-sim", "fault", "pps.lost 8s; pps.double 60s", "--lcm-url", URL, timeout=60)
            self.assertEqual(done.returncode, 0, done.stderr)
            wait_for(lambda: source(HOLDOVER), 60, "hold-over")
            wait_for(lambda: source(PPS), 60, "the pulses' return")
            wait_for(lambda: int(self.rows(log, "CLOCK")[-1]["outliers"]) > 0, 60, "refused spurious edges")
            self.assertEqual(chain.stop("onboard"), 0, chain.output("onboard"))
            self.assertEqual(chain.stop("sim"), 0, chain.output("sim"))
        names = [row["name"] for row in self.rows(log, "EVENT") if row["name"].startswith("clock.")]
        self.assertEqual(names[:2], ["clock.pps", "clock.holdover"])
        self.assertEqual(names.count("clock.holdover"), 1)
        ruled = [row for row in self.rows(log, "CLOCK") if int(row["source"]) == PPS]
        self.assertLess(float(ruled[-1]["sigma_s"]), 100e-6)

        # The log holds the edges: from it alone comes the same.
        again = self.folder / "again.lcm"
        done = run("kawara-onboard", "--log", log, "--out", again, timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)
        column = lambda rows, name: [row[name] for row in rows]
        for name in ("gps_ns", "sigma_s", "source"):
            self.assertEqual(column(self.rows(again, "CLOCK"), name), column(self.rows(log, "CLOCK"), name))


if __name__ == "__main__":
    unittest.main()
