# programs: kawara-sim kawara-onboard
"""./run bench realtime: the robot's computer with every core saturated by other work. kawara-onboard triggers at each of 10 epochs
a second, once as it is meant to run (SCHED_FIFO, memory locked) and once as any program (realtime.priority: 0); what counts as
late is what the camera saw: the instant its trigger was pulled, by the simulator, against the true epoch.

Prints a Markdown table and draws the distribution (SVG, beside the JSON). The simulator runs on the same cores, at a real-time
priority below the robot's."""
import argparse
import csv
import json
import os
import pathlib
import subprocess
import sys
import tempfile

import numpy as np

from processes import SOURCE, Processes, wait_for

SETTLE_S = 20.0  # receiver set up, epochs learnt, pulses locked
DELAY_S = 0.0005  # trigger to exposure, of the simulated camera
BURN = "while True: sum(range(100000))"
# Caches and memory bus, and the disk's queue.
CHURN = """import os, tempfile
import numpy as np
a, b = np.zeros(4_000_000), np.ones(4_000_000)
with tempfile.TemporaryFile() as f:
    while True:
        for _ in range(50): a[:] = b
        f.seek(0); f.write(a[:500_000].tobytes()); f.flush(); os.fdatasync(f.fileno())
"""
CASES = (("SCHED_FIFO 60, memory locked", ()), ("normal priority", ("--set", "realtime.priority=0", "--set", "realtime.lock_memory=false")))


def rows(path):
    with open(path, newline="") as file:
        return list(csv.DictReader(file))


class Load:
    """Other work: one more busy process than there are cores."""

    def __enter__(self):
        programs = [BURN] * os.cpu_count() + [CHURN]
        self.running = [subprocess.Popen([sys.executable, "-c", p]) for p in programs]

    def __exit__(self, *exc):
        for process in self.running:
            process.kill()
            process.wait()


def drive(seconds, seed, options):
    """Lateness [s] of the triggers and how many epochs had none, in one drive past the settling."""
    with tempfile.TemporaryDirectory(prefix="kawara-realtime-") as folder, Processes(folder) as processes:
        folder = pathlib.Path(folder)
        run_dir = folder / "sim"
        sim = processes.start("sim", "kawara-sim", "site", "--site", SOURCE / "configs/sites/factory_road.yaml", "--robot",
                              SOURCE / "configs/vehicles/survey_robot.yaml", "--run-dir", run_dir, "--seed", seed, "--duration",
                              seconds, "--doughnut-px", 256, "--samples", 1, "--light-cell", 5, "--camera-delay", DELAY_S,
                              "--camera-jitter", 0, "--lead", 3)
        wait_for(lambda: (run_dir / "ready").exists() or sim.poll() is not None, 120, "the simulator")
        places = [x for key, name in (("gps.device", "gps"), ("ahrs.device", "ahrs"), ("gps.pps.device", "pps.sock"),
                                      ("camera.path", "camera.sock"), ("record.folder", "log"))
                  for x in ("--set", f"{key}={(folder if name == 'log' else run_dir) / name}")]
        with Load():
            processes.start("onboard", "kawara-onboard", "--config", SOURCE / "configs/survey_robot.yaml", *places, "--set",
                            "schedule.every_epochs=1", "--set", "picture.camera=equirectangular", "--set", "lcm_url=udpm://239.255.76.67:7667?ttl=0",
                            *options)
            processes.wait("sim", seconds + 120)
        processes.stop("onboard")
        epochs = np.array([int(r["mono_ns"]) for r in rows(run_dir / "truth_epochs.csv")])
        fired = np.array([int(r["mono_ns"]) for r in rows(run_dir / "truth_exposures.csv")]) - round(DELAY_S * 1e9)
        # The lead is the camera's: exposures lie on the epochs, triggers that much before.
        due = epochs - round(DELAY_S * 1e9)
        due = due[due > epochs[0] + SETTLE_S * 1e9][:-2]  # the last ones: the drive is over
        if len(fired) == 0:
            return np.array([]), len(due)
        nearest = np.array([fired[np.abs(fired - d).argmin()] - d for d in due]) / 1e9
        met = np.abs(nearest) < 0.05
        return nearest[met], int((~met).sum())


def histogram_svg(distributions):
    """Counts over the lateness, both on logarithmic scales."""
    edges = np.logspace(-6, -1, 51)
    width, height, left, top = 640, 330, 60, 60
    top_count = max(np.histogram(np.clip(np.abs(d), 1e-6, 0.0999), edges)[0].max() for d in distributions.values())
    x = lambda s: left + (np.log10(s) + 6) / 5 * (width - left - 20)
    y = lambda n: height - 40 - (np.log10(max(n, 0.5)) - np.log10(0.5)) / (np.log10(top_count) - np.log10(0.5)) * (height - 40 - top)
    parts = [f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" font-size="12">',
             f'<rect width="{width}" height="{height}" fill="white"/>']
    for exponent, label in ((-6, "1 us"), (-5, "10 us"), (-4, "0.1 ms"), (-3, "1 ms"), (-2, "10 ms"), (-1, "0.1 s")):
        parts.append(f'<text x="{x(10.0 ** exponent):.0f}" y="{height - 22}" text-anchor="middle">{label}</text>'
                     f'<line x1="{x(10.0 ** exponent):.0f}" x2="{x(10.0 ** exponent):.0f}" y1="{top}" y2="{height - 40}" stroke="#ddd"/>')
    for count in (1, 10, 100, 1000):
        if count <= top_count:
            parts.append(f'<text x="{left - 8}" y="{y(count) + 4:.0f}" text-anchor="end">{count}</text>')
    parts.append(f'<text x="14" y="{(top + height) / 2:.0f}" text-anchor="middle" transform="rotate(-90 14 {(top + height) / 2:.0f})">'
                 'triggers</text>')
    parts.append(f'<text x="{width / 2:.0f}" y="{height - 5}" text-anchor="middle">trigger later (or earlier) than its epoch</text>')
    for k, ((name, d), colour) in enumerate(zip(distributions.items(), ("#1f77b4", "#d62728"), strict=False)):
        counts = np.histogram(np.clip(np.abs(d), 1e-6, 0.0999), edges)[0]
        points = " ".join(f"{x(a):.1f},{y(n):.1f} {x(b):.1f},{y(n):.1f}" for a, b, n in zip(edges, edges[1:], counts))
        parts.append(f'<polyline points="{points}" fill="none" stroke="{colour}" stroke-width="2"/>'
                     f'<text x="{left}" y="{18 + 16 * k}" fill="{colour}">{name}: {len(d)} triggers, worst {np.abs(d).max() * 1e3:.2f} ms</text>')
    return "\n".join(parts + ["</svg>\n"])


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("--json")
    parser.add_argument("--into")
    parser.add_argument("--drives", type=int, default=6, help="of --seconds each; of the second case one")
    parser.add_argument("--seconds", type=float, default=120.0)
    options = parser.parse_args()
    lines, figures, distributions = [], {}, {}
    for k, (name, arguments) in enumerate(CASES):
        late, missed = [], 0
        for seed in range(1, (options.drives if k == 0 else 1) + 1):
            found = drive(options.seconds, seed, arguments)
            late.append(found[0])
            missed += found[1]
        late = np.concatenate(late)
        distributions[name] = late
        quantiles = [float(q) for q in np.quantile(np.abs(late), (0.5, 0.99, 0.999, 1.0))] if len(late) else []
        figures[name] = {"epochs": len(late) + missed, "missed": missed, "quantiles_s": quantiles}
        lines.append((name, f"{missed} of {len(late) + missed}", " / ".join(f"{1e3 * q:.2f}" for q in quantiles) + " ms"))
        print("  " + " | ".join(lines[-1]), file=sys.stderr, flush=True)
    head = ("kawara-onboard, every core busy with other work", "epochs without a trigger (must 0)",
            "trigger off its epoch: median / p99 / p99.9 / worst")
    table = "\n".join("| " + " | ".join(row) + " |" for row in (head, tuple("---" for _ in head), *lines))
    print(table)
    if options.json:
        path = pathlib.Path(options.json)
        path.write_text(json.dumps(figures, indent=1))
        path.with_suffix(".svg").write_text(histogram_svg(distributions))
        print(f"distribution: {path.with_suffix('.svg')}")
    if options.into:
        readme = pathlib.Path(options.into)
        before, rest = readme.read_text().split("<!-- realtime -->\n")
        readme.write_text(before + "<!-- realtime -->\n" + table + "\n<!-- /realtime -->" + rest.split("<!-- /realtime -->", 1)[1])


main()
