"""kawara-onboard --check as somebody calls it who sets up a robot's computer."""
import os
import pathlib
import shutil
import socket
import subprocess
import tempfile
import threading
import unittest

from processes import BIN, SOURCE, Processes, run, wait_for

URL = f"udpm://239.255.76.67:{13700 + os.getpid() % 2000}?ttl=0"


class CheckTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-check-"))
        self.addCleanup(shutil.rmtree, self.folder)

    def words(self, ports, **more):
        values = {"gps.device": ports / "gps", "gps.pps.device": ports / "pps.sock", "ahrs.device": ports / "ahrs",
                  "camera.source": "none", "record.folder": self.folder / "log", "lcm_url": URL, **more}
        return ["--config", SOURCE / "configs/demo.yaml", "--check",
                *(word for key, value in values.items() for word in ("--set", f"{key}={value}"))]

    def test_a_robot_that_is_well(self):
        ports = self.folder / "ports"
        with Processes(self.folder / "output") as chain:
            chain.start("sim", "kawara-sim", "drive", "--data", SOURCE / "data/drive_0708", "--run-dir", ports, "--start", "100",
                        "--duration", "300", "--gps-baud", "115200", "--gps-preset", "streaming", "--lcm-url", URL)
            wait_for(lambda: (ports / "ready").exists(), 60, "the simulator's ports")
            done = run("kawara-onboard", *self.words(ports))
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            for line in (f"good   gps {ports}/gps: opens and speaks", f"good   pulse {ports}/pps.sock: comes",
                         f"good   LCM bus: {URL}", f"good   recording {self.folder}/log: "):
                self.assertIn(line, done.stdout)
            self.assertIn(" 0 wrong", done.stdout.splitlines()[-1])
            self.assertFalse((self.folder / "log").exists(), "a check records nothing")

    def test_what_is_wrong_is_named_and_the_exit_status_says_so(self):
        nowhere = self.folder / "nowhere"
        (self.folder / "log").write_text("not a folder")
        done = run("kawara-onboard", *self.words(nowhere))
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        wrong = [line for line in done.stdout.splitlines() if line.startswith("WRONG")]
        self.assertEqual(len(wrong), 4, done.stdout)
        for subject, line in zip(("recording", "gps", "ahrs", "pulse"), wrong):
            self.assertIn(subject, line)
        self.assertEqual(done.stderr, "")

    def check_caster(self, answer):
        """The check's line on corrections from a caster that answers so."""
        with socket.create_server(("127.0.0.1", 0)) as caster:
            def serve():
                with caster.accept()[0] as client:
                    client.recv(4096)
                    client.sendall(answer)
                    client.recv(4096)  # until the check hangs up

            thread = threading.Thread(target=serve, daemon=True)
            thread.start()
            done = run("kawara-onboard", *self.words(self.folder / "nowhere", **{
                "corrections.source": "ntrip", "corrections.host": "127.0.0.1", "corrections.port": caster.getsockname()[1],
                "corrections.mountpoint": "BASE"}))
            thread.join(10)
            return next(line for line in done.stdout.splitlines() if " corrections 127.0.0.1:" in line)

    def test_the_caster_is_asked_for_corrections(self):
        rtcm = (SOURCE / "tests/hil/test_check.py").read_bytes()[:200]  # whatever it sends: the robot sifts it
        self.assertRegex(self.check_caster(b"ICY 200 OK\r\n\r\n" + rtcm), r"^good .*: stream BASE comes$")
        self.assertRegex(self.check_caster(b"HTTP/1.1 401 Unauthorized\r\n\r\n"), r"^WRONG .*user.*password")
        self.assertRegex(self.check_caster(b"ICY 200 OK\r\n\r\n"), r"^weak .*nothing comes.*position")

    def test_an_ordinary_user_is_told_the_rights_that_are_missing(self):
        if os.geteuid() != 0:
            self.skipTest("this user cannot become another; the rights shown are its own")
        self.folder.chmod(0o755)
        program = self.folder / "kawara-onboard"
        shutil.copy(BIN / "kawara-onboard", program)
        config = shutil.copy(SOURCE / "configs/demo.yaml", self.folder)
        words = [str(word) for word in self.words(self.folder / "nowhere")]
        words[1] = str(config)
        done = subprocess.run([str(program), *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, timeout=120,
                              user=65534, group=65534, extra_groups=[])
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        self.assertRegex(done.stdout, r"weak   real-time priority: .*ulimit -r")
        self.assertRegex(done.stdout, r"weak   locked memory: .*ulimit -l")
        self.assertRegex(done.stdout, r"WRONG  recording .*this user may not write into .*sudo chown")


if __name__ == "__main__":
    unittest.main()
