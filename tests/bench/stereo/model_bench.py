# programs: bench_stereo_model kawara-sim kawara-mapper
"""./run bench stereo: whole models by kawara-mapper from poses with noise of 2 cm and 0.1 deg a frame. Of a rendered street (several
seeds) how far their points are from its surfaces; of the factory road how long 200 pairs take, pictures to textured VRML. Prints a
Markdown table; figures also as JSON. With --into README.md the table takes the place of the one between the marks there."""
import argparse
import json
import os
import pathlib
import re
import subprocess
import sys
import tempfile

import numpy as np

BIN = pathlib.Path(os.environ["KAWARA_BIN"])
MARKS = ("<!-- ./run bench stereo: models -->\n", "<!-- end of models -->\n")
MUST = {"rms_mm": 45.0, "over_300_mm": 0.2, "completeness": 98.0, "seconds_200": 20.0}
FRAMES = 49
WAYS = ([], ["--baselines", "several", "--step", "0.5"], ["--step", "1.0"], ["--pole-cap", "10"], ["--given-poses"])


def run_mapper(survey, out, words):
    """Pairs, seconds by its own count, CPU seconds, and most memory [MB] of a whole model."""
    with subprocess.Popen([BIN / "kawara-mapper", survey, "--out", out, *words], stdout=subprocess.PIPE,
                          stderr=subprocess.DEVNULL, text=True) as run:
        said = run.stdout.read()
        _, status, usage = os.wait4(run.pid, 0)
        run.returncode = os.waitstatus_to_exitcode(status)
    if run.returncode != 0:
        sys.exit(f"model_bench: kawara-mapper {survey} ended with {run.returncode}")
    pairs, seconds = re.search(r"(\d+) pairs in ([0-9.]+) s", said).groups()
    return int(pairs), float(seconds), usage.ru_utime + usage.ru_stime, usage.ru_maxrss / 1024.0


def points_of(model):
    """The corners of all its tiles' faces, x y z [m]."""
    tiles = []
    for path in sorted(model.glob("*.ply")):
        header, _, body = path.read_bytes().partition(b"end_header\n")
        count = int(re.search(rb"element vertex (\d+)", header)[1])
        corner = np.dtype([("place", "<f8", 3), ("normal", "<f4", 3), ("colour", "u1", 3)])
        properties = re.findall(rb"property (\w+) (\w+)", header.partition(b"element face")[0])
        if b" ".join(kind for kind, _ in properties) != b"double double double float float float uchar uchar uchar":
            sys.exit(f"model_bench: {path} has other properties")
        tiles.append(np.frombuffer(body, corner, count)["place"])
    return np.concatenate(tiles)


def rendered(keep, name, *words):
    """The survey folder of that name; drawn if it is not there yet."""
    survey = keep / name
    if not survey.exists():
        unfinished = keep / (name + "_unfinished")
        subprocess.run([word if word is not None else unfinished for word in words], check=True, stdout=subprocess.DEVNULL,
                       stderr=subprocess.DEVNULL)
        unfinished.rename(survey)
    return survey


def street(seed, keep):
    figures = []
    survey = rendered(keep, f"street_{seed}", BIN / "bench_stereo_model", "survey", None, str(seed), str(FRAMES))
    with tempfile.TemporaryDirectory() as folder:
        for words in WAYS:
            out = pathlib.Path(folder) / "_".join(["model", *words])
            pairs, _, cpu_s, memory_mb = run_mapper(survey, out, words)
            judged = subprocess.run([BIN / "bench_stereo_model", "judge", str(seed), str(FRAMES)], check=True,
                                    input=points_of(out).astype("<f8").tobytes(), stdout=subprocess.PIPE)
            figures.append({"words": " ".join(words), "seed": seed, "pairs": pairs, "cpu_ms": 1e3 * cpu_s / pairs,
                            "memory_mb": memory_mb, **json.loads(judged.stdout)})
            print("  " + json.dumps(figures[-1]), file=sys.stderr, flush=True)
    return figures


def mean_of(figures):
    mean = {key: float(np.mean([f[key] for f in figures])) for key, value in figures[0].items() if not isinstance(value, str)}
    return {**mean, "condition": "rendered street", "words": figures[0]["words"],
            "rms_mm": float(np.sqrt(np.mean([f["rms_mm"] ** 2 for f in figures])))}


def road(keep):
    survey = rendered(keep, "road", BIN / "kawara-sim", "--render", None, "--doughnut-px", "1024", "--every", "0.25", "--start", "10",
                      "--duration", "45", "--no-body")
    with tempfile.TemporaryDirectory() as folder:
        pairs, seconds, cpu_s, memory_mb = run_mapper(survey, pathlib.Path(folder) / "model", [])
    return {"condition": "factory road", "words": "", "pairs": pairs, "seconds_200": 200.0 * seconds / pairs,
            "cpu_ms": 1e3 * cpu_s / pairs, "memory_mb": memory_mb}


def markdown(figures):
    lines = ["| pictures | kawara-mapper | points to surface, rms | over 0.3 m | complete | 200 pairs to textured VRML "
             "| CPU a pair, all in | memory |", "| --- | --- | --- | --- | --- | --- | --- | --- |"]
    for f in figures:
        def cell(key, text, worse=lambda value, must: value > must):
            return text.format(f[key]) + (" (!)" if worse(f[key], MUST[key]) else "") if key in f else ""
        lines.append("| " + " | ".join([
            f["condition"], f["words"], cell("rms_mm", "{:.1f} mm"), cell("over_300_mm", "{:.2f} %"),
            cell("completeness", "{:.1f} %", lambda value, must: value < must), cell("seconds_200", "{:.1f} s"),
            f"{f['cpu_ms']:.0f} ms", f"{f['memory_mb']:.0f} MB"]) + " |")
    lines.append(f"| must | | {MUST['rms_mm']:.0f} mm | {MUST['over_300_mm']} % | {MUST['completeness']:.0f} % "
                 f"| {MUST['seconds_200']:.0f} s | | 300 MB |")
    return "\n".join(lines)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path)
    parser.add_argument("--into", type=pathlib.Path)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--keep", type=pathlib.Path, help="folder in which the drawn pictures stay for the next run")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        keep = args.keep or pathlib.Path(folder)
        keep.mkdir(parents=True, exist_ok=True)
        streets = [street(seed, keep) for seed in range(1, args.seeds + 1)]
        figures = [mean_of(same) for same in zip(*streets)] + [road(keep)]
    table = markdown(figures)
    print(table)
    if args.json:
        args.json.write_text(json.dumps(figures, indent=1) + "\n")
    if args.into:
        text = args.into.read_text()
        before, mark, rest = text.partition(MARKS[0])
        if not mark:
            sys.exit(f"model_bench: {args.into} has no line {MARKS[0].strip()}")
        args.into.write_text(before + mark + table + "\n" + MARKS[1] + rest.partition(MARKS[1])[2])


if __name__ == "__main__":
    main()
