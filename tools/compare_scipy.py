#!/usr/bin/env python3
"""Times scipy's `interpolate` and ours on the same work with the same data, in one run, and compares the numbers.

Work: a bicubic least-squares surface over 100 × 100 nodes (uneven knots, 20 × 20 spans); its value at 1,000,000 scattered
places; its value on a grid of 1000 × 1000 places. Every method of scipy that does the work is timed; ours (the example
`compare_scipy`, built here with --release) with one thread and with as many as there are. Rounds of both take turns, and medians over
all rounds are compared, so that a machine's bad minute hits both. Exit status 1 if the numbers differ by more than the
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
    spline = interpolate.LSQBivariateSpline(
        s.ravel(), t.ravel(), d["z"].ravel(), d["knots_u"][4:-4], d["knots_v"][4:-4], kx=3, ky=3
    )
    return spline.get_coeffs().reshape(SPANS + 3, SPANS + 3)


def theirs(d, coefficients):
    """Work → method → (function, repetitions compared with the others')."""
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


def timed(function, repeats):
    seconds = []
    for _ in range(repeats):
        start = time.perf_counter()
        result = function()
        seconds.append(time.perf_counter() - start)
    return result, seconds


def build():
    command = ["cargo", "build", "--release", "--quiet", "--locked", "--example", "compare_scipy"]
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
        for _ in range(options.rounds):
            for label, threads in (("ours, 1 thread", 1), ("ours, all threads", None)):
                for work, seconds in ours(program, folder, options.repeats, threads).items():
                    taken.setdefault(work, {}).setdefault(label, []).extend(seconds)
            for work, functions in methods.items():
                for label, function in functions.items():
                    # the slow ones have waited long enough after one repetition
                    slow = median(taken[work].get(label, [0.0])) > 1.0 or label == "LSQBivariateSpline"
                    result, seconds = timed(function, 1 if slow else options.repeats)
                    taken[work].setdefault(label, []).extend(seconds)
                    results.setdefault(work, {})[label] = result
        mine = {
            work: np.fromfile(Path(folder) / name, dtype="<f8")
            for work, name in (("fit", "coefficients"), ("scattered", "scattered"), ("grid", "grid"))
        }

    print(f"scipy {scipy.__version__}, numpy {np.__version__}, {os.cpu_count()} threads; medians, in milliseconds")
    medians = {work: {label: median(seconds) for label, seconds in table.items()} for work, table in taken.items()}
    worst = 0.0
    for work, table in medians.items():
        best = min(seconds for label, seconds in table.items() if not label.startswith("ours"))
        alone = table["ours, 1 thread"]
        print(f"\n{work}: {best / alone:.1f} times as fast as scipy's fastest on one thread, "
              f"{best / table['ours, all threads']:.1f} on all")
        for label, seconds in sorted(table.items(), key=lambda row: row[1]):
            gap = ""
            if label in results[work]:
                other = np.asarray(results[work][label]).ravel()
                difference = np.max(np.abs(other - mine[work])) / np.max(np.abs(other))
                # surfit finds its solution through other equations and stops where single steps gain little
                counts = label != "LSQBivariateSpline"
                worst = max(worst, difference if counts else 0.0)
                gap = f"greatest difference from ours {difference:.1e}"
            print(f"  {label:32} {1e3 * seconds:10.3f}   {1e3 * seconds / (1e3 * alone):8.2f}   {gap}")
    if options.json:
        options.json.write_text(json.dumps(medians, indent=1) + "\n")
    if not worst <= options.tolerance:
        sys.exit(f"the numbers differ by {worst:.1e}, more than {options.tolerance:.0e}")


if __name__ == "__main__":
    main()
