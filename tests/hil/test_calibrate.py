"""kawara-calibrate as a process: rendered pictures of a board in, the camera that made them out; and every mistake a
user can make."""
import math
import os
import pathlib
import re
import shutil
import subprocess
import tempfile
import unittest
import xml.dom.minidom

import numpy as np
from PIL import Image

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
PICTURES = 24


def calibrate(*words):
    return subprocess.run([BIN / "kawara-calibrate", *map(str, words)], capture_output=True, text=True, timeout=300)


def kb4_pixel(numbers, k, ray):
    """kb4 written down once more. `ray` in camera axes (X up, Y right, Z forward)."""
    x, y, z = ray[1], -ray[0], ray[2]
    a = math.atan2(math.hypot(x, y), z)
    r = a + sum(c * a ** (2 * i + 3) for i, c in enumerate(k))
    rho = math.hypot(x, y)
    return numbers["center_u_px"] + numbers["fx_px"] * r * x / rho, numbers["center_v_px"] + numbers["fy_px"] * r * y / rho


class CalibrateTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-calibrate-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.pictures = cls.folder / "pictures"
        cls.pictures.mkdir()
        subprocess.run([BIN / "render_boards", cls.pictures, str(PICTURES)], check=True, timeout=300)
        cls.common = ["--board", "9x6", "--square", "0.03", "--out", cls.folder / "camera.yaml"]

    def refused(self, words, status, *parts):
        done = calibrate(*words)
        self.assertEqual(done.returncode, status, done.stderr)
        self.assertEqual(done.stdout, "")
        last = done.stderr.strip().splitlines()[-1]
        for part in parts:
            self.assertIn(part, last)
        self.assertEqual(list(self.folder.rglob("*.part")), [])

    def few(self, name, pictures):
        folder = self.folder / name
        folder.mkdir()
        for i in pictures:
            shutil.copy(self.pictures / f"{i:02d}.png", folder)
        return folder

    def test_the_camera_that_made_the_pictures(self):
        report = self.folder / "report.html"
        done = calibrate("board", self.pictures, *self.common, "--model", "kb", "--report", report)
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn(f"{PICTURES} of {PICTURES} pictures show the board", done.stdout)
        text = (self.folder / "camera.yaml").read_text()
        numbers = {n: float(v) for n, v in re.findall(r"^  (\w+): (-?[\d.e+-]+)$", text, re.M)}
        k = [float(v) for v in re.search(r"k: \[(.*)\]", text)[1].split(",")]
        misses = []
        for line in (self.pictures / "truth.txt").read_text().splitlines():
            u, v, *ray = map(float, line.split())
            x, y = kb4_pixel(numbers, k, ray)
            if math.hypot(u - 404.3, v - 396.1) < 370:
                misses.append((x - u) ** 2 + (y - v) ** 2)
        self.assertGreater(len(misses), 200)
        self.assertLess(math.sqrt(sum(misses) / len(misses)), 0.05)
        self.assertRegex(text, r"#   fx_px +225\.\d+ \+- 0\.0\d+")
        page = report.read_text()
        self.assertEqual(page.count("<svg"), 3)
        for svg in re.findall(r"<svg.*?</svg>", page, re.S):
            xml.dom.minidom.parseString(svg)
        self.assertEqual(page.count(".png</th>"), PICTURES)

    def test_pictures_that_are_no_use_are_left_out_and_named(self):
        folder = self.few("mixed", range(16))
        (folder / "16.png").write_bytes(b"not a picture")
        Image.fromarray(np.zeros((100, 100, 3), np.uint8)).save(folder / "17.png")
        Image.fromarray(np.full((800, 800, 3), 90, np.uint8)).save(folder / "18.png")
        done = calibrate("board", folder, *self.common, "--model", "kb")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertIn("16 of 17 pictures show the board", done.stdout)
        self.assertRegex(done.stderr, "warning: left out: .*16.png")
        self.assertRegex(done.stderr, "warning: left out: .*17.png has 100x100 px")
        self.assertIn("in 1 of 17 pictures: 18.png", done.stderr)

    def test_a_side_without_boards_is_named(self):
        # Held at the golden angle, one after the other; to the right and below only.
        folder = self.few("side", [i for i in range(PICTURES) if 2.39996 * i % (2 * math.pi) < 1.5])
        done = calibrate("board", folder, *self.common, "--model", "eucm")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertRegex(done.stderr, r"cells only, half and more of it is empty at \d.*o'clock")
        self.assertIn("10 to 20 are good", done.stderr)

    def test_mistakes(self):
        empty = self.folder / "empty"
        empty.mkdir()
        self.refused(["board", self.folder / "none", *self.common], 2, "none: No such file or directory")
        self.refused(["board", empty, *self.common], 2, "empty: no pictures in it")
        self.refused(["board", self.few("two", [0, 1]), *self.common], 1, "2 pictures show the board: at least 3")
        some = self.few("some", [0, 1, 2])
        self.refused(["board", some, "--board", "7x5", "--square", "0.03", "--out", self.folder / "c.yaml"], 1,
                     "no board of 7x5 inner corners in any of 3 pictures", "inner corners instead")
        self.refused(["board", some, "--board", "9", "--square", "0.03", "--out", self.folder / "c.yaml"], 2,
                     "--board 9: expected COLSxROWS inner corners")
        self.refused(["board", some, *self.common, "--model", "best"], 2, "--model best: expected one of auto, doughnut")
        self.refused(["board", some, *self.common, "--axis", "left"], 2, "--axis left: expected forward, up or down")
        self.refused(["board", some, *self.common[:-1], self.folder / "no" / "camera.yaml"], 2, "camera.yaml")
        self.refused(["board", some, *self.common[:2], "--square", "-1", "--out", "x"], 2, "--square")
        plain = self.folder / "plain"
        plain.mkdir()
        Image.fromarray(np.full((400, 400, 3), 90, np.uint8)).save(plain / "a.png")
        self.refused(["board", plain, *self.common], 1, "no board of 9x6 inner corners in any of 1 pictures (a.png)")
        (plain / "a.png").write_bytes(b"x")
        self.refused(["board", plain, *self.common], 1, "none of 1 pictures can be read")


if __name__ == "__main__":
    unittest.main()
