"""kawara-onboard under a service manager: it says that it is ready, that it lives while it does, and that it ends."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import tempfile
import unittest

from processes import BIN, SOURCE

URL = f"udpm://239.255.76.67:{15700 + os.getpid() % 2000}?ttl=0"


class ServiceTest(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-service-"))
        self.addCleanup(shutil.rmtree, self.folder)
        self.manager = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM)
        self.addCleanup(self.manager.close)
        self.manager.bind(str(self.folder / "notify"))

    def heard(self, seconds):
        self.manager.settimeout(seconds)
        try:
            return self.manager.recv(4096).decode()
        except TimeoutError:
            return None

    def test_ready_alive_stopping(self):
        environment = {**os.environ, "NOTIFY_SOCKET": str(self.folder / "notify"), "WATCHDOG_USEC": "1000000"}
        environment.pop("WATCHDOG_PID", None)
        with open(self.folder / "out", "wb") as out:
            robot = subprocess.Popen(
                [str(BIN / "kawara-onboard"), "--config", str(SOURCE / "configs/demo.yaml"), "--set",
                 f"gps.device={self.folder}/gps", "--set", f"ahrs.device={self.folder}/ahrs", "--set", "camera.source=none",
                 "--set", f"record.folder={self.folder}/log", "--set", f"lcm_url={URL}"],
                env=environment, stdin=subprocess.DEVNULL, stdout=out, stderr=out)
        try:
            said = (self.folder / "out")
            self.assertEqual(self.heard(60), "READY=1", said.read_text())
            for _ in range(4):
                self.assertEqual(self.heard(60), "WATCHDOG=1", said.read_text())
            # One that stands still says nothing: a service manager would end it and start another.
            robot.send_signal(signal.SIGSTOP)
            while self.heard(2) is not None:
                pass
            robot.send_signal(signal.SIGCONT)
            self.assertEqual(self.heard(60), "WATCHDOG=1")
            robot.send_signal(signal.SIGTERM)
            last = self.heard(60)
            while last == "WATCHDOG=1":
                last = self.heard(60)
            self.assertEqual(last, "STOPPING=1")
            self.assertEqual(robot.wait(60), 0, said.read_text())
        finally:
            if robot.poll() is None:
                robot.kill()
                robot.wait()


if __name__ == "__main__":
    unittest.main()
