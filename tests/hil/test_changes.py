"""kawara-reference and kawara-changes as users run them: clouds of anybody, a road, a raster of the ground."""
import json
import math
import os
import pathlib
import random
import sqlite3
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
ORIGIN = "35.3606,139.5310,52.0"
WHEN = ["2026-11-01T01:00:00Z", "2026-11-01T02:00:00Z", "2026-11-01T03:00:00Z"]


def run(program, *words):
    return subprocess.run([BIN / program, *map(str, words)], capture_output=True, text=True, timeout=300)


def street(boxes, seed=1):
    """Points on a level road of 40 x 8 m between walls, with noise of 2 cm; boxes as (x, y, length, width, height)."""
    dice = random.Random(seed)
    points = []

    def add(x, y, z, normal):
        noise = dice.gauss(0.0, 0.02)
        points.append((x + noise * normal[0], y + noise * normal[1], z + noise * normal[2]))

    step = 0.1
    for i in range(400):
        for j in range(100):
            add(-20 + i * step, -5 + j * step, 0.0, (0, 0, 1))
        for k in range(40):
            for y in (-5.0, 5.0):
                add(-20 + i * step, y, k * step, (0, 1, 0))
    for x, y, length, width, height in boxes:
        for k in range(int(height / 0.08) + 1):
            for i in range(int(length / 0.08) + 1):
                for side in (-1, 1):
                    add(x - length / 2 + i * 0.08, y + side * width / 2, k * 0.08, (0, 1, 0))
            for i in range(int(width / 0.08) + 1):
                for side in (-1, 1):
                    add(x + side * length / 2, y - width / 2 + i * 0.08, k * 0.08, (1, 0, 0))
    return points


def write_ply(path, points):
    with open(path, "w") as f:
        f.write(f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n"
                "property float x\nproperty float y\nproperty float z\nend_header\n")
        for p in points:
            f.write("%.4f %.4f %.4f\n" % p)


def write_road(path):
    ring = [[-20, -4], [20, -4], [20, 4], [-20, 4], [-20, -4]]
    path.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"name": "road"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))


def write_ground(path):
    """A GeoTIFF of the ground's height in local metres, without a reference system."""
    from osgeo import gdal
    gdal.UseExceptions()
    raster = gdal.GetDriverByName("GTiff").Create(str(path), 170, 60, 1, gdal.GDT_Float32)
    raster.SetGeoTransform((-25.0, 0.3, 0.0, 9.0, 0.0, -0.3))
    raster.GetRasterBand(1).Fill(0.0)
    raster.FlushCache()


TRUCK, CAR = (6.0, 2.6, 7.0, 2.2, 3.0), (-8.0, 2.9, 4.4, 1.7, 1.5)


def write_jgd(ground, road):
    """The same ground and road in JGD2011 degrees, heights above sea level (EPSG:6697)."""
    from osgeo import gdal, osr
    gdal.UseExceptions()
    lat, lon = 35.3606, 139.5310
    north, east = 1 / 110950.0, 1 / 90910.0  # degrees a metre, there
    system = osr.SpatialReference()
    system.ImportFromEPSG(6697)
    raster = gdal.GetDriverByName("GTiff").Create(str(ground), 60, 40, 1, gdal.GDT_Float32)
    raster.SetGeoTransform((lon - 30 * east, east, 0.0, lat + 20 * north, 0.0, -north))
    raster.SetProjection(system.ExportToWkt())
    raster.GetRasterBand(1).Fill(15.0)
    raster.FlushCache()
    ring = [[lon + x * east, lat + y * north] for x, y in ((-20, -4), (20, -4), (20, 4), (-20, 4), (-20, -4))]
    road.write_text(json.dumps({"type": "FeatureCollection", "features": [
        {"type": "Feature", "properties": {"name": "road"}, "geometry": {"type": "Polygon", "coordinates": [ring]}}]}))


class ChangesTest(unittest.TestCase):
    def setUp(self):
        holder = tempfile.TemporaryDirectory(prefix="kawara-changes-")
        self.addCleanup(holder.cleanup)
        self.folder = pathlib.Path(holder.name)
        self.road, self.ground = self.folder / "road.geojson", self.folder / "ground.tif"
        write_road(self.road)
        write_ground(self.ground)

    def cloud(self, name, boxes, seed=1):
        path = self.folder / name
        write_ply(path, street(boxes, seed))
        return path

    def standing(self, store):
        with sqlite3.connect(store) as db:
            return db.execute("select id, class, length_m, width_m, height_m, heading_deg from changed_object "
                              "where t_end is null order by id").fetchall()

    def test_heights_above_sea_level_that_nothing_lifts_are_warned_of(self):
        ground, road = self.folder / "jgd.tif", self.folder / "jgd.geojson"
        write_jgd(ground, road)
        words = ["--out", self.folder / "r.kwref", "--ground", ground, "--road", road, "--origin", ORIGIN]
        silent = run("kawara-reference", *words, "--geoid-separation", 37.0)
        self.assertEqual(silent.returncode, 0, silent.stderr)
        self.assertNotIn("sea level", silent.stdout + silent.stderr)
        warned = run("kawara-reference", *words)
        self.assertEqual(warned.returncode, 0, warned.stderr)
        self.assertIn("jgd.tif: its heights are above sea level", warned.stdout + warned.stderr)
        self.assertIn("--geoid-separation", warned.stdout + warned.stderr)

    def test_ground_raster_and_road_alone_are_a_reference(self):
        reference, store = self.folder / "r.kwref", self.folder / "c.gpkg"
        made = run("kawara-reference", "--out", reference, "--ground", self.ground, "--road", self.road, "--local",
                   "--origin", ORIGIN, "--date", "2026-10-01")
        self.assertEqual(made.returncode, 0, made.stderr)
        self.assertIn("2026-10-01", run("kawara-reference", "--show", reference).stdout)
        done = run("kawara-changes", self.cloud("now.ply", [TRUCK, CAR]), "--reference", reference, "--out", store,
                   "--time", WHEN[0], "--exports", self.folder / "also")
        self.assertEqual(done.returncode, 0, done.stderr)
        objects = self.standing(store)
        self.assertEqual([o[1] for o in objects], ["truck", "car"])
        boxes = json.loads((self.folder / "also/changes.geojson").read_text())["features"]
        self.assertEqual(sum(f["geometry"]["type"] == "Polygon" for f in boxes), 2)
        names = {p.name for p in (self.folder / "also").iterdir()}
        self.assertLessEqual({"changes.kmz", "changes.city.json", "changes.wrl", "changes.glb", "survey-1.cot.xml", "survey-2.cot.xml",
                              "kiwi_plus"}, names)
        for found, truth in zip(objects, (TRUCK, CAR)):
            for value, true in zip(found[2:5], truth[2:5]):
                self.assertAlmostEqual(value, true, delta=0.3)
            self.assertAlmostEqual(found[5] % 180.0, 90.0, delta=2.0)
        # The apexes lie where they should: within the truck's length of the origin, to centimetres a degree.
        with sqlite3.connect(store) as db:
            lon, lat, h = db.execute("select apex0_lon_deg, apex0_lat_deg, apex0_h_m from changed_object "
                                     "where id like '%-1'").fetchone()
            east = (lon - 139.5310) * math.radians(1) * 6378137 * math.cos(math.radians(35.3606)) * 1.001
            self.assertAlmostEqual(abs(east - TRUCK[0]), 3.5, delta=0.4)
            self.assertAlmostEqual(h, 52.0, delta=0.2)
            narrow = db.execute("select min(passable_m) from road_station where unknown_share < 0.5").fetchone()[0]
        self.assertAlmostEqual(narrow, 8.0 - (4.0 - 1.5), delta=0.2)

    def test_a_reference_of_points_knows_what_stood_there(self):
        before = self.cloud("before.ply", [CAR], seed=5)
        reference, store = self.folder / "r.kwref", self.folder / "c.gpkg"
        made = run("kawara-reference", "--out", reference, "--cloud", before, "--road", self.road, "--local", "--origin",
                   ORIGIN)
        self.assertEqual(made.returncode, 0, made.stderr)
        done = run("kawara-changes", self.cloud("now.ply", [TRUCK, CAR], seed=6), "--reference", reference, "--out",
                   store, "--time", WHEN[0])
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertEqual([o[1] for o in self.standing(store)], ["truck"])

    def test_a_second_look_keeps_ids_and_closes_what_has_left(self):
        store = self.folder / "c.gpkg"
        words = ["--road", self.road, "--ground", self.ground, "--local", "--origin", ORIGIN, "--out", store]
        first = run("kawara-changes", self.cloud("a.ply", [TRUCK, CAR], 1), *words, "--time", WHEN[0])
        self.assertEqual(first.returncode, 0, first.stderr)
        before = self.standing(store)
        second = run("kawara-changes", self.cloud("b.ply", [TRUCK], 2), *words, "--time", WHEN[1])
        self.assertEqual(second.returncode, 0, second.stderr)
        self.assertEqual([o[0] for o in self.standing(store)], [before[0][0]])
        with sqlite3.connect(store) as db:
            ends = db.execute("select t_end from changed_object where id = ?", (before[1][0],)).fetchall()
        self.assertTrue(ends and all(end[0] and end[0].startswith(WHEN[1][:19]) for end in ends), ends)
        # Half the street not looked at: nothing there is gone.
        west = self.folder / "west.ply"
        write_ply(west, [p for p in street([], 3) if p[0] < -1.0])
        third = run("kawara-changes", west, *words, "--time", WHEN[2])
        self.assertEqual(third.returncode, 0, third.stderr)
        self.assertEqual([o[0] for o in self.standing(store)], [before[0][0]])

    def test_a_reference_that_lies_elsewhere_is_refused(self):
        before = self.folder / "before.ply"
        write_ply(before, [(x, y + 0.5, z) for x, y, z in street([], 5)])
        reference = self.folder / "r.kwref"
        run("kawara-reference", "--out", reference, "--cloud", before, "--road", self.road, "--local", "--origin", ORIGIN)
        done = run("kawara-changes", self.cloud("now.ply", [CAR]), "--reference", reference, "--out",
                   self.folder / "c.gpkg", "--time", WHEN[0])
        self.assertEqual(done.returncode, 2)
        self.assertIn("beyond reason", done.stderr)
        self.assertFalse((self.folder / "c.gpkg").exists())

    def test_every_mistake_gets_one_line_that_says_how_to_mend_it(self):
        cloud = self.cloud("now.ply", [])
        bad = self.folder / "bad.ply"
        bad.write_bytes(b"nothing of the kind")
        out = ["--out", self.folder / "c.gpkg", "--origin", ORIGIN]
        for words, status, what in (
                ([cloud, *out], 2, "--road"),
                ([cloud, "--road", self.road, "--local", "--out", self.folder / "c.gpkg"], 2, "--origin"),
                ([self.folder / "none.ply", "--road", self.road, *out], 2, "none.ply"),
                ([bad, "--road", self.road, *out, "--time", WHEN[0]], 1, "bad.ply"),
                ([self.folder, "--road", self.road, *out], 2, "kawara-mapper"),
                ([cloud, "--road", self.folder / "no.geojson", *out], 2, "no.geojson"),
                ([cloud, "--reference", bad, *out], 1, "bad.ply"),
                ([cloud, "--road", self.road, *out, "--classes", "4,2"], 2, "--classes"),
                ([cloud, "--road", self.road, "--local", "--origin", "here", "--out", "c.gpkg"], 2, "--origin"),
        ):
            done = run("kawara-changes", *words)
            self.assertEqual(done.returncode, status, (words, done.stderr))
            last = done.stderr.strip().splitlines()[-1]
            self.assertTrue(last.startswith("kawara-changes: "), done.stderr)
            self.assertIn(what, last)
        self.assertEqual(run("kawara-reference", "--out", "x").returncode, 2)


if __name__ == "__main__":
    unittest.main()
