"""kawara-mapper as a process, on a survey folder that kawara-sim renders: ranges against the rendered truth, and every
mistake a user can make."""
import contextlib
import csv
import hashlib
import json
import os
import pathlib
import re
import shutil
import signal
import struct
import subprocess
import tempfile
import time
import unittest

import numpy as np
from PIL import Image

from processes import wait_for

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
SOURCE = pathlib.Path(os.environ["KAWARA_SOURCE_DIR"])


def mapper(*words):
    return subprocess.run([BIN / "kawara-mapper", *map(str, words)], capture_output=True, text=True, timeout=300)


def read_pfm(path):
    kind, size, scale, rows = path.read_bytes().split(b"\n", 3)
    assert kind == b"Pf" and float(scale) < 0
    width, height = map(int, size.split())
    return np.frombuffer(rows, "<f4").reshape(height, width)[::-1]


def las_heights(path):
    las = path.read_bytes()
    offset, = struct.unpack_from("<I", las, 96)
    length, = struct.unpack_from("<H", las, 105)
    count, = struct.unpack_from("<Q", las, 247)
    raw = np.frombuffer(las, np.uint8, count * length, offset).reshape(count, length)
    return raw[:, 8:12].copy().view("<i4")[:, 0] * struct.unpack_from("<d", las, 147)[0] + struct.unpack_from("<d", las, 171)[0]


def files_of(folder):
    return {p.name: hashlib.sha256(p.read_bytes()).hexdigest() for p in folder.iterdir() if p.name != "voxels.spill"}


class MapperTest(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-mapper-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.survey = cls.folder / "survey"
        subprocess.run([BIN / "kawara-sim", "--render", cls.survey, "--doughnut-px", "512", "--every", "0.5", "--start", "20",
                        "--duration", "2", "--pose-noise", "0", "--attitude-noise", "0", "--light-cell", "5",
                        "--light-cache", "", "--no-body"], check=True, capture_output=True, timeout=300)

    def test_ranges_of_a_rendered_street(self):
        out = self.folder / "ranges"
        run = mapper(self.survey, "--depth-only", "00001", "00002", "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("baseline 0.5", run.stdout)
        with Image.open(self.survey / "range" / "00001.png") as picture:
            truth = np.array(picture) / 1000.0
        ranges, sd = read_pfm(out / "00001_00002.range.pfm"), read_pfm(out / "00001_00002.sd.pfm")
        near = (truth > 2.0) & (truth < 6.0)
        known = near & np.isfinite(ranges)
        error = np.abs(ranges - truth)[known]
        self.assertGreater(known.sum() / near.sum(), 0.5)  # asphalt is plain at this size
        self.assertLess(np.median(error), 0.10)
        self.assertLess((error > 0.1 * truth[known]).mean(), 0.15)
        self.assertTrue((np.isfinite(ranges) == np.isfinite(sd)).all())
        with Image.open(out / "00001_00002.range.png") as picture:
            millimetres = np.array(picture)
        finite = np.isfinite(ranges) & (ranges < 65.0)
        self.assertLess(np.abs(millimetres[finite] / 1000.0 - ranges[finite]).max(), 0.00051)
        self.assertTrue((millimetres[~np.isfinite(ranges)] == 0).all())
        with Image.open(out / "00001_00002.view.png") as view:
            self.assertEqual(view.size, (512, 512))
        self.assertEqual(sorted(p.suffix for p in out.iterdir()), [".pfm", ".pfm", ".png", ".png", ".png"])

    def test_ranges_by_the_papers_method(self):
        out = self.folder / "paper"
        run = mapper(self.survey, "--depth-only", "00001", "00002", "--method", "paper", "--given-poses", "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        with Image.open(self.survey / "range" / "00001.png") as picture:
            truth = np.array(picture) / 1000.0
        ranges, sd = read_pfm(out / "00001_00002.range.pfm"), read_pfm(out / "00001_00002.sd.pfm")
        self.assertLess(np.isfinite(ranges).mean(), 0.2)  # edges only
        self.assertTrue((np.isfinite(ranges) == np.isfinite(sd)).all())
        # Of the houses' windows; the lines on the road run with the robot and could be anywhere.
        sure = (truth > 6.0) & (truth < 20.0) & (sd < 0.1 * ranges)
        self.assertGreater(sure.sum(), 1000)
        self.assertLess(np.median(np.abs(ranges - truth)[sure] / truth[sure]), 0.05)

    def test_what_is_near_is_looked_for_by_itself(self):
        # A camera that sees the ground below, 1.2 m away, nearer than three baselines.
        camera = self.folder / "whole.yaml"
        camera.write_text("camera: equirectangular\nequirectangular: {width_px: 960, height_px: 480}\n")
        survey = self.folder / "near"
        subprocess.run([BIN / "kawara-sim", "--render", survey, "--camera", camera, "--every", "0.5", "--start", "20", "--duration", "1",
                        "--pose-noise", "0", "--attitude-noise", "0", "--light-cell", "5", "--light-cache", "", "--no-body"],
                       check=True, capture_output=True, timeout=300)
        truth = np.asarray(Image.open(survey / "range" / "00001.png")).astype(float) / 1000
        near = (truth > 1.0) & (truth < 2.0)
        self.assertGreater(near.sum(), 50000)

        def judge(*words):
            out = self.folder / "near_out"
            run = mapper(survey, "--depth-only", "00001", "00002", "--given-poses", "--out", out, *words)
            self.assertEqual(run.returncode, 0, run.stderr)
            found = read_pfm(out / "00001_00002.range.pfm")[near]
            known = np.isfinite(found)
            return known.mean(), (np.abs(found - truth[near])[known] > 0.1 * truth[near][known]).mean()

        known, wrong = judge()
        self.assertGreater(known, 0.7)
        self.assertLess(wrong, 0.02)
        known_beyond, wrong_beyond = judge("--nearest", "1.5")
        self.assertLess(known_beyond, known)
        self.assertGreater(wrong_beyond, wrong)

    def test_poses_with_noise_are_refined_on_the_pictures(self):
        noisy = self.folder / "noisy"
        shutil.copytree(self.survey, noisy)
        with open(self.survey / "poses.csv", encoding="ascii", newline="") as file:
            rows = list(csv.DictReader(file))
        dice = np.random.default_rng(1)
        for row in rows:
            row["lat_deg"] = f"{float(row['lat_deg']) + dice.normal(0, 0.02) / 111e3:.11f}"
            row["h_ellipsoidal_m"] = f"{float(row['h_ellipsoidal_m']) + dice.normal(0, 0.02):.5f}"
            for angle in ("roll_deg", "pitch_deg", "yaw_deg"):
                row[angle] = f"{float(row[angle]) + dice.normal(0, 0.15):.6f}"
            row.update(sd_east_m=0.02, sd_north_m=0.02, sd_up_m=0.02, sd_attitude_deg=0.15)
        with open(noisy / "poses.csv", "w", encoding="ascii", newline="") as file:
            table = csv.DictWriter(file, rows[0].keys())
            table.writeheader()
            table.writerows(rows)
        with Image.open(self.survey / "range" / "00002.png") as picture:
            truth = np.array(picture) / 1000.0
        near = (truth > 2.0) & (truth < 6.0)
        median = {}
        for name, words in (("given", ["--given-poses"]), ("refined", [])):
            out = self.folder / name
            run = mapper(noisy, "--depth-only", "00002", "00003", "--out", out, *words)
            self.assertEqual(run.returncode, 0, run.stderr)
            self.assertEqual("poses refined on" in run.stdout, name == "refined")
            ranges = read_pfm(out / "00002_00003.range.pfm")
            known = near & np.isfinite(ranges)
            median[name] = np.median(np.abs(ranges - truth)[known]), known.sum()
        self.assertLess(median["refined"][0], 0.12)
        self.assertGreater(median["refined"][1], 2 * median["given"][1])

    def test_other_peoples_folders(self):
        """The same drive as others would have written it: the distance image stays what it is."""
        def pictures(change):
            def edit(survey):
                for path in sorted((survey / "frames").iterdir()):
                    with Image.open(path) as picture:
                        changed = change(np.array(picture), int(path.stem))
                    path.unlink()
                    changed.save(path.with_suffix(".png"))
            return edit

        def grey16(rgb):
            return np.array(Image.fromarray(rgb).convert("L")).astype(np.uint16) * 257

        def exposed(factor):
            return pictures(lambda rgb, i: Image.fromarray((rgb * factor(i) + 0.5).astype(np.uint8)))

        def table(change, **style):
            def edit(survey):
                with open(survey / "poses.csv", encoding="utf-8", newline="") as file:
                    rows = change(list(csv.DictReader(file)))
                with open(survey / "poses.csv", "w", encoding="utf-8", newline="") as file:
                    writer = csv.DictWriter(file, rows[0].keys(), **style)
                    writer.writeheader()
                    writer.writerows(rows)
            return edit

        def text(change):
            return lambda survey: (survey / "poses.csv").write_bytes(change((survey / "poses.csv").read_bytes()))

        def odd_names(survey):
            for path in (survey / "frames").iterdir():
                path.rename(path.with_name(f"IMG {path.stem} (\u00fc).JPEG"))
            table(lambda rows: [{**row, "frame": f"IMG {row['frame']} (\u00fc).JPEG"} for row in rows])(survey)

        def litter(survey):
            odd_names(survey)
            for name in ("Thumbs.db", ".DS_Store", "._IMG 00001 (\u00fc).JPEG"):
                (survey / "frames" / name).write_bytes(b"no picture")

        def outage(rows):
            return [{**row, **({"lat_deg": "nan", "lon_deg": "", "h_ellipsoidal_m": "NaN"} if row is rows[-1] else {})} for row in rows]

        plain = ("00001", "00002")
        odd = ("IMG 00001 (\u00fc)", "IMG 00002 (\u00fc)")
        with Image.open(self.survey / "range" / "00001.png") as picture:
            truth = np.array(picture) / 1000.0
        near = (truth > 2.0) & (truth < 6.0)
        known = {}
        for name, edit, frames in (
                ("as it is", lambda survey: None, plain),
                ("grey", pictures(lambda rgb, _: Image.fromarray(rgb).convert("L")), plain),
                ("grey, 16 bits", pictures(lambda rgb, _: Image.fromarray(grey16(rgb))), plain),
                ("with alpha", pictures(lambda rgb, _: Image.fromarray(rgb).convert("RGBA")), plain),
                ("second exposed 30 % less", exposed(lambda i: (0.7, 1.0)[i % 2]), plain),
                ("first exposed 30 % less", exposed(lambda i: (1.0, 0.7)[i % 2]), plain),
                ("lines of Windows, no last end", text(lambda b: b.replace(b"\r\n", b"\n").rstrip().replace(b"\n", b"\r\n")), plain),
                ("other columns, with commas", table(lambda rows: [{"note": "a, b", **row, "fix": "RTK, fixed"} for row in rows]), plain),
                ("all in quotes", table(lambda rows: rows, quoting=csv.QUOTE_ALL), plain),
                ("decimal commas", text(lambda b: b.replace(b",", b";").replace(b".", b",")), plain),
                ("a row without a place", table(outage), plain),
                ("a picture gone", lambda survey: (survey / "frames" / "00003.jpg").unlink(), plain),
                ("odd names", odd_names, odd),
                ("other files beside", litter, odd),
                ("frames as a shell writes them", lambda survey: None, ("frames/00001.jpg", "frames/00002.jpg"))):
            with self.subTest(name):
                survey, out = self.folder / "others" / name, self.folder / "others_ranges" / name
                shutil.copytree(self.survey, survey)
                edit(survey)
                run = mapper(survey, "--depth-only", *frames, "--out", out)
                self.assertEqual(run.returncode, 0, run.stderr)
                ranges = read_pfm(next(out.glob("*.range.pfm")))
                found = near & np.isfinite(ranges)
                known[name] = found.sum()
                self.assertLess(np.median(np.abs(ranges - truth)[found]), 0.10)
                # What is measured is seen in the first picture: darker, more of the asphalt is plain.
                share = 0.75 if name == "first exposed 30 % less" else 0.85
                self.assertGreater(known[name], share * known["as it is"])

    def test_several_baselines_are_mistaken_less(self):
        """On plain asphalt what the baselines do not agree about stays unknown."""
        outliers, nmad = {}, {}
        for baselines in ("one", "several"):
            page = self.folder / f"{baselines}.html"
            run = mapper(self.survey, "--out", self.folder / baselines, "--report", page, "--baselines", baselines)
            self.assertEqual(run.returncode, 0, run.stderr)
            text = page.read_text()
            self.assertRegex(text, rf"baselines</th><td[^>]*>{baselines}<")
            near = re.search("2\u20136 m</th>((?:<td>[^<]*</td>)+)", text)[1]
            nmad[baselines] = float(re.findall(r"<td>([-0-9.]+) mm</td>", near)[1])
            outliers[baselines] = float(re.findall(r"<td>([0-9.]+) %</td>", near)[0])
        self.assertLess(outliers["several"], outliers["one"])
        self.assertLess(nmad["several"], nmad["one"])

    def test_model_of_a_rendered_street(self):
        out = self.folder / "model"
        run = mapper(self.survey, "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        names = re.findall(r'Inline { url "(\S+)\.wrl" }', (out / "model.wrl").read_text())
        self.assertGreater(len(names), 0)
        faces = 0
        for name in names:
            self.assertTrue((out / f"{name}.wrl").read_text().startswith("#VRML V2.0 utf8\n"))
            textures = re.findall(r'ImageTexture\s*{\s*url\s*\[?\s*"([^"]+)"', (out / f"{name}.wrl").read_text())
            self.assertEqual(len(textures), 1)
            with Image.open(out / textures[0]) as atlas:
                self.assertEqual(atlas.format, "JPEG")
            glb = (out / f"{name}.glb").read_bytes()
            magic, version, size, json_size = struct.unpack_from("<4sIII", glb)
            self.assertEqual((magic, version, size), (b"glTF", 2, len(glb)))
            gltf = json.loads(glb[20:20 + json_size])
            faces += sum(gltf["accessors"][p["indices"]]["count"] // 3 for m in gltf["meshes"] for p in m["primitives"])
        said = int(re.search(r"(\d+) faces", run.stdout)[1])
        self.assertEqual(faces, 2 * said)
        self.assertGreater(said, 1000)
        tileset = json.loads((out / "tileset.json").read_text())
        self.assertEqual(len(tileset["root"]["children"]), len(names))
        for name in names:
            self.assertTrue((out / f"{name}.ply").read_bytes().startswith(b"ply\nformat binary_little_endian"))
        # The road is flat there, and poses.csv tells the camera's height.
        height = np.concatenate([las_heights(out / f"{name}.las") for name in names])
        with open(self.survey / "poses.csv", encoding="ascii") as poses:
            camera = float(next(csv.DictReader(poses))["h_ellipsoidal_m"])
        road = camera - np.median(height)
        self.assertAlmostEqual(road, 0.25 + 0.95, delta=0.05)  # configs/vehicles/survey_robot.yaml
        self.assertGreater((np.abs(height - np.median(height)) < 0.3).mean(), 0.6)

    def test_killed_at_any_moment_the_same_command_goes_on(self):
        self.kill_and_go_on("one")

    def test_killed_at_any_moment_several_baselines_go_on(self):
        self.kill_and_go_on("several")

    def kill_and_go_on(self, baselines):
        """With the survey's own poses the model is the same to the byte; refined ones are of a window that starts anew.

        Pictures that never come, named pipes, keep each run from its end before it is killed, however fast the machine."""
        whole, out, survey = self.folder / f"whole_{baselines}", self.folder / f"killed_{baselines}", self.folder / "long"
        if not survey.exists():
            subprocess.run([BIN / "kawara-sim", "--render", survey, "--doughnut-px", "320", "--every", "0.25", "--start", "20",
                            "--duration", "14", "--light-cell", "5", "--light-cache", "", "--no-body"], check=True,
                           capture_output=True, timeout=300)
        words = [survey, "--given-poses", "--baselines", baselines]
        self.assertEqual(mapper(*words, "--out", whole).returncode, 0)
        frames = sorted((survey / "frames").iterdir())
        self.assertGreater(len(frames), 55)
        dice = np.random.default_rng(4)

        def stops_done():
            with contextlib.suppress(FileNotFoundError):
                return int(re.search(r"^stops_done: (\d+)", (out / "model.yaml").read_text(), re.M)[1])
            return 0

        aside = self.folder / f"aside_{baselines}"
        aside.mkdir()
        for missing in range(14, 56, 13):
            before = stops_done()
            for frame in frames[missing:]:
                frame.rename(aside / frame.name)
                os.mkfifo(frame)
            with subprocess.Popen([BIN / "kawara-mapper", *map(str, words), "--out", out], stdout=subprocess.DEVNULL,
                                  stderr=subprocess.PIPE, text=True) as run:
                try:
                    # Thirteen pictures more than the run before had: at least one commit.
                    wait_for(lambda: stops_done() > before or run.poll() is not None, 120, "a commit")
                    time.sleep(dice.uniform(0.0, 0.2))  # whatever it is doing then
                    self.assertIsNone(run.poll(), "it ended without one of its pictures")
                finally:
                    run.kill()
                self.assertEqual("goes on with stop" in run.stderr.read(), before > 0)
            for frame in frames[missing:]:
                (aside / frame.name).replace(frame)
        run = mapper(*words, "--out", out)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("goes on with stop", run.stderr)
        self.assertEqual(files_of(out), files_of(whole))
        again = mapper(*words, "--out", out)
        self.assertEqual(again.returncode, 0)
        self.assertIn("is complete", again.stderr)
        self.assertEqual(files_of(out), files_of(whole))
        other = mapper(*words, "--out", out, "--voxel", "0.2")
        self.assertEqual(other.returncode, 2)
        self.assertIn("--fresh", other.stderr)
        self.assertEqual(mapper(*words, "--out", out, "--voxel", "0.2", "--fresh").returncode, 0)

    def test_report_of_a_survey_with_true_ranges(self):
        """The page's figures are those of the distance images, and a model that was there already gets the same page."""
        out = self.folder / "reported"
        self.assertEqual(mapper(self.survey, "--out", out).returncode, 0)
        before = files_of(out)
        pages = [out / "report.html", self.folder / "pages" / "report.html"]
        run = mapper(self.survey, "--out", out, "--report", pages[0])
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertIn("only the report is made", run.stderr)
        self.assertEqual({name: file for name, file in files_of(out).items() if name != "report.html"}, before)
        run = mapper(self.survey, "--out", self.folder / "reported_at_once", "--report", pages[1])
        self.assertEqual(run.returncode, 0, run.stderr)
        pairs = int(re.search(r"(\d+) pairs in", run.stdout)[1])
        tables = []
        for page in (page.read_text() for page in pages):
            self.assertIn(f"<p>{pairs} distance images.", page)
            table = dict(re.findall(r'<tr><th scope="row">([^<]*)</th>((?:<td>[^<]*</td>)+)</tr>',
                                    page[page.index("<h2>Accuracy"):page.index("<h2>Distance images")]))
            self.assertIn("2\u20136 m", table)
            tables.append(table)
            self.assertEqual(len(re.findall("data:image/jpeg", page)), pairs + 3)  # pictures and views
            self.assertEqual(len(re.findall("data:image/png", page)), pairs)
            self.assertEqual(re.findall(r'(?:src|href)="(?!data:|\./)', page), [])
        self.assertEqual(tables[0], tables[1])
        for page, link in zip(pages, ("./model.wrl", "./../reported_at_once/model.wrl")):
            self.assertIn(f'href="{link}"', page.read_text())
        std, nmad = (float(re.findall(r"<td>([-0-9.]+) mm</td>", tables[0]["2\u20136 m"])[i]) for i in (0, 1))
        with Image.open(self.survey / "range" / "00001.png") as picture:
            truth = np.array(picture) / 1000.0
        self.assertGreater(std, 5.0)
        self.assertLess(std, 300.0)
        self.assertLess(nmad, 200.0)
        pixels = int(re.findall(r"<td>(\d+)</td>", tables[0]["2\u20136 m"])[0])
        self.assertLess(pixels, pairs * ((truth >= 2) & (truth < 6)).sum() * 1.1)
        self.assertGreater(pixels, 0.3 * pairs * ((truth >= 2) & (truth < 6)).sum())

    def test_report_that_cannot_be_written_is_refused_before_the_work(self):
        (self.folder / "plain").write_text("")
        for page in (self.folder, self.folder / "plain" / "report.html", "/proc/report.html"):
            with self.subTest(page=page):
                run = mapper(self.survey, "--out", self.folder / "not_begun", "--report", page)
                self.assertNotEqual(run.returncode, 0)
                self.assertRegex(run.stderr, r"\Akawara-mapper: --report: [^\n]+\n\Z")
                self.assertFalse((self.folder / "not_begun").exists())

    def test_interrupted_it_says_how_to_go_on(self):
        out = self.folder / "interrupted"
        with subprocess.Popen([BIN / "kawara-mapper", self.survey, "--out", out, "--step", "0.05"], stdout=subprocess.PIPE,
                              stderr=subprocess.PIPE, text=True) as run:
            run.stderr.readline()  # the first pair is done
            run.send_signal(signal.SIGINT)
            said, warned = run.communicate(timeout=60)
        self.assertEqual(run.returncode, 130, warned)
        self.assertIn("the same command goes on from here", warned)
        self.assertEqual(said, "")

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
                ((), 2, "survey is required"),
                ((self.survey, "--method", "best"), 2, "--method: best not in {fast,paper}"),
                ((self.survey, "--method", "paper", "--px-per-rad", "100"), 2, "--px-per-rad is of the fast method"),
                ((self.survey, "--method", "paper", "--pole-cap", "10"), 2, "--pole-cap is of the fast method"),
                ((self.survey, "--method", "paper", "--baselines", "several"), 2, "--baselines several is of the fast method"),
                ((self.survey, "--baselines", "many"), 2, "--baselines: many not in {one,several}"),
                ((self.survey, "--depth-only", "00001", "00002", "--report", "x.html"), 2, "--report is of a model"),
                ((self.survey, "--priority", "normal"), 2, "--priority requires --live"),
                ((self.survey, "--baseline", "50"), 1, "no two frames"),
                ((self.survey, "--voxel", "0"), 2, "--voxel"),
                ((bad, "--depth-only", "00001", "00002"), 1, "camera.yaml:"),
                ((torn, "--depth-only", "00001", "00002"), 1, "00002.jpg: the picture ends early"),
                ((self.survey, "--depth-only", "00001", "00002", "--out", self.folder / "file"), 1, "file"),
                ((self.survey, "--depth-only", "00001", "00002", "--nearest", "-1"), 2, "--nearest")):
            with self.subTest(words=words[1:]):
                run = mapper(*words, *([] if "--out" in words or not words else ["--out", out]))
                self.assertEqual(run.returncode, status, run.stderr)
                self.assertIn(said, run.stderr)
                self.assertTrue(run.stderr.startswith("kawara-mapper: "), run.stderr)
                self.assertEqual(run.stdout, "")


class MissionTest(unittest.TestCase):
    """The robot's own messages as input: a mission driven in virtual time, small pictures a quarter of a metre apart."""
    @classmethod
    def setUpClass(cls):
        cls.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-mapper-mission-"))
        cls.addClassCleanup(shutil.rmtree, cls.folder)
        cls.log = cls.folder / "mission.lcm"
        optics = {"width_px": 384, "height_px": 384, "center_u_px": 191.5, "center_v_px": 191.5, "l_in_px": 45,
                  "l_base_px": 98.4375, "l_out_px": 187.5}
        settings = [f"picture.doughnut.{key}={value}" for key, value in optics.items()] + [
            "picture.panorama.width_px=800", "picture.preview_width_px=128", "schedule.every_m=0.25", "schedule.every_epochs=0"]
        subprocess.run([BIN / "kawara-sim", "site", "--site", SOURCE / "configs/sites/factory_road.yaml", "--run-dir",
                        cls.folder / "truth", "--virtual", cls.log, "--onboard-config", SOURCE / "configs/survey_robot.yaml",
                        "--doughnut-px", "384", "--samples", "1", "--light-cell", "5", "--duration", "42",
                        *(word for setting in settings for word in ("--onboard-set", setting))],
                       check=True, capture_output=True, timeout=400)

    def tiles(self, out):
        return len(re.findall(r"^Inline", (out / "model.wrl").read_text(), re.M))

    def test_model_of_a_log(self):
        out, page = self.folder / "log_model", self.folder / "log_model.html"
        run = mapper("--log", self.log, "--out", out, "--report", page)
        self.assertEqual(run.returncode, 0, run.stderr)
        self.assertGreater(int(re.search(r"(\d+) pairs in", run.stdout)[1]), 20)
        self.assertGreater(self.tiles(out), 3)
        self.assertNotIn("Accuracy", page.read_text())  # a log knows no truth
        self.assertGreaterEqual(len(re.findall("data:image/png", page.read_text())), 4)
        self.assertLessEqual(len(re.findall("data:image/png", page.read_text())), 8)

    def own_network(self):
        """A network namespace, for as long as the test lasts; the words that start a program in it."""
        holder = subprocess.Popen(["unshare", "-n", "sh", "-c", "ip link set lo up multicast on && "  # noqa: SIM115
                                   "ip route add 224.0.0.0/4 dev lo && echo ready && exec sleep 3600"], stdout=subprocess.PIPE)
        self.addCleanup(holder.stdout.close)
        self.addCleanup(holder.wait)
        self.addCleanup(holder.kill)
        self.assertEqual(holder.stdout.readline(), b"ready\n")
        return ["nsenter", "-t", str(holder.pid), "-n", "env", "LCM_DEFAULT_URL=udpm://239.255.76.67:7667?ttl=0"]

    @contextlib.contextmanager
    def live_mapper(self, network, out, *words):
        """A mapper that listens already; `said` grows while it runs. Killed at the end, if it has not ended itself."""
        said = self.folder / "said"
        with open(said, "w", encoding="utf-8") as file:
            run = subprocess.Popen([*network, BIN / "kawara-mapper", "--live", "--out", out, *words], stdout=file,  # noqa: SIM115
                                   stderr=subprocess.STDOUT)
        try:
            wait_for(lambda: "waits for pictures" in said.read_text() or run.poll() is not None, 60, "a mapper that listens")
            self.assertIsNone(run.poll(), said.read_text())
            run.said = said.read_text
            yield run
        finally:
            run.kill()
            run.wait()

    @contextlib.contextmanager
    def player(self, network, speed):
        with subprocess.Popen([*network, "lcm-logplayer", f"--speed={speed}", self.log], stdout=subprocess.DEVNULL,
                              stderr=subprocess.DEVNULL) as run:
            try:
                yield run
            finally:
                run.kill()

    def finished_tiles(self, out):
        text = (out / "model.yaml").read_text() if (out / "model.yaml").exists() else ""
        return {name for name, faces in re.findall(r'name: "(\S+)"\n\s+revision: \d+\n\s+faces: (\d+)', text) if int(faces) > 0}

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("lcm-logplayer"), "needs root and Debian's liblcm-bin")
    def test_live_and_killed_and_live_again(self):
        """What a kill leaves is a whole model; the next run goes on in the same map, and a signal finishes it.

        A machine that is too busy for the drive at this speed gets it at half of it, and so on."""
        network, out = self.own_network(), self.folder / "live_model"
        speeds = [2.0, 1.0, 0.5, 0.25]
        for speed in speeds:
            shutil.rmtree(out, ignore_errors=True)
            with self.live_mapper(network, out, "--priority", "normal") as run, self.player(network, speed) as player:
                wait_for(lambda: self.finished_tiles(out) or player.poll() is not None or run.poll() is not None, 300, "a tile")
                self.assertIsNone(run.poll(), run.said())
            before = self.finished_tiles(out)
            if before:
                break
        self.assertGreater(len(before), 0)
        for name in before:
            for ending in (".wrl", ".glb", ".ply", ".las"):
                self.assertGreater((out / (name + ending)).stat().st_size, 0)
        # The drive once more: what the voxels have is passed over.
        for speed in speeds[speeds.index(speed):]:
            with self.live_mapper(network, out, "--priority", "normal") as run:
                with self.player(network, speed) as player:
                    player.wait(300)
                run.send_signal(signal.SIGTERM)
                run.wait(120)
            if run.returncode == 0 and len(self.finished_tiles(out)) > len(before):
                break
        self.assertEqual(run.returncode, 0, run.said())
        self.assertIn("goes on with", run.said())
        self.assertRegex(run.said(), r"\d+ tiles, \d+ faces")
        self.assertLess(before, self.finished_tiles(out))

    @unittest.skipUnless(os.geteuid() == 0 and shutil.which("lcm-logplayer"), "needs root and Debian's liblcm-bin")
    def test_live_gives_way_unless_told_otherwise(self):
        network = self.own_network()
        for words, policy in (([], os.SCHED_IDLE), (["--priority", "normal"], os.SCHED_OTHER)):
            out = self.folder / f"priority{policy}"
            with self.live_mapper(network, out, *words) as run, self.player(network, 2.0):
                # The first picture is in: the work begins.
                wait_for(lambda: (out / "voxels.spill").exists() or run.poll() is not None, 120, "work")
                self.assertIsNone(run.poll(), run.said())
                self.assertEqual(os.sched_getscheduler(run.pid), policy)

    def test_mistakes_are_answered_in_one_line(self):
        (self.folder / "no.lcm").write_bytes(b"")
        for words, said in ((("--log", self.folder / "none.lcm"), "none.lcm"),
                            (("--log", self.folder / "no.lcm"), "PHASE1"),
                            (("--log", self.log, "--robot", "nobody"), "PHASE1"),
                            (("--log", self.log, "--depth-only", "1", "2"), "survey"),
                            (("--live", "--bus", "nonsense://"), "nonsense")):
            with self.subTest(words=words):
                run = mapper(*words, "--out", self.folder / "nothing")
                self.assertNotEqual(run.returncode, 0)
                self.assertIn(said, run.stderr)
                self.assertEqual(run.stdout, "")


if __name__ == "__main__":
    unittest.main()
