#!/usr/bin/env python3
"""Times scipy's `interpolate` and ours on the same work with the same data, in one run, and compares the numbers.

Work: a bicubic least-squares surface over 100 × 100 nodes (uneven knots, 20 × 20 spans); its value at 1,000,000 scattered
places; its value on a grid of 1000 × 1000 places. Every method of scipy that does the work is timed; ours (the example
`compare_scipy`, built here with --release) with one thread and with as many as there are. Rounds of both take turns, and medians over
all rounds are compared, so that a machine's bad minute hits both: seconds of the clock, and seconds of processors, which others
on the machine touch less. "times" is against ours on one thread. Exit status 1 if the numbers differ by more than the
tolerance (relative to the greatest of them).

Usage: compare_scipy.py [--program PATH] [--rounds 5] [--repeats 5] [--tolerance 1e-12] [--json FILE]
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

import numpy as np
import scipy
from scipy import interpolate

NODES = 100
SPANS = 20
PLACES = 1_000_000
LINES = 1000
ROOT = Path(__file__).resolve().parent.parent


def uneven_knots(low, high, rng):
    """A full cubic knot vector whose inner knots stand off even spacing by up to a third of a step."""
    step = (high - low) / SPANS
    inner = low + step * (np.arange(1, SPANS) + rng.uniform(-1 / 3, 1 / 3, SPANS - 1))
    return np.concatenate([[low] * 4, inner, [high] * 4])


def data():
    rng = np.random.default_rng(4)
    u, v = np.linspace(5.97, 11.52, NODES), np.linspace(0.75, 14.25, NODES)
    s, t = np.meshgrid(u, v, indexing="ij")
    z = np.sin(s) * np.cos(0.5 * t) + 0.02 * s * t + rng.normal(0.0, 1e-3, s.shape)
    at = np.column_stack([rng.uniform(u[0], u[-1], PLACES), rng.uniform(v[0], v[-1], PLACES)])
    return {
        "u": u,
        "v": v,
        "z": z,
        "knots_u": uneven_knots(u[0], u[-1], rng),
        "knots_v": uneven_knots(v[0], v[-1], rng),
        "at": at,
        "grid_u": np.linspace(u[0], u[-1], LINES),
        "grid_v": np.linspace(v[0], v[-1], LINES),
    }


def lsq_twice(d, **options):
    """Least squares along u, then along v: the tensor product's own least squares."""
    half = interpolate.make_lsq_spline(d["u"], d["z"], d["knots_u"], 3, **options).c
    return interpolate.make_lsq_spline(d["v"], half.T, d["knots_v"], 3, **options).c.T


def lsq_bivariate(d):
    """FITPACK's surfit, which takes the nodes as scattered ones."""
    s, t = np.meshgrid(d["u"], d["v"], indexing="ij")
    return interpolate.LSQBivariateSpline(
        s.ravel(), t.ravel(), d["z"].ravel(), d["knots_u"][4:-4], d["knots_v"][4:-4], kx=3, ky=3
    )


def theirs(d, coefficients):
    """Work → method of scipy → function."""
    tck = (d["knots_u"], d["knots_v"], coefficients.ravel(), 3, 3)
    spline = interpolate.SmoothBivariateSpline._from_tck(tck)
    nd = interpolate.NdBSpline((d["knots_u"], d["knots_v"]), coefficients, 3)
    crossings = np.stack(np.meshgrid(d["grid_u"], d["grid_v"], indexing="ij"), axis=-1)
    u, v = d["at"][:, 0].copy(), d["at"][:, 1].copy()
    fits = {"make_lsq_spline twice": lambda: lsq_twice(d), "LSQBivariateSpline": lambda: lsq_bivariate(d)}
    try:
        lsq_twice(d, method="norm-eq")
        fits["make_lsq_spline twice, norm-eq"] = lambda: lsq_twice(d, method="norm-eq")
    except TypeError:
        pass  # an older scipy, whose only method this is
    return {
        "fit": fits,
        "scattered": {
            "BivariateSpline.ev": lambda: spline.ev(u, v),
            "NdBSpline": lambda: nd(d["at"]),
        },
        "grid": {
            "BivariateSpline (grid)": lambda: spline(d["grid_u"], d["grid_v"]),
            "bisplev": lambda: interpolate.bisplev(d["grid_u"], d["grid_v"], tck),
            "NdBSpline": lambda: nd(crossings),
        },
    }


def timed(function, repeats, batch):
    """The last result, and seconds for each repetition of `batch` calls, by the clock and of processors."""
    seconds = {"clock": [], "processor": []}
    for _ in range(repeats):
        start, busy = time.perf_counter(), time.process_time()
        for _ in range(batch):
            result = function()
        seconds["processor"].append((time.process_time() - busy) / batch)
        seconds["clock"].append((time.perf_counter() - start) / batch)
    return result, seconds


def differences(d, work, result, mine):
    """The greatest difference from ours, relative to the greatest number."""
    result = np.asarray(result)
    if result.ndim == 0:
        # surfit puts its outer knots elsewhere, so its coefficients are others: what counts is the surface
        result, work = result.item()(d["grid_u"], d["grid_v"]), "grid"
    return np.max(np.abs(result.ravel() - mine[work])) / np.max(np.abs(result))


def build():
    command = ["cargo", "build", "--release", "--quiet", "--locked", "--package", "engine-benches", "--example", "compare_scipy"]
    subprocess.run(command, cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return target / "release" / "examples" / "compare_scipy"


def ours(program, folder, repeats, threads):
    environment = dict(os.environ)
    if threads:
        environment["RAYON_NUM_THREADS"] = str(threads)
    done = subprocess.run([program, folder, str(repeats)], env=environment, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def main():
    parser = argparse.ArgumentParser(description="Times scipy and flankfit on the same work.")
    parser.add_argument("--program", type=Path, help="the example, already built")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--tolerance", type=float, default=1e-12)
    parser.add_argument("--json", type=Path, help="write the medians here")
    options = parser.parse_args()
    program = options.program.resolve() if options.program else build()

    d = data()
    with tempfile.TemporaryDirectory() as folder:
        for name, array in d.items():
            np.ascontiguousarray(array, dtype="<f8").tofile(Path(folder) / name)
        methods = theirs(d, lsq_twice(d))
        taken, results = {}, {}

        def note(work, label, seconds):
            for kind, values in seconds.items():
                taken.setdefault(work, {}).setdefault(label, {}).setdefault(kind, []).extend(values)

        for _ in range(options.rounds):
            for label, threads in (("ours, 1 thread", 1), ("ours, all threads", None)):
                for work, seconds in ours(program, folder, options.repeats, threads).items():
                    note(work, label, seconds)
            for work, functions in methods.items():
                for label, function in functions.items():
                    quick = label.startswith("make_lsq_spline")
                    result, seconds = timed(function, options.repeats, 100 if quick else 1)
                    note(work, label, seconds)
                    results.setdefault(work, {})[label] = result
        mine = {
            work: np.fromfile(Path(folder) / name, dtype="<f8")
            for work, name in (("fit", "coefficients"), ("scattered", "scattered"), ("grid", "grid"))
        }

    print(f"scipy {scipy.__version__}, numpy {np.__version__}, {os.cpu_count()} threads; medians in milliseconds")
    medians = {
        work: {label: {kind: median(v) for kind, v in kinds.items() if v} for label, kinds in table.items()}
        for work, table in taken.items()
    }
    worst = 0.0
    for work, table in medians.items():
        print(f"\n{work:34}{'clock':>11}{'times':>8}{'processor':>13}{'times':>8}   greatest difference")
        alone = table["ours, 1 thread"]
        for label, kinds in sorted(table.items(), key=lambda row: row[1]["clock"]):
            cells = ""
            for kind, width in (("clock", 11), ("processor", 13)):
                known = kind in kinds and kind in alone
                cells += f"{1e3 * kinds[kind]:{width}.3f}{kinds[kind] / alone[kind]:8.2f}" if known else " " * (width + 8)
            gap = ""
            if label in results[work]:
                gap = differences(d, work, results[work][label], mine)
                worst = max(worst, gap)
                gap = f"{gap:.1e}"
            print(f"  {label:32}{cells}   {gap}")
    if options.json:
        options.json.write_text(json.dumps(medians, indent=1) + "\n")
    if not worst <= options.tolerance:
        sys.exit(f"the numbers differ by {worst:.1e}, more than {options.tolerance:.0e}")


if __name__ == "__main__":
    main()
