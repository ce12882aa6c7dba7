"""A small made-up mission as LCM messages: what a robot would publish, without a robot.

The message classes come from lcm-gen's Python output (pure Python, no lcm module needed); log records and UDP
datagrams are put together here after LCM's documentation (log-file-format, udp-multicast-protocol).
"""
import atexit
import importlib
import io
import math
import os
import shutil
import socket
import struct
import subprocess
import sys
import tempfile

GPS_START_NS = 1_479_363_923_000_000_000  # whole GPS second in November 2026
MISSION = "20261122T062505Z"
LOG_TIME_US = 1_795_328_705_000_000


def load_types():
    """The package kawara with all message classes."""
    folder = tempfile.mkdtemp(prefix="kawara-lcmtypes-")
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    source = os.path.join(os.environ["KAWARA_SOURCE_DIR"], "comms", "lcmtypes")
    files = [os.path.join(source, f) for f in sorted(os.listdir(source))]
    subprocess.run(["lcm-gen", "-p", "--ppath", folder, *files], check=True)
    sys.path.insert(0, folder)
    return importlib.import_module("kawara")


def jpeg(width, height, seed):
    from PIL import Image
    picture = Image.effect_noise((width, height), 40 + seed % 20).convert("RGB")
    picture.paste((seed * 37 % 255, seed * 91 % 255, 80), (0, 0, width // 4, height // 4))
    out = io.BytesIO()
    picture.save(out, "JPEG", quality=70)
    return out.getvalue()


class Mission:
    """Messages in the order a robot would publish them: list of (time [s], channel, bytes)."""

    def __init__(self, pictures=20, pose_hz=20, width=640, robot="rover-1", mission=MISSION):
        self.types = load_types()
        self.robot, self.mission, self.width = robot, mission, width
        self.messages = []
        steps = pictures * pose_hz
        self._put(0.0, "CONFIG", self._config())
        for step in range(1, steps + 1):
            t = step / pose_hz
            self._put(t, "POSE", self.robot_pose(t + 0.0123))
            if step % (pose_hz * 5) == 0:
                self._put(t, "EVENT", self.event(t))
            if step % pose_hz == 0:
                epoch = step // pose_hz
                self._put(t + 0.001, "POSE.EPOCH", self.robot_pose(t))
                for stage in (0, 1):
                    self._put(t + 0.01 + 0.02 * stage, "PHASE1", self.packet(epoch, stage, t))
        self.messages.sort(key=lambda m: m[0])

    def _put(self, t, channel, message):
        self.messages.append((t, channel, message.encode()))

    def _config(self):
        m = self.types.config_t()
        m.program, m.version, m.lcmtypes = "kawara-onboard", "test", ""
        m.yaml = "robot:\n  name: %s\n" % self.robot
        return m

    def pose(self, t):
        m = self.types.pose_t()
        m.gps_ns = GPS_START_NS + round(t * 1e9)
        m.mono_ns = round((1000 + t) * 1e9)
        m.valid = True
        m.rtk_state = 4 if t % 9 < 6 else 3
        a = t * 0.15
        m.lat_deg = 35.706 + 2e-4 * math.sin(a)
        m.lon_deg = 139.706 + 3e-4 * math.sin(0.5 * a)
        m.h_ellipsoidal_m = 61.0 + 0.2 * math.sin(t)
        m.roll_deg, m.pitch_deg, m.yaw_deg = 0.3, -0.2, (40.0 + 20.0 * t) % 360.0
        m.velocity_enu_mps = [0.5, 1.0, 0.0]
        m.position_cov_enu_m2 = [1e-4, 0, 0, 0, 1e-4, 0, 0, 0, 4e-4]
        m.attitude_sd_deg = [0.1, 0.1, 0.4]
        m.gnss_age_s = 0.05
        return m

    def robot_pose(self, t):
        m = self.types.robot_pose_t()
        m.robot, m.mission, m.pose = self.robot, self.mission, self.pose(t)
        return m

    def event(self, t):
        m = self.types.event_t()
        m.robot, m.mission = self.robot, self.mission
        m.mono_ns = round((1000 + t) * 1e9)
        m.gps_ns = GPS_START_NS + round(t * 1e9)
        m.severity, m.name, m.text, m.suppressed = 1, "gps.unplugged", "read: gone at %.1f" % t, 0
        return m

    def packet(self, epoch, stage, t):
        m = self.types.phase1_t()
        m.robot, m.mission, m.epoch, m.stage, m.reason = self.robot, self.mission, epoch, stage, 0
        m.pose = self.pose(t)
        m.gps_minus_utc_s = 18
        m.projection = "equirectangular"
        m.width = self.width if stage else self.width // 4
        m.height = m.width // 2
        m.jpeg = jpeg(m.width, m.height, epoch)
        m.n = len(m.jpeg)
        return m

    def write_log(self, path):
        with open(path, "wb") as f:
            for number, (t, channel, data) in enumerate(self.messages):
                f.write(log_record(number, LOG_TIME_US + round(t * 1e6), channel, data))


def log_record(number, time_us, channel, data):
    name = channel.encode()
    return struct.pack(">IqqII", 0xEDA1DA01, number, time_us, len(name), len(data)) + name + data


class Publisher:
    """Sends like liblcm to the default group, over the loopback of this network namespace."""
    GROUP = ("239.255.76.67", 7667)
    FRAGMENT = 60000

    def __init__(self):
        self.sequence = 0
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.socket.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, 0)
        self.socket.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, 4 << 20)

    def send(self, channel, data):
        name = channel.encode() + b"\0"
        if len(name) + len(data) <= self.FRAGMENT:
            self._datagram(struct.pack(">II", 0x4C433032, self.sequence) + name + data)
        else:
            first = self.FRAGMENT - len(name)
            parts = [data[:first]] + [data[i:i + self.FRAGMENT] for i in range(first, len(data), self.FRAGMENT)]
            offset = 0
            for i, part in enumerate(parts):
                head = struct.pack(">IIIIHH", 0x4C433033, self.sequence, len(data), offset, i, len(parts))
                self._datagram(head + (name if i == 0 else b"") + part)
                offset += len(part)
        self.sequence += 1

    def _datagram(self, data):
        self.socket.sendto(data, self.GROUP)
