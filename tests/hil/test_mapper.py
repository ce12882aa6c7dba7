"""kawara-mapper as a process, on a survey folder that kawara-sim renders: ranges against the rendered truth, and every
mistake a user can make."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

import numpy as np
from PIL import Image

BIN = pathlib.Path(os.environ["KAWARA_BIN"])


def mapper(*words):
    return subprocess.run([BIN / "kawara-mapper", *map(str, words)], capture_output=True, text=True, timeout=300)


def read_pfm(path):
    kind, size, scale, rows = path.read_bytes().split(b"\n", 3)
    assert kind == b"Pf" and float(scale) < 0
    width, height = map(int, size.split())
    return np.frombuffer(rows, "<f4").reshape(height, width)[::-1]


class MapperTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-mapper-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.survey = cls.folder / "survey"
        subprocess.run([BIN / "kawara-sim", "--render", cls.survey, "--doughnut-px", "512", "--every", "0.5", "--start", "20",
                        "--duration", "1", "--pose-noise", "0", "--attitude-noise", "0", "--light-cell", "5",
                        "--light-cache", "", "--no-body"], check=True, capture_output=True, timeout=300)

    def test_ranges_of_a_rendered_street(self):
        out = self.folder / "ranges"
        run = mapper(self.survey, "--depth-only", "00001", "00002", "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("baseline 0.5", run.stdout)
        truth = np.array(Image.open(self.survey / "range" / "00001.png")) / 1000.0
        ranges, sd = read_pfm(out / "00001_00002.range.pfm"), read_pfm(out / "00001_00002.sd.pfm")
        near = (truth > 2.0) & (truth < 6.0)
        known = near & np.isfinite(ranges)
        error = np.abs(ranges - truth)[known]
        self.assertGreater(known.sum() / near.sum(), 0.5)  # asphalt is plain at this size
        self.assertLess(np.median(error), 0.10)
        self.assertLess((error > 0.1 * truth[known]).mean(), 0.15)
        self.assertTrue((np.isfinite(ranges) == np.isfinite(sd)).all())
        millimetres = np.array(Image.open(out / "00001_00002.range.png"))
        finite = np.isfinite(ranges) & (ranges < 65.0)
        self.assertLess(np.abs(millimetres[finite] / 1000.0 - ranges[finite]).max(), 0.00051)
        self.assertTrue((millimetres[~np.isfinite(ranges)] == 0).all())
        self.assertEqual(Image.open(out / "00001_00002.view.png").size, (512, 512))
        self.assertEqual(sorted(p.suffix for p in out.iterdir()), [".pfm", ".pfm", ".png", ".png", ".png"])

    def test_mistakes_are_answered_in_one_line(self):
        bad = self.folder / "bad"
        shutil.copytree(self.survey, bad)
        (bad / "camera.yaml").write_text("camera: doughnut\ndoughnut:\n  width: 3\n")
        torn = self.folder / "torn"
        shutil.copytree(self.survey, torn)
        (torn / "frames" / "00002.jpg").write_bytes((torn / "frames" / "00002.jpg").read_bytes()[:2000])
        (self.folder / "file").write_text("")
        out = self.folder / "nothing"
        for words, status, said in (
                ((self.folder / "none", "--depth-only", "1", "2"), 2, "none: no such folder"),
                ((self.survey, "--depth-only", "00001", "77777"), 2, "no frame '77777'"),
                ((self.survey, "--depth-only", "00001", "00001"), 2, "same place"),
                ((self.survey, "--depth-only", "00001"), 2, "depth-only"),
                ((self.survey,), 2, "--depth-only is required"),
                ((bad, "--depth-only", "00001", "00002"), 1, "camera.yaml:"),
                ((torn, "--depth-only", "00001", "00002"), 1, "00002.jpg: the picture ends early"),
                ((self.survey, "--depth-only", "00001", "00002", "--out", self.folder / "file"), 1, "file"),
                ((self.survey, "--depth-only", "00001", "00002", "--nearest", "-1"), 2, "--nearest")):
            with self.subTest(words=words[1:]):
                run = mapper(*words, *([] if "--out" in words else ["--out", out]))
                self.assertEqual(run.returncode, status, run.stderr)
                self.assertIn(said, run.stderr)
                self.assertTrue(run.stderr.startswith("kawara-mapper: "), run.stderr)
                self.assertEqual(run.stdout, "")


if __name__ == "__main__":
    unittest.main()
