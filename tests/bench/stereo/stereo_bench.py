# programs: bench_stereo_pairs
"""./run bench stereo: distance images of rendered pairs (tests/support/stereo_lab.hpp: several seeds, true poses, noise
of two levels) by this project and by OpenCV on the same rectified pictures, in one run. Prints a Markdown table; figures
also as JSON. With --into README.md the table takes the place of the one between the marks there."""
import argparse
import json
import os
import pathlib
import subprocess
import sys

MUST = {"std_mm": 38.0, "nmad_mm": 18.0, "outliers": 0.5, "density": 97.0}
PAIRS_PER_S = {"1024": 15.0, "2048": 3.0}
MARKS = ("<!-- ./run bench stereo -->\n", "<!-- end -->")


def measure(seeds):
    program = pathlib.Path(os.environ["KAWARA_BIN"]) / "bench_stereo_pairs"
    with subprocess.Popen([program, str(seeds)], stdout=subprocess.PIPE, text=True) as run:
        figures = []
        for line in run.stdout:
            figures.append(json.loads(line))
            print("  " + line.rstrip(), file=sys.stderr, flush=True)
    if run.returncode != 0:
        sys.exit(f"stereo_bench: {program} ended with {run.returncode}")
    return figures


def markdown(figures):
    lines = ["| pictures | method | std / NMAD | outliers / density | vehicles: outliers / density | error < 2 deviations "
             "| CPU a pair |", "| --- | --- | --- | --- | --- | --- | --- |"]
    for f in figures:
        if f["method"] == "throughput":
            must = PAIRS_PER_S[f["condition"]]
            flag = "" if f["pairs_per_s"] >= must else " (!)"
            lines.append(f"| {f['condition']} | two threads, whole chain | | | | | {f['pairs_per_s']:.1f} pairs/s{flag} "
                         f"(must {must:.0f}) |")
            continue
        ours = f["method"].startswith("kawara")
        judged = ours and f["condition"] == "1024"
        late = judged and (f["std_mm"] > MUST["std_mm"] or f["nmad_mm"] > MUST["nmad_mm"])
        holes = judged and (f["outliers"] > MUST["outliers"] or f["density"] < MUST["density"])
        lines.append(
            f"| {f['condition']} | {f['method']} | {f['std_mm']:.1f} / {f['nmad_mm']:.1f} mm{' (!)' if late else ''} "
            f"| {f['outliers']:.2f} / {f['density']:.1f} %{' (!)' if holes else ''} "
            f"| {f['vehicle_outliers']:.2f} / {f['vehicle_density']:.1f} % "
            f"| {f['within_2_sd']:.1f} %" if ours else
            f"| {f['condition']} | {f['method']} | {f['std_mm']:.1f} / {f['nmad_mm']:.1f} mm "
            f"| {f['outliers']:.2f} / {f['density']:.1f} % "
            f"| {f['vehicle_outliers']:.2f} / {f['vehicle_density']:.1f} % | -")
        lines[-1] += f" | {f['cpu_ms']:.0f} ms |"
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
