"""kawara-calibrate mounting as a process: a drive whose camera.yaml says a mounting some degrees off, and drives that cannot
tell it."""
import math
import pathlib
import re
import shutil
import tempfile
import unittest

from processes import run

# A camera turned by this about the body's forward, right and down axes, of which camera.yaml knows nothing [deg].
TURN = (1.0, -0.7, 1.3)
UPRIGHT = (math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0)  # w, x, y, z: camera axes up, right, forward in a body's forward, right, down


def product(a, b):
    w, x, y, z = a
    p, q, r, s = b
    return (w * p - x * q - y * r - z * s, w * q + x * p + y * s - z * r, w * r - x * s + y * p + z * q,
            w * s + x * r - y * q + z * p)


def turned(degrees, q):
    """q turned by a rotation vector about the body's axes."""
    angle = math.sqrt(sum(d * d for d in degrees))
    half = math.radians(angle) / 2
    return product((math.cos(half), *(math.sin(half) * d / angle for d in degrees)), q)


class MountingTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-mounting-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        # Curves to both sides, as the manual asks for.
        points = [f"{{at_m: [{x:.2f}, {-1.0 + 2.0 * math.sin(2 * math.pi * (x + 84) / 11):.2f}]}}"
                  for x in (-84 + 2.75 * i for i in range(11))]
        cls.survey = cls.folder / "survey"
        run("kawara-sim", "--render", cls.survey, "--set", f"path.points=[{', '.join(points)}]", "--doughnut-px", "768",
            "--samples", "3", "--every", "0.3", "--light-cell", "5", "--light-cache", "", timeout=300, check=True)
        # The simulator's camera stands upright; the file says it is turned, so the answer is the turn back.
        said = turned([-d for d in TURN], UPRIGHT)
        with open(cls.survey / "camera.yaml", "a") as file:
            file.write(f"mounting:\n  translation_m: [0, 0, 0]\n  quaternion_wxyz: [{', '.join(f'{v:.9f}' for v in said)}]\n"
                       "  axes: kawara\n")

    def mounting(self, *words, timeout=400):
        return run("kawara-calibrate", "mounting", *words, timeout=timeout)

    def test_the_turn_is_found_and_its_deviation_is_honest(self):
        out = self.folder / "mounting.yaml"
        done = self.mounting(self.survey, "--out", out)
        self.assertEqual(done.returncode, 0, done.stderr)
        numbers = re.search(r"turned by (\S+) (\S+) (\S+) deg \(\+- (\S+) (\S+) (\S+)\)", done.stdout).groups()
        turn, sd = [float(n) for n in numbers[:3]], [float(n) for n in numbers[3:]]
        found = [float(v) for v in re.search(r"quaternion_wxyz: \[(.*)\]", out.read_text()).group(1).split(",")]
        back = product(found, [UPRIGHT[0], *(-v for v in UPRIGHT[1:])])
        miss = [math.degrees(2 * math.copysign(v, v * back[0]) if back[0] else 0) for v in back[1:]]
        for axis in range(3):
            self.assertLess(sd[axis], 0.1, turn)
            self.assertLess(abs(miss[axis]), 3.5 * sd[axis], (miss, sd))
            self.assertLess(abs(turn[axis] - TURN[axis]), 0.2, turn)
        # And the file is one that a survey takes.
        survey = self.folder / "again"
        survey.mkdir()
        (survey / "frames").symlink_to(self.survey / "frames")
        shutil.copy(self.survey / "poses.csv", survey)
        camera = (self.survey / "camera.yaml").read_text()
        (survey / "camera.yaml").write_text(camera[:camera.index("mounting:")] + out.read_text())
        frames = sorted(p.stem for p in (self.survey / "frames").iterdir())
        done = run("kawara-mapper", survey, "--depth-only", frames[20], frames[22], "--out", self.folder / "ranges", timeout=120)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_a_drive_that_cannot_tell_is_refused_with_what_is_missing(self):
        survey = self.folder / "short"
        survey.mkdir()
        (survey / "frames").symlink_to(self.survey / "frames")
        shutil.copy(self.survey / "camera.yaml", survey)
        lines = (self.survey / "poses.csv").read_text().splitlines(keepends=True)
        out = self.folder / "none.yaml"
        for count, part in ((9, "a mounting needs 21 or more"), (30, "does not determine the mounting (turn about the ")):
            (survey / "poses.csv").write_text("".join(lines[:1 + count]))
            done = self.mounting(survey, "--out", out, "--step", "0.2", "--wanted", "0.02")
            self.assertEqual(done.returncode, 1, done.stderr)
            self.assertIn(part, done.stderr.strip().splitlines()[-1])
            self.assertFalse(out.exists())
        (survey / "poses.csv").write_text("".join(lines[:1] + lines[1:80:10]))
        done = self.mounting(survey, "--out", out)
        self.assertEqual(done.returncode, 1)
        self.assertIn("without gaps", done.stderr)

    def test_mistakes(self):
        for words, status, part in (((self.folder / "nowhere", "--out", "x.yaml"), 2, "nowhere"),
                                    ((self.survey, "--out", self.folder / "no" / "x.yaml"), 2, "x.yaml"),
                                    ((self.survey,), 2, "--out"),
                                    ((self.survey, "--out", "x.yaml", "--step", "9"), 2, "--step")):
            done = self.mounting(*words)
            self.assertEqual(done.returncode, status, done.stderr)
            self.assertIn(part, done.stderr)
            self.assertEqual(done.stdout, "")


if __name__ == "__main__":
    unittest.main()
