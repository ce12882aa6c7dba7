"""What changed, registered in a GeoPackage and in PostGIS (a throw-away cluster on loopback): the same rows; QGIS's time
slider and kawara-evaluate see what there is."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import unittest

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
TEST = [str(BIN / "test_gis_kiwi"), "--gtest_filter=NamedStore.*", "--gtest_brief=1"]
TABLES = ["kp_feature_space", "kp_vector", "kp_connector", "kp_attribute", "kp_box", "kp_texture", "kp_t_bounds", "kp_tx", "kp_meta",
          "changed_object", "road_station"]
# Opens every layer with the style the store itself holds and counts what the time controller lets through.
QGIS = r"""
import os, sys
os.environ["QT_QPA_PLATFORM"] = "offscreen"
from qgis.core import *
from qgis.PyQt.QtCore import QDateTime, Qt
app = QgsApplication([], False)
app.initQgis()
layer = QgsVectorLayer(sys.argv[1] + "|layername=" + sys.argv[2], "l")
assert layer.isValid()
assert layer.loadDefaultStyle()[1]  # as the QGIS desktop does when a layer is added
time = layer.temporalProperties()
print(time.isActive(), time.startField(), time.endField(), layer.renderer().type())
for begin in sys.argv[3:]:
    at = QDateTime.fromString(begin, Qt.ISODateWithMs)
    context = QgsVectorLayerTemporalContext()
    context.setLayer(layer)
    rule = time.createFilterString(context, QgsDateTimeRange(at, at))
    print(sorted((f["id"], f["revision"]) for f in layer.getFeatures(QgsFeatureRequest().setFilterExpression(rule))))
sys.stdout.flush()
os._exit(0)
"""


# Prints every row of every table, whichever driver reads it, without the numbers the database gives rows.
DUMP = r"""
import sys
from osgeo import ogr
ogr.UseExceptions()
store = ogr.Open(sys.argv[1])
def value(row, i):
    if not row.IsFieldSetAndNotNull(i):
        return "-"
    kind = row.GetFieldDefnRef(i).GetType()
    if kind == ogr.OFTDateTime:
        *date, second, zone = row.GetFieldAsDateTime(i)
        return "%d-%d-%d %d:%d" % tuple(date) + ":%.3f zone %d" % (second, zone)
    return "%.9f" % row.GetField(i) if kind == ogr.OFTReal else str(row.GetField(i))
for table in sys.argv[2:]:
    lines = []
    for row in store.GetLayerByName(table):
        text = " ".join(row.GetFieldDefnRef(i).GetName() + "=" + value(row, i) for i in range(row.GetFieldCount()))
        shape = row.GetGeometryRef()
        if shape is not None:
            envelope = " ".join("%.9f" % x for x in shape.GetEnvelope3D())
            text += " %s %s %s" % (shape.GetGeometryName(), shape.GetCoordinateDimension(), envelope)
        lines.append(table + ": " + text)
    print("\n".join(sorted(lines)))
"""


class KiwiStores(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory(prefix="kawara-kiwi-")
        self.addCleanup(temporary.cleanup)
        self.folder = pathlib.Path(temporary.name)
        self.store = self.folder / "changes.gpkg"
        subprocess.run(TEST, check=True, env=dict(os.environ, KAWARA_TEST_STORE=str(self.store)), cwd=self.folder, stdout=subprocess.DEVNULL)

    @unittest.skipUnless(shutil.which("pg_virtualenv") and any(pathlib.Path("/usr/share/postgresql").glob("*/extension/postgis.control")),
                         "PostGIS is not installed (postgresql-15-postgis-3, postgresql-common)")
    def test_postgis_holds_the_same_rows(self):
        dump = self.folder / "dump.py"
        dump.write_text(DUMP)
        read = ["/usr/bin/python3", "-B", str(dump)]
        words = " ".join(f"'{word}'" for word in TEST)
        (self.folder / "check.sh").write_text(f"""
            set -e
            export KAWARA_TEST_STORE="PG:dbname=$PGDATABASE"
            {words} >&2
            {' '.join(read)} "$KAWARA_TEST_STORE" {' '.join(TABLES)}""")
        postgis = subprocess.run(["pg_virtualenv", "bash", "check.sh"], cwd=self.folder, capture_output=True, text=True, timeout=300)
        self.assertEqual(postgis.returncode, 0, postgis.stderr)
        file = subprocess.run([*read, str(self.store), *TABLES], capture_output=True, text=True)
        self.assertEqual(file.returncode, 0, file.stderr)
        said = [line for line in postgis.stdout.splitlines() if line.split(":")[0] in TABLES]
        self.assertGreater(len(said), 100)
        self.maxDiff = None
        self.assertEqual(said, file.stdout.splitlines())

    def test_evaluate_reads_what_stands(self):
        out = subprocess.run([str(BIN / "kawara-evaluate"), "objects", "--truth", str(self.store), "--result", str(self.store)], capture_output=True, text=True,
                             cwd=self.folder)
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertIn("truck-1", out.stdout)
        self.assertNotIn("wagon-2", out.stdout)

    @unittest.skipUnless(subprocess.run(["/usr/bin/python3", "-c", "import qgis.core"], capture_output=True).returncode == 0,
                         "QGIS for Python is not installed (python3-qgis)")
    def test_the_time_slider_shows_objects_come_and_go(self):
        times = ["2026-11-22T11:59:59.000Z", "2026-11-22T12:00:10.000Z", "2026-11-22T12:00:40.000Z", "2026-11-23T12:02:00.000Z"]
        out = subprocess.run(["/usr/bin/python3", "-B", "-c", QGIS, str(self.store), "changed_object", *times], capture_output=True, text=True,
                             env=dict(os.environ, HOME=str(self.folder)), timeout=120)
        self.assertEqual(out.returncode, 0, out.stderr)
        self.assertEqual(out.stdout.splitlines(), [
            "True t_begin t_end categorizedSymbol", "[]", "[('truck-1', 1)]", "[('truck-1', 2), ('wagon-2', 1)]", "[('truck-1', 2)]"])


if __name__ == "__main__":
    unittest.main()
