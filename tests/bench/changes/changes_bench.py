"""The third update on made streets: the factory road of the paper's scene (a truck and a wagon, put a little elsewhere by
every seed), 200 distance images of 1024 columns with the noise of the paper's stereo (151 mm rms over 2-6 m, 3 % outliers,
pose errors of 3 cm, 5 cm up and 0.1 deg drawn anew every 20 pictures), against a reference of 2 cm laser points.

  plain   that
  fine    voxels of 10 cm instead of 20
  hard    30 % of 8 x 8 blocks of pixels share their error, 15 % of blocks are elsewhere altogether
  offset  all poses 10 cm and 0.3 deg off
  far     all poses 50 cm off (30 east, 40 north): to be refused
  none    nothing has changed
  paper   Meguro et al.'s subtraction of 50 cm voxels and boxes by projection, on the same data

CPU: votes, see-through evidence, alignment and finding, of 200 pictures on one core; voting alone in million points a second.
precision, recall: of voxels of 20 cm (within 0.3 m of a changed surface; changed surfaces met within 0.2 m).
iou, centre, size, heading: of boxes, seen from above. width: of the road left beside them. 68 %, 95 %: share of errors
within one and 1.96 stated deviations (centre, size, heading).
sides: textures of what was found, from the drive's own pictures 2 m apart, beside the same side rendered from 3 m before it:
medians of the correlation of brightness as they lie, and of how far they must be shifted to fit best (texels of about 2 cm; looked for within 20 each way)."""
# programs: bench_changes_run
import argparse
import json
import os
import pathlib
import statistics
import subprocess

KINDS = ["plain", "fine", "hard", "offset", "far", "none", "paper"]


def run(kind, seed, pictures, columns):
    site = pathlib.Path(__file__).resolve().parents[3] / "configs/sites/factory_road.yaml"
    done = subprocess.run([os.environ["KAWARA_BIN"] + "/bench_changes_run", str(site), str(seed), str(pictures), str(columns), kind],
                          capture_output=True, text=True, check=True)
    return json.loads(done.stdout)


def row(kind, runs):
    refused = [r["reason"] for r in runs if r["refused"]]
    runs = [r for r in runs if not r["refused"]]
    if not runs:
        return {"kind": kind, "drives": 0, "refused": len(refused), "reasons": sorted(set(refused))}
    boxes = [b for r in runs for b in r["boxes"]]
    widths = [w for r in runs for w in r["width"]]
    sides = [s for r in runs for s in r["sides"]]
    z = [abs(v) for b in boxes for v in b["z"]]
    median = lambda values: statistics.median(values) if values else float("nan")
    return {
        "kind": kind,
        "drives": len(runs),
        "refused": len(refused),
        "reasons": sorted(set(refused)),
        "precision": statistics.fmean(r["precision"] for r in runs),
        "recall": statistics.fmean(r["recall"] for r in runs),
        "found": f'{len(boxes)}/{sum(r["truth"] for r in runs)}',
        "false": sum(r["false"] for r in runs),
        "iou": statistics.fmean(b["iou"] for b in boxes) if boxes else float("nan"),
        "iou_min": min((b["iou"] for b in boxes), default=float("nan")),
        "centre_m": median([b["centre"] for b in boxes]),
        "size_m": median([abs(s) for b in boxes for s in b["size"]]),
        "heading_deg": median([abs(b["heading_deg"]) for b in boxes]),
        "width_m": median([abs(w[0]) for w in widths]),
        "width_max_m": max((abs(w[0]) for w in widths), default=float("nan")),
        "too_wide": sum(w[0] > 2 * w[1] for w in widths) / max(1, len(widths)),
        "in_68": sum(v < 1.0 for v in z) / max(1, len(z)),
        "in_95": sum(v < 1.96 for v in z) / max(1, len(z)),
        "sides": len(sides),
        "side_seen": median([s["seen"] for s in sides]),
        "side_correlation": median([s["correlation"] for s in sides]),
        "side_aligned": median([s["aligned"] for s in sides]),
        "side_off_px": median([s["off_px"] for s in sides]),
        "side_make_ms": 1000 * max((s["make_s"] for s in sides), default=float("nan")),
        "atlas_kb": max((s["kb"] for s in sides), default=float("nan")),
        "cpu_s": statistics.fmean(r["vote_s"] + r["examine_s"] + r["align_s"] + r["find_s"] for r in runs),
        "votes_mpt_s": 1e-6 * sum(r["votes"] for r in runs) / sum(r["vote_s"] for r in runs),
        "map_mb": max(r["map_mb"] for r in runs),
    }


def table(rows):
    lines = ["| drive | voxels: precision, recall | objects found, false | box IoU: mean, least | centre, size, heading (medians) "
             "| width left: median, worst | more than 2 sd too wide | within 68 %, 95 % | CPU, votes, map | sides: correlation, off, atlas |",
             "| --- | --- | --- | --- | --- | --- | --- | --- | --- | --- |"]
    for r in rows:
        if r["drives"] == 0:
            lines.append(f'| {r["kind"]}: all {r["refused"]} refused |' + " |" * 9)
            continue
        name = r["kind"] + (f', {r["refused"]} more refused' if r["refused"] else "")
        lines.append(
            f'| {name} | {r["precision"]:.3f}, {r["recall"]:.3f} | {r["found"]}, {r["false"]} | {r["iou"]:.2f}, {r["iou_min"]:.2f} '
            f'| {r["centre_m"]:.2f} m, {r["size_m"]:.2f} m, {r["heading_deg"]:.1f} deg | {r["width_m"]:.2f}, {r["width_max_m"]:.2f} m '
            f'| {100 * r["too_wide"]:.0f} % | {100 * r["in_68"]:.0f} %, {100 * r["in_95"]:.0f} % | {r["cpu_s"]:.1f} s, {r["votes_mpt_s"]:.0f} Mpt/s, {r["map_mb"]:.0f} MB '
            f'| {r["side_correlation"]:.2f}, {r["side_off_px"]:.1f} px, {r["atlas_kb"]:.0f} kB |')
    return "\n".join(lines).replace("nan", "-")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=pathlib.Path, required=True)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--pictures", type=int, default=200)
    parser.add_argument("--columns", type=int, default=1024)
    parser.add_argument("--into", type=pathlib.Path, help="replace the table of this Markdown file")
    args = parser.parse_args()
    rows, raw = [], {}
    for kind in KINDS:
        raw[kind] = [run(kind, seed, args.pictures, args.columns) for seed in range(1, args.seeds + 1)]
        rows.append(row(kind, raw[kind]))
    args.json.parent.mkdir(parents=True, exist_ok=True)
    args.json.write_text(json.dumps({"rows": rows, "drives": raw}, indent=1))
    print(table(rows))
    if args.into:
        text = args.into.read_text()
        begin, end = "<!-- changes table -->\n", "<!-- end of changes table -->"
        head, rest = text.split(begin)
        args.into.write_text(head + begin + table(rows) + "\n" + end + rest.split(end)[1])


if __name__ == "__main__":
    main()
