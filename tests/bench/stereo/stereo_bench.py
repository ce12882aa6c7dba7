# programs: bench_stereo_pairs bench_stereo_several bench_stereo_poses kawara-sim kawara-mapper
"""./run bench stereo: distance images of rendered pairs (tests/support/stereo_lab.hpp: several seeds, true poses, noise
of two levels) by this project and by OpenCV on the same rectified pictures, in one run. Prints a Markdown table; figures
also as JSON. With --into README.md the table takes the place of the one between the marks there."""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np
from PIL import Image

MUST = {"1024": {"std_mm": 38.0, "nmad_mm": 18.0, "outliers": 0.5, "density": 97.0},
        "1024, several baselines": {"std_mm": 26.0, "nmad_mm": 11.0, "outliers": 0.2, "density": 99.0, "cpu_ms": 1500.0}}
PAIRS_PER_S = {"1024": 15.0, "2048": 3.0}
MARKS = ("<!-- ./run bench stereo -->\n", "<!-- end -->")


BIN = pathlib.Path(os.environ["KAWARA_BIN"])


def read_pfm(path):
    _, size, _, rows = path.read_bytes().split(b"\n", 3)
    width, height = map(int, size.split())
    return np.frombuffer(rows, "<f4").reshape(height, width)[::-1]


def simulated_road(position_m, attitude_deg):
    """kawara-mapper on frames that kawara-sim renders of the factory road: asphalt, a real street's texture."""
    errors, honest, wanted, outliers = [], 0, 0, 0
    with tempfile.TemporaryDirectory() as folder:
        survey, out = pathlib.Path(folder) / "survey", pathlib.Path(folder) / "ranges"
        subprocess.run([BIN / "kawara-sim", "--render", survey, "--doughnut-px", "1024", "--every", "0.5", "--start", "20",
                        "--duration", "3", "--pose-noise", str(position_m), "--attitude-noise", str(attitude_deg), "--no-body"], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        frames = sorted(p.stem for p in (survey / "frames").iterdir())
        for a, b in zip(frames, frames[1:]):
            subprocess.run([BIN / "kawara-mapper", survey, "--depth-only", a, b, "--out", out], check=True,
                           stdout=subprocess.DEVNULL)
            with Image.open(survey / "range" / f"{a}.png") as picture:
                truth = np.array(picture) / 1000.0
            ranges, sd = read_pfm(out / f"{a}_{b}.range.pfm"), read_pfm(out / f"{a}_{b}.sd.pfm")
            near = (truth >= 2.0) & (truth <= 6.0)
            known = near & np.isfinite(ranges)
            error = (ranges - truth)[known]
            wanted += near.sum()
            honest += (np.abs(error) < 2.0 * sd[known]).sum()
            errors.append(np.stack([error, truth[known]]))
    error, truth = np.concatenate(errors, axis=1)
    far = np.abs(error) > 0.1 * truth
    noise = f", poses {100 * position_m:.0f} cm, {attitude_deg} deg" if position_m > 0 else ""
    return {"condition": "factory road, simulated" + noise, "method": "kawara-mapper", "std_mm": 1e3 * error[~far].std(),
            "nmad_mm": 1482.6 * np.median(np.abs(error)), "outliers": 100.0 * far.mean(),
            "density": 100.0 * len(error) / wanted, "within_2_sd": 100.0 * honest / len(error)}


def measure(seeds):
    figures = []
    for program in (BIN / "bench_stereo_pairs", BIN / "bench_stereo_several", BIN / "bench_stereo_poses"):
        with subprocess.Popen([program, str(seeds)], stdout=subprocess.PIPE, text=True) as run:
            for line in run.stdout:
                figures.append(json.loads(line))
                print("  " + line.rstrip(), file=sys.stderr, flush=True)
        if run.returncode != 0:
            sys.exit(f"stereo_bench: {program} ended with {run.returncode}")
    figures += [simulated_road(0, 0), simulated_road(0.02, 0.1)]
    return figures


def markdown(figures):
    lines = ["| pictures | method | std / NMAD | outliers / density | vehicles: outliers / density | error < 2 deviations "
             "| CPU a distance image |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for f in figures:
        if f["method"] == "throughput":
            must = PAIRS_PER_S[f["condition"]]
            flag = "" if f["pairs_per_s"] >= must else " (!)"
            lines.append(f"| {f['condition']} | two threads, whole chain | | | | | {f['pairs_per_s']:.1f} pairs/s{flag} "
                         f"(must {must:.0f}) |")
            continue
        if f["method"] == "poses":
            lines.append(f"| {f['condition']} | step of 0.5 m: turn {f['turn_deg']:.4f} deg, length {f['length_percent']:.2f} % off; "
                         f"place {f['position_mm']:.1f} mm off | | | | | "
                         + (f"{f['cpu_ms_frame']:.0f} ms a frame |" if f["cpu_ms_frame"] > 0 else "|"))
            continue
        ours = f["method"].startswith("kawara")
        must = MUST.get(f["condition"]) if ours else None
        late = must and (f["std_mm"] > must["std_mm"] or f["nmad_mm"] > must["nmad_mm"])
        holes = must and (f["outliers"] > must["outliers"] or f["density"] < must["density"])
        slow = must and f.get("cpu_ms", 0.0) > must.get("cpu_ms", float("inf"))
        cells = [f["condition"], f["method"], f"{f['std_mm']:.1f} / {f['nmad_mm']:.1f} mm{' (!)' if late else ''}",
                 f"{f['outliers']:.2f} / {f['density']:.1f} %{' (!)' if holes else ''}",
                 f"{f['vehicle_outliers']:.2f} / {f['vehicle_density']:.1f} %" if "vehicle_outliers" in f else "",
                 f"{f['within_2_sd']:.1f} %" if ours else "", f"{f['cpu_ms']:.0f} ms{' (!)' if slow else ''}" if f.get("cpu_ms", 0) > 0 else ""]
        lines.append("| " + " | ".join(cells) + " |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--into", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=3)
    args = parser.parse_args()
    figures = measure(args.seeds)
    table = markdown(figures)
    print(table)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=1) + "\n")
    if args.into:
        text = args.into.read_text()
        before, mark, rest = text.partition(MARKS[0])
        if not mark:
            sys.exit(f"stereo_bench: {args.into} has no line {MARKS[0].strip()}")
        args.into.write_text(before + mark + table + "\n" + MARKS[1] + rest.partition(MARKS[1])[2])


if __name__ == "__main__":
    main()
