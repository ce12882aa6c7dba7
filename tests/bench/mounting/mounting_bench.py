# programs: kawara-sim kawara-calibrate
"""./run bench mounting: how well kawara-calibrate mounting finds from a drive how the camera is turned against the body. Rendered
drives of 53 m with curves to both sides, poses with noise of 2 cm and 0.1 deg a frame on each axis (RTK and an attitude
unit), a camera that is turned by some degrees of which camera.yaml knows nothing. Prints a Markdown table; figures also as
JSON. With --into README.md the table takes the place of the one between the marks there."""
import argparse
import json
import math
import os
import pathlib
import re
import subprocess
import sys
import tempfile
import time

import numpy as np

BIN = pathlib.Path(os.environ.get("KAWARA_BIN", "build/release/bin"))
MUST_DEG = 0.05
UPRIGHT = np.array([math.sqrt(0.5), 0.0, math.sqrt(0.5), 0.0])  # of the simulator's camera: up, right, forward in the body


def run(program, *arguments):
    done = subprocess.run([BIN / program, *map(str, arguments)], capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{program}: {done.stderr.strip()}")
    return done.stdout


def product(a, b):
    return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])


def exponential(turn_deg):
    turn = np.radians(turn_deg)
    angle = np.linalg.norm(turn)
    return np.array([math.cos(angle / 2), *(math.sin(angle / 2) / angle * turn)])


def turn_of(q):
    return np.degrees(2 * np.sign(q[0]) * q[1:])  # small


def drive(folder, seed, size_px, scratch):
    # Sways of 2 m to both sides along 44 m of the road, each drive its own.
    phase = 2 * math.pi * np.random.default_rng(seed).uniform()
    points = [f"{{at_m: [{x:.2f}, {-1.0 + 2.0 * math.sin(2 * math.pi * (x + 84) / 11 + phase):.2f}]}}"
              for x in np.arange(-84, -39, 2.75)]
    run("kawara-sim", "--render", folder, "--set", f"path.points=[{', '.join(points)}]", "--doughnut-px", size_px, "--seed", seed,
        "--samples", 3, "--every", 0.3, "--light-cell", 5, "--light-cache", scratch)
    turn = np.random.default_rng(100 + seed).uniform(-1.5, 1.5, 3)
    said = product(exponential(-turn), UPRIGHT)
    with open(folder / "camera.yaml", "a") as file:
        file.write("mounting:\n  translation_m: [0, 0, 0]\n"
                   f"  quaternion_wxyz: [{', '.join(f'{v:.9f}' for v in said)}]\n  axes: kawara\n")
    start = time.monotonic()
    out = run("kawara-calibrate", "mounting", folder, "--out", folder / "mounting.yaml")
    text = (folder / "mounting.yaml").read_text()
    found = np.array([float(v) for v in re.search(r"quaternion_wxyz: \[(.*)\]", text).group(1).split(",")])
    miss = turn_of(product(found, UPRIGHT * [1, -1, -1, -1]))
    stated = [float(v) for v in re.search(r"deg \(\+- (\S+) (\S+) (\S+)\) about", out).groups()]
    return {"seed": seed, "size_px": size_px, "miss_deg": miss.tolist(), "stated_sd_deg": stated,
            "seconds": time.monotonic() - start}


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--json")
    parser.add_argument("--into")
    parser.add_argument("--seeds", type=int, default=4)
    options = parser.parse_args()
    lines = ["| pictures | off by, about forward / side / vertical: rms of the drives (worst) | must | stated, 1 sd | within 2 sd | time a drive |",
             "| --- | --- | --- | --- | --- | --- |"]
    figures = []
    with tempfile.TemporaryDirectory(prefix="kawara-bench-mounting-") as folder:
        folder = pathlib.Path(folder)
        for size_px in (768, 1024):
            drives = [drive(folder / f"{size_px}-{seed}", seed, size_px, folder / "light")
                      for seed in range(1, options.seeds + 1)]
            figures += drives
            miss = np.array([d["miss_deg"] for d in drives])
            stated = np.array([d["stated_sd_deg"] for d in drives])
            rms, worst = np.sqrt((miss**2).mean(0)), np.abs(miss).max(0)
            within = np.mean(np.abs(miss) < 2 * stated)
            lines.append(f"| {size_px} x {size_px}, {len(drives)} drives of 53 m | "
                         + " / ".join(f"{r:.3f} ({w:.3f})" for r, w in zip(rms, worst))
                         + f" deg | {MUST_DEG} | " + " / ".join(f"{s:.3f}" for s in stated.mean(0))
                         + f" deg | {100 * within:.0f} % | {np.mean([d['seconds'] for d in drives]):.0f} s |")
            print(lines[-1], flush=True)
    table = "\n".join(lines)
    print(table)
    if options.json:
        pathlib.Path(options.json).write_text(json.dumps(figures, indent=1))
    if options.into:
        readme = pathlib.Path(options.into)
        before, rest = readme.read_text().split("<!-- mounting -->\n")
        readme.write_text(before + "<!-- mounting -->\n" + table + "\n<!-- /mounting -->" + rest.split("<!-- /mounting -->", 1)[1])


if __name__ == "__main__":
    main()
