"""LCM's own programs and ours on the same bus and the same logs, in a network namespace of their own."""
import os
import pathlib
import shutil
import signal
import subprocess
import tempfile
import unittest

import lcm_log

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
TYPES = pathlib.Path(os.environ["KAWARA_SOURCE_DIR"]) / "comms" / "lcmtypes"
COUNT = 200


@unittest.skipUnless(os.geteuid() == 0 and shutil.which("lcm-logplayer"), "needs root and Debian's liblcm-bin")
class LcmTools(unittest.TestCase):
    def test_logplayer_plays_a_log_of_ours_to_logger(self):
        """Also through our reader and writer: kawara-log cut makes the log that lcm-logplayer reads."""
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            event = lcm_log.Type((TYPES / "event_t.lcm").read_text())
            messages = [event.encode(mono_ns=i, name="test", text="x" * i) for i in range(COUNT)]
            (folder / "in.lcmlog").write_bytes(
                b"".join(lcm_log.record(i, 1_700_000_000_000_000 + i * 2000, "EVENT", m) for i, m in enumerate(messages)))
            subprocess.run([BIN / "kawara-log", "cut", folder / "in.lcmlog", "--out", folder / "ours.lcmlog"],
                           check=True, stdout=subprocess.DEVNULL)
            script = f"""
                ip link set lo up multicast on && ip route add 224.0.0.0/4 dev lo || exit 1
                lcm-logger -q {folder}/heard & logger=$!
                for i in $(seq 100); do [ -e {folder}/heard* ] && break; sleep 0.1; done
                sleep 0.5
                lcm-logplayer {folder}/ours.lcmlog
                sleep 0.5
                kill -INT $logger
                wait $logger
            """
            process = subprocess.Popen(["unshare", "-n", "bash", "-c", script], stdout=subprocess.DEVNULL,
                                       stderr=subprocess.PIPE, text=True, start_new_session=True)
            try:
                _, errors = process.communicate(timeout=60)
            except subprocess.TimeoutExpired:
                os.killpg(process.pid, signal.SIGKILL)
                raise
            heard = [data for path in folder.glob("heard*") for _, _, channel, data in lcm_log.records(path.read_bytes())
                     if channel == "EVENT"]
            self.assertEqual(heard, messages, errors)


if __name__ == "__main__":
    unittest.main()
