"""The same packets into a GeoPackage and into PostGIS (a throw-away cluster on loopback): the same store."""
import os
import pathlib
import shutil
import subprocess
import tempfile
import time
import unittest

import mission_packets

BIN = os.path.join(os.environ["KAWARA_BIN"], "kawara-station")


def postgis_installed():
    return shutil.which("pg_virtualenv") and any(pathlib.Path("/usr/share/postgresql").glob("*/extension/postgis.control"))


@unittest.skipUnless(postgis_installed(), "PostGIS is not installed (postgresql-15-postgis-3, postgresql-common)")
class Postgis(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory(prefix="kawara-postgis-")
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.folder = pathlib.Path(cls.temporary.name)
        cls.mission = mission_packets.Mission(pictures=8)
        cls.mission.write_log(cls.folder / "mission.log")

    def in_cluster(self, script):
        """Runs a shell script inside pg_virtualenv, in a working folder of its own."""
        work = self.folder / self.id().rsplit(".", 1)[-1]
        work.mkdir()
        script = "set -e\nexport PGSSLMODE=disable\n" + script
        done = subprocess.run(["pg_virtualenv", "bash", "-c", script], cwd=work, capture_output=True, text=True,
                              timeout=240, env=dict(os.environ, STATION=BIN, LOG=str(self.folder / "mission.log")))
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        return done.stdout, done.stderr, work

    def test_the_same_packets_give_the_same_store_in_both(self):
        _, _, work = self.in_cluster("""
            $STATION --log $LOG --store store.gpkg
            $STATION --log $LOG --store "PG:dbname=$PGDATABASE"
            $STATION --dump store.gpkg >gpkg.txt
            $STATION --dump "PG:dbname=$PGDATABASE" >postgis.txt
            $STATION --log $LOG --store "PG:dbname=$PGDATABASE"
            $STATION --dump "PG:dbname=$PGDATABASE" >again.txt
            $STATION --log $LOG --store "PG:dbname=$PGDATABASE" --map map.png
        """)
        geopackage = (work / "gpkg.txt").read_text()
        self.assertIn("# obs_panorama: 8 rows", geopackage)
        self.assertEqual((work / "postgis.txt").read_text(), geopackage)
        self.assertEqual((work / "again.txt").read_text(), geopackage, "a replay changed the store")
        self.assertGreater((work / "map.png").stat().st_size, 10000)

    def test_postgis_itself_sees_places_times_and_indexes(self):
        out, _, _ = self.in_cluster("""
            $STATION --log $LOG --store "PG:dbname=$PGDATABASE" >/dev/null
            psql -qAt <<'SQL'
            select 'srid', srid, type, coord_dimension from geometry_columns where f_table_name = 'obs_panorama';
            select 'line', ST_NPoints(geom), ST_IsValidTrajectory(geom) from trajectory;
            select 'at', string_agg(epoch::text, ',') from obs_panorama
              where tstzrange(t_begin, t_end) @> (select t_begin + interval '0.3 s' from obs_panorama where epoch = 4);
            select 'style', count(*) from layer_styles where useasdefault and f_table_schema = 'public';
            select 'index', indexdef from pg_indexes where tablename = 'obs_pose' order by indexname;
SQL
        """)
        self.assertIn("srid|4326|POINT|3", out)
        self.assertIn("line|16|t", out)
        self.assertIn("at|4\n", out)
        self.assertIn("style|4", out)
        self.assertIn("USING gist (geom)", out)
        self.assertIn("CREATE UNIQUE INDEX obs_pose_key", out)

    def test_a_server_that_goes_away_and_comes_back_costs_nothing(self):
        """The server dies while the station writes, and starts again while the station tries."""
        out, err, work = self.in_cluster("""
            $STATION --log $LOG --store store.gpkg >/dev/null
            cluster="$(pg_lsclusters -h | awk '$3 == ENVIRON["PGPORT"] {print $1, $2}')"
            psql -qc 'create extension postgis'
            $STATION --set give_up_s=60 --set retry_period_s=0.1 --log $LOG --store "PG:dbname=$PGDATABASE" &
            station=$!
            for i in $(seq 200); do  # as soon as its tables are there
              [ "$(psql -qAtc "select count(*) from pg_class where relname = 'layer_styles'")" = 1 ] && break
              sleep 0.02
            done
            pg_ctlcluster $cluster stop -m immediate -- -s
            sleep 1
            pg_ctlcluster $cluster start
            wait $station
            $STATION --log $LOG --store "PG:dbname=$PGDATABASE" >/dev/null
            $STATION --dump "PG:dbname=$PGDATABASE" >postgis.txt
            $STATION --dump store.gpkg >gpkg.txt
        """)
        self.assertEqual((work / "postgis.txt").read_text(), (work / "gpkg.txt").read_text())


if __name__ == "__main__":
    unittest.main()
