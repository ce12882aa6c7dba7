"""Faults ordered over LCM while kawara-sim and kawara-onboard run: what the robot says of them, and that it recovers."""
import os
import pathlib
import shutil
import tempfile
import unittest

from processes import SOURCE, Processes, run, wait_for

DRIVE = SOURCE / "data/drive_0708"
URL = f"udpm://239.255.76.67:{9700 + os.getpid() % 2000}?ttl=0"


def order(text, *more):
    return run("kawara-sim", "fault", text, "--lcm-url", URL, *more, timeout=60)


class OrderedFaultsTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-faults-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.ports = self.folder / "ports"

    def start_sim(self, chain, *more):
        chain.start("sim", "kawara-sim", "drive", "--data", DRIVE, "--run-dir", self.ports, "--start", "100", "--duration", "300",
                    "--lcm-url", URL, *more)
        wait_for(lambda: (self.ports / "ready").exists(), 60, "the simulator's ports")

    def events(self, log):
        out = self.folder / "events.csv"
        done = run("kawara-log", "export", log, "--channel", "EVENT", "--out", out, timeout=60)
        return out.read_text() if done.returncode == 0 else ""

    def test_the_robot_tells_of_them_and_recovers(self):
        with Processes(self.folder / "output") as chain:
            self.start_sim(chain, "--gps-baud", "115200", "--gps-preset", "streaming")
            chain.start("onboard", "kawara-onboard", "--config", SOURCE / "configs/demo.yaml", "--set",
                        f"gps.device={self.ports}/gps", "--set", f"ahrs.device={self.ports}/ahrs", "--set", "camera.source=none",
                        "--set", f"record.folder={self.folder}/log", "--set", f"lcm_url={URL}")
            log = wait_for(lambda: next(iter((self.folder / "log").glob("*")), None), 60, "the log")
            said = lambda text: lambda: text in self.events(log)
            wait_for(said("gps.rtk_state"), 90, "the first fix")
            done = order("gps.unplug 3s; ahrs.silent 5s")
            self.assertEqual(done.returncode, 0, done.stderr)
            self.assertIn("gps.unplug 3s", done.stdout)
            wait_for(said("lost " + str(self.ports / "gps")), 60, "the lost port")
            wait_for(lambda: self.events(log).count("opened " + str(self.ports / "gps")) == 2, 60, "the port's return")
            wait_for(said("ahrs: bytes again"), 60, "the unit's return")
            # Without end it would last an hour; "clear" is the end.
            self.assertEqual(order("gps.silent 3600s").returncode, 0)
            wait_for(said("gps: open, but no byte"), 60, "the silence")
            self.assertEqual(order("clear").returncode, 0)
            wait_for(said("gps: bytes again"), 60, "the receiver's return")
            self.assertEqual(chain.stop("onboard"), 0, chain.output("onboard"))
            self.assertEqual(chain.stop("sim"), 0, chain.output("sim"))
            self.assertEqual(chain.output("sim").count("fault order taken"), 3)

    def test_refusals_and_silence_are_honest(self):
        done = order("gps.unplug", "--timeout", "0.5")
        self.assertEqual(done.returncode, 2)
        self.assertIn("nobody answered on SIM.FAULT", done.stderr)
        with Processes(self.folder / "output") as chain:
            self.start_sim(chain, "--command-channel", "ROBOT7.FAULT")
            self.assertEqual(order("gps.unplug", "--timeout", "0.5").returncode, 2, "another channel")
            for text, why in (("gps.explode", "is none of"), ("t=0 gps.unplug 0.001s", "over before it was ordered")):
                done = order(text, "--command-channel", "ROBOT7.FAULT")
                self.assertEqual(done.returncode, 1, done.stdout)
                self.assertIn(why, done.stderr)
                self.assertIn(why, chain.output("sim"))
            self.assertEqual(chain.stop("sim"), 0, chain.output("sim"))
        done = order("gps.unplug", "--command-channel", "A|B")
        self.assertEqual(done.returncode, 2)
        self.assertIn("command channel 'A|B'", done.stderr)


if __name__ == "__main__":
    unittest.main()
