"""./run demo --changes: three updates on two days, from a robot that drives past a truck and a wagon to what a GIS knows.

Each day kawara-sim drives the robot in virtual time (receiver, attitude unit, camera, and kawara-onboard's own core), kawara-mapper makes the model
from its log and tells what the reference does not know, kawara-station stores pictures, poses, changed objects and road. The second day the wagon has
left. Needs no network and no display; some minutes on two cores.
"""
import argparse
import contextlib
import pathlib
import shutil
import sqlite3
import subprocess
import sys
import time

from PIL import Image

ROOT = pathlib.Path(__file__).resolve().parents[1]
BIN = ROOT / "build/bin"
SITE = ROOT / "configs/sites/factory_road.yaml"
SIDE_PX = 768  # of the camera: small enough for two cores
DAYS = {"monday": "2026-11-23T01:00:00Z", "tuesday": "2026-11-24T01:00:00Z"}


def run(program, *words):
    """Runs it; ends with its complaint if it has one."""
    done = subprocess.run([BIN / program, *map(str, words)], capture_output=True, text=True, check=False)
    if done.returncode != 0:
        sys.exit(done.stderr.strip().splitlines()[-1] if done.stderr.strip() else f"{program}: exit code {done.returncode}")
    return done


def drive(out, day, site, seconds, seed):
    scale = SIDE_PX / 1024
    optics = {"width_px": SIDE_PX, "height_px": SIDE_PX, "center_u_px": (SIDE_PX - 1) / 2, "center_v_px": (SIDE_PX - 1) / 2,
              "l_in_px": 120 * scale, "l_base_px": 262.5 * scale, "l_out_px": 500 * scale}
    settings = [f"picture.doughnut.{key}={value}" for key, value in optics.items()] + [
        "picture.panorama.width_px=1440", "schedule.every_m=0.25", "schedule.every_epochs=0"]
    run("kawara-sim", "site", "--site", site, "--run-dir", out / "truth", "--virtual", out / "mission.lcm", "--begin", DAYS[day],
        "--onboard-config", ROOT / "configs/survey_robot.yaml", "--doughnut-px", SIDE_PX, "--samples", 1, "--light-cell", 2,
        "--duration", seconds, "--seed", seed, *(word for setting in settings for word in ("--onboard-set", setting)))


def standing(store):
    with contextlib.closing(sqlite3.connect(store)) as db:
        return db.execute("SELECT id, class, length_m, width_m, height_m, t_begin FROM changed_object WHERE t_end IS NULL "
                          "ORDER BY length_m DESC").fetchall()


def picture(out, store, map_png):
    """The middle of a map, and below it the sides of the largest things, as the GIS has them."""
    with contextlib.closing(sqlite3.connect(store)) as db:
        uris = [uri for uri, in db.execute("SELECT texture_uri FROM changed_object WHERE t_end IS NULL AND texture_uri IS NOT NULL "
                                           "ORDER BY length_m DESC LIMIT 2")]
    with Image.open(map_png) as drawn:
        parts = [drawn.convert("RGB").crop((0, drawn.height * 36 // 100, drawn.width - 420, drawn.height * 58 // 100))]
    for uri in uris:
        with Image.open(out / uri) as sides:
            parts.append(sides.convert("RGB").resize((2 * sides.width, 2 * sides.height)))
    sheet = Image.new("RGB", (max(p.width for p in parts), sum(p.height + 8 for p in parts)), (252, 252, 250))
    top = 0
    for part in parts:
        sheet.paste(part, (0, top))
        top += part.height + 8
    sheet.save(out / "changes.jpg", quality=80)


def main():
    parser = argparse.ArgumentParser(prog="./run demo --changes")
    parser.add_argument("--seconds", type=int, default=115, help="of each mission")
    parser.add_argument("--out", default="out/demo_changes")
    args = parser.parse_args()
    out = pathlib.Path(args.out)
    shutil.rmtree(out, ignore_errors=True)
    out.mkdir(parents=True)
    left = out / "wagon_left.yaml"
    left.write_text("".join(line for line in SITE.read_text().splitlines(keepends=True) if "name: wagon" not in line))
    store, begun = out / "changes.gpkg", time.monotonic()
    known = []
    for seed, (day, site) in enumerate({"monday": SITE, "tuesday": left}.items(), start=1):
        folder = out / day
        folder.mkdir()
        drive(folder, day, site, args.seconds, seed)
        reference = out / "before.kwref"
        if not known:
            truth = folder / "truth"
            run("kawara-reference", "--out", reference, "--buildings", truth / "reference_city.json", "--road",
                truth / "reference_road.geojson", "--road-name", "carriageway", "--ground", truth / "reference_ground.asc",
                "--date", "2026-01-01T00:00:00Z")
        words = ["--known", *known] if known else []
        mapped = run("kawara-mapper", "--log", folder / "mission.lcm", "--out", folder / "model", "--reference", reference, *words)
        print(mapped.stdout.strip().splitlines()[-1])
        known.append(folder / "model/changes.lcm")
        stored = run("kawara-station", "--log", folder / "mission.lcm", "--log", known[-1], "--store", store, "--map",
                     folder / "map.png")
        print(stored.stdout.strip().splitlines()[-1])
        print(f"{day}: what stands on the road that the reference does not know:")
        for uid, cls, length, width, height, begin in standing(store):
            print(f"  {uid:28} {cls:8} {length:.1f} x {width:.1f} x {height:.1f} m, since {begin}")
        if day == "monday":
            picture(out, store, folder / "map.png")
        judged = run("kawara-evaluate", "objects", "--truth", folder / "truth/truth_new_objects.csv", "--result", store)
        for line in judged.stdout.splitlines():
            if line.startswith(("found", "missed", "false")) and " objects" not in line:
                print("  the truth: " + line)
    print(f"two missions in {time.monotonic() - begun:.0f} s; {store} (QGIS: time slider), {out}/changes.jpg, {out}/*/map.png, {out}/*/model/model.wrl, "
          f"pictures of the boxes' sides in {out}/textures")


if __name__ == "__main__":
    main()
