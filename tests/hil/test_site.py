"""kawara-sim site and --render as processes: a robot that does not exist, driven through a site."""
import csv
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import tempfile
import time
import unittest

from processes import BIN, SOURCE, Processes, run, wait_for

SITE = SOURCE / "configs/sites/warehouse_yard.yaml"
SMALL = ("--samples", "1", "--light-cell", "5")


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Folder(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(tempfile.mkdtemp(prefix="kawara-site-"))

    def tearDown(self):
        shutil.rmtree(self.folder)


class SurveyTest(Folder):
    def render(self, name, *more):
        return self.render_with(name, "--doughnut-px", "256", *more)

    def render_with(self, name, *more):
        done = run("kawara-sim", "--render", self.folder / name, "--site", SITE, "--start", "20", "--duration", "2",
                   "--every", "1", *SMALL, *more, timeout=300)
        self.assertEqual(done.returncode, 0, done.stderr)
        return self.folder / name

    def test_survey_folder_is_whole_and_the_same_again(self):
        first, second = self.render("a"), self.render("b")
        frames = sorted(p.name for p in (first / "frames").iterdir())
        self.assertGreaterEqual(len(frames), 2)
        self.assertEqual([r["frame"] + ".jpg" for r in rows(first / "poses.csv")], frames)
        for path in sorted(p for p in first.rglob("*") if p.is_file() and p.suffix != ".gpkg"):
            self.assertEqual(path.read_bytes(), (second / path.relative_to(first)).read_bytes(), path.name)

    def test_the_truth_judges_the_truth(self):
        folder = self.render("c", "--pose-noise", "0.05")
        evaluate = lambda *args: run("kawara-evaluate", *args, "--json", self.folder / "figures.json", timeout=60)
        figures = lambda: json.loads((self.folder / "figures.json").read_text())
        done = evaluate("poses", "--truth", folder / "truth_camera.csv", "--result", folder / "truth_frames.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertLess(figures()["3D"]["max"], 0.001)
        evaluate("poses", "--truth", folder / "truth_camera.csv", "--result", folder / "poses.csv")
        self.assertGreater(figures()["3D"]["rms"], 0.01)
        done = evaluate("ranges", "--truth", folder / "range", "--result", folder / "range")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual(figures()["2-6 m"]["max"], 0)
        self.assertGreater(figures()["2-6 m"]["n"], 100)
        done = evaluate("objects", "--truth", folder / "truth_objects.csv", "--result", folder / "truth_new_objects.csv")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertGreater(figures()["found"]["value"], 0)
        self.assertEqual(figures()["false"]["value"], 0)
        self.assertGreater(figures()["overlap (IoU)"]["mean"], 0.999)

    def test_the_camera_file_of_a_survey_makes_the_same_survey(self):
        sphere = self.folder / "sphere.yaml"
        sphere.write_text("camera: equirectangular\nequirectangular: {width_px: 300, height_px: 100}\n")
        first = self.render_with("a", "--camera", sphere)
        second = self.render_with("b", "--camera", first / "camera.yaml")
        frames = sorted((first / "frames").iterdir())
        self.assertGreaterEqual(len(frames), 2)
        for path in frames:
            self.assertEqual(path.read_bytes(), (second / "frames" / path.name).read_bytes(), path.name)

    def test_mistakes_are_said_in_one_line(self):
        cases = [
            (["--render", self.folder / "x", "--site", "nowhere.yaml"], "nowhere.yaml"),
            (["--render", self.folder / "x", "--robot", SITE], "warehouse_yard.yaml:"),
            (["--render", "/proc/x", "--site", SITE], "/proc/x"),
            (["--render", self.folder / "x", "--camera", SITE], "warehouse_yard.yaml:"),
            (["site"], "--run-dir is required"),
            ([], "drive, site, radio, fault or --render"),
        ]
        for args, expected in cases:
            done = run("kawara-sim", *args, timeout=300)
            self.assertEqual(done.returncode, 2, args)
            self.assertIn(expected, done.stderr, args)


class LiveTest(Folder):
    def start(self, *more):
        ports = self.folder / "ports"
        process = subprocess.Popen([BIN / "kawara-sim", "site", "--run-dir", ports, "--site", SITE, "--no-camera",
                                    "--duration", "60", *more], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.communicate)
        self.addCleanup(process.kill)
        wait_for(lambda: (ports / "ready").exists() or process.poll() is not None, 300, "the simulator's ports")
        return process, ports

    def test_killed_at_any_moment_it_leaves_no_links(self):
        for after_s in (0.0, 0.2, 1.0):
            process, ports = self.start()
            self.assertEqual({p.name for p in ports.iterdir() if p.is_symlink()}, {"gps", "ahrs", "laser1", "laser2"})
            time.sleep(after_s)
            process.kill()
            process.wait()
            wait_for(lambda: not any(p.is_symlink() for p in ports.iterdir()) and not (ports / "ready").exists(), 10,
                     "the links to go")

    def test_onboard_comes_back_when_the_simulator_does(self):
        with Processes(self.folder / "output") as chain:
            process, ports = self.start()
            chain.start("onboard", "kawara-onboard", "--config", SOURCE / "configs/survey_robot.yaml",
                        "--set", f"gps.device={ports}/gps", "--set", f"ahrs.device={ports}/ahrs",
                        "--set", f"gps.pps.device={ports}/pps.sock", "--set", "camera.source=none", "--set", f"record.folder={self.folder}/log",
                        "--set", "lcm_url=udpm://239.255.76.67:7667?ttl=0")
            time.sleep(8)
            process.send_signal(signal.SIGKILL)
            process.wait()
            wait_for(lambda: not (ports / "ready").exists(), 10, "the ports to go")
            self.start("--start", "30")
            time.sleep(12)
            self.assertEqual(chain.stop("onboard"), 0, chain.output("onboard"))
        log = next((self.folder / "log").iterdir())
        done = run("kawara-log", "export", log, "--channel", "GNSS", "--out", self.folder / "gnss.csv", timeout=60)
        self.assertEqual(done.returncode, 0, done.stderr)
        times = [int(r["gps_ns"]) for r in rows(self.folder / "gnss.csv")]
        self.assertGreater(max(b - a for a, b in zip(times, times[1:])), 5e9, "fixes of both runs, far apart")


class StitchedCameraTest(Folder):
    """The robot with a 360 camera that stitches by itself: its pictures go through the whole chain as they are."""

    def test_an_equirectangular_picture_reaches_the_store(self):
        camera, ports = self.folder / "camera.yaml", self.folder / "ports"
        camera.write_text("camera: equirectangular\nequirectangular: {width_px: 512, height_px: 200, top_px: 30}\n")
        url = "udpm://239.255.76.67:7668?ttl=0"
        with Processes(self.folder / "output") as chain:
            chain.start("station", "kawara-station", "--config", SOURCE / "configs/station.yaml", "--lcm-url", url,
                        "--store", self.folder / "live/mission.gpkg")
            chain.start("sim", "kawara-sim", "site", "--run-dir", ports, "--site", SITE, "--light-cell", "5", "--camera", camera,
                        "--duration", "25")
            wait_for(lambda: (ports / "ready").exists(), 300, "the simulator's ports")
            chain.start("onboard", "kawara-onboard", "--config", SOURCE / "configs/survey_robot.yaml",
                        "--set", f"gps.device={ports}/gps", "--set", f"ahrs.device={ports}/ahrs",
                        "--set", f"camera.path={ports}/camera.sock", "--set", f"record.folder={self.folder}/log",
                        "--set", "picture.camera=equirectangular", "--set", "record.disk_reserve_mb=1", "--set", f"lcm_url={url}")
            chain.wait("sim", 120)
            time.sleep(2)
            self.assertEqual(chain.stop("onboard"), 0, chain.output("onboard"))
            self.assertEqual(chain.stop("station"), 0, chain.output("station"))
            self.assertIn("drawn late", chain.output("sim"))
        pictures = [p.read_bytes() for p in (self.folder / "live").rglob("*.jpg")]
        self.assertGreater(len(pictures), 5)
        for jpeg in pictures:
            tag = lambda name: int(re.search(rb'GPano:%s[>="]+(\d+)' % name, jpeg).group(1))
            width = tag(b"CroppedAreaImageWidthPixels")
            self.assertIn(width, (512, 256), "full picture or preview")
            self.assertEqual(tag(b"FullPanoHeightPixels"), width // 2)
            self.assertEqual(tag(b"CroppedAreaTopPixels"), 30 * width // 512)
        self.assertTrue(any(b"CroppedAreaImageHeightPixels" in jpeg for jpeg in pictures))


if __name__ == "__main__":
    unittest.main()
