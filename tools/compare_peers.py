#!/usr/bin/env python3
"""Times whole fits by numpy, scipy and R beside ours, on the same nodes, in one run, and compares what they find.

Work: bicubic B-spline surfaces of 64, 225 and 400 coefficients with a roughness penalty (its weight by GCV, or given);
rank dispersion, least absolute deviations and least trimmed squares on grids of which every tenth node is a gross
error; a fit behind the robust Gaussian filter. Theirs is what a practised user would write: generalised eigenvectors
for GCV, a Cholesky factor for a given weight, BFGS on the dispersion, `rq.fit.pfn` of R's quantreg, `ltsReg` of R's
robustbase, matrix products for the filter. Each counts from the nodes to the coefficients; ours answers errors, bounds
and diagnostics beside. One thread each, seconds of processors, rounds in turns, medians. R's rows need R with quantreg
and robustbase; without them they are left out, and a line says so.

Usage: compare_peers.py [--program PATH] [--rounds 5] [--only NAME] [--json FILE]
"""

import argparse
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median

# one thread: read by numpy's linear algebra when it is loaded
for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"

import numpy as np
import scipy
from numpy.polynomial import chebyshev
from scipy import linalg, optimize
from scipy.interpolate import BSpline

ROOT = Path(__file__).resolve().parent.parent
CUTOFF = 3.0
# √(q/π) with (1 + q) exp(−q) = 1/2, and 3/Φ⁻¹(3/4)
GAMMA, TUKEY = 0.730913428094675906, 4.447806655516806


def grid(nu, nv, gross):
    """A crowned flank with noise; a tenth of the nodes grossly wrong, or a wave on it."""
    u, v = np.linspace(5.97, 11.52, nu), np.linspace(0.75, 14.25, nv)
    s, t = np.meshgrid((u - 8.745) / 2.775, (v - 7.5) / 6.75, indexing="ij")
    rng = np.random.default_rng(1000 * nu + nv)
    z = 4.5 * s - 3 * s * s - 4 * t * t + 0.75 * s * t + rng.normal(0, 0.3, s.shape)
    if gross:
        z.ravel()[rng.random(z.size) < 0.1] += 25
    else:
        z += 2 * np.sin(3 * s) * np.cos(4 * t)
    return u, v, z


def unit(x):
    return 2 * (x - x[0]) / (x[-1] - x[0]) - 1


def cubic(u, v):
    """Columns of the tensor product of Chebyshev polynomials up to degree 3."""
    return np.kron(chebyshev.chebvander(unit(u), 3), chebyshev.chebvander(unit(v), 3))


def rank(u, v, z):
    x = cubic(u, v)
    centred = x[:, 1:] - x[:, 1:].mean(0)
    q, r = np.linalg.qr(centred)
    z = z.ravel()
    m = z.size
    scores = np.sqrt(12) * (np.arange(1, m + 1) / (m + 1) - 0.5)

    def dispersion(b):
        e = z - q @ b
        a = np.empty(m)
        a[np.argsort(e)] = scores
        return a @ e, -(q.T @ a)

    found = optimize.minimize(dispersion, q.T @ z, jac=True, method="BFGS", options={"gtol": 1e-6})
    b = linalg.solve_triangular(r, found.x)
    return np.concatenate([[np.median(z - x[:, 1:] @ b)], b])


def knots(x, spans):
    return np.concatenate([[x[0]] * 3, np.linspace(x[0], x[-1], spans + 1), [x[-1]] * 3])


def gram(t, derivative):
    """∫ φ⁽ᵏ⁾φ⁽ᵏ⁾ᵀ by Gauss's rule on every span."""
    n = len(t) - 4
    splines = BSpline(t, np.eye(n), 3)
    splines = splines.derivative(derivative) if derivative else splines
    nodes, weights = np.polynomial.legendre.leggauss(4)
    low, high = np.unique(t)[:-1, None], np.unique(t)[1:, None]
    values = splines((0.5 * (low + high) + 0.5 * (high - low) * nodes).ravel())
    return values.T @ (values * (0.5 * (high - low) * weights).ravel()[:, None])


def penalised(u, v, z, spans, weight=None):
    tu, tv = knots(u, spans), knots(v, spans)
    x = np.kron(BSpline.design_matrix(u, tu, 3).toarray(), BSpline.design_matrix(v, tv, 3).toarray())
    z = z.ravel()
    g, h, m = x.T @ x, x.T @ z, z.size
    p = np.kron(gram(tu, 2), gram(tv, 0)) + np.kron(gram(tu, 0), gram(tv, 2))
    if weight is not None:
        return linalg.cho_solve(linalg.cho_factor(g + weight * p), h)
    delta, w = linalg.eigh(p, g)
    a = w.T @ h

    def gcv(log):
        f = 1 / (1 + np.exp(log) * delta)
        return m * (z @ z - (a * a * (2 * f - f * f)).sum()) / (m - f.sum()) ** 2

    log = optimize.minimize_scalar(gcv, bounds=(-30, 20), method="bounded").x
    return w @ (a / (1 + np.exp(log) * delta))


def robust_gaussian(u, v, z):
    """The robust filter of order 2 along v, all lines until the last one stands, and the fit behind it."""
    t = (v[:, None] - v) / (GAMMA * CUTOFF)
    s = np.exp(-np.pi * t * t)
    powers = [s * t**k for k in range(5)]
    delta, heights = np.ones_like(z), z
    for _ in range(200):
        a, b, c, d, e = (delta @ p.T for p in powers)
        p, q, r = ((delta * z) @ p.T for p in powers[:3])
        det = a * (c * e - d * d) - b * (b * e - c * d) + c * (b * d - c * c)
        last, heights = heights, (p * (c * e - d * d) - b * (q * e - d * r) + c * (q * d - c * r)) / det
        away = z - heights
        scale = TUKEY * np.median(np.abs(away), axis=1)[:, None]
        if np.max(np.abs(heights - last) / scale) < 1e-6:
            break
        share = (away / scale) ** 2
        delta = np.where(share < 1, (1 - share) ** 2, 0)
    return np.linalg.lstsq(cubic(u, v), heights.ravel(), rcond=None)[0]


R_PROGRAM = """
suppressMessages(library({library}))
rd <- function(n) readBin(file.path("{folder}", n), "double", 1e7)
u <- rd("u"); v <- rd("v"); z <- rd("z")
ch <- function(x) {{ s <- 2 * (x - x[1]) / (x[length(x)] - x[1]) - 1; cbind(1, s, 2 * s^2 - 1, 4 * s^3 - 3 * s) }}
work <- function() {{ x <- kronecker(ch(u), ch(v)); {call} }}
set.seed(1); invisible(work())
for (i in 1:{repeats}) {{ t <- system.time(r <- work()); cat(t[1] + t[2], "") }}
cat("\\n")
cat(sprintf("%.17g", r), "\\n")
"""
R_CALLS = {
    "least_absolute_deviations": ("quantreg", "rq.fit.pfn(x, z, tau = 0.5)$coefficients"),
    "least_trimmed_squares": ("robustbase", "ltsReg(x[, -1], z, alpha = 0.5)$raw.coefficients"),
}


def in_r(work, folder, repeats):
    """Seconds and coefficients; None without R or the package."""
    if not shutil.which("Rscript"):
        return None
    library, call = R_CALLS[work]
    program = R_PROGRAM.format(library=library, folder=folder, call=call, repeats=repeats)
    done = subprocess.run(["Rscript", "-e", program], capture_output=True, text=True)
    if done.returncode:
        return None
    seconds, coefficients = done.stdout.strip().splitlines()
    return [float(t) for t in seconds.split()], np.array([float(x) for x in coefficients.split()])


def timed(function, repeats):
    taken = []
    for _ in range(repeats):
        start = time.process_time()
        found = function()
        taken.append(time.process_time() - start)
    return taken, found


# name, our work, nodes, theirs (None: R)
CASES = [
    *((f"Tikhonov gcv, n = {n}", f"tikhonov_gcv_{s}", (60, 60, False), lambda d, s=s: penalised(*d, s))
      for n, s in ((64, 5), (225, 12), (400, 17))),
    *((f"Tikhonov given, n = {n}", f"tikhonov_given_{s}", (60, 60, False), lambda d, s=s: penalised(*d, s, 1e-3))
      for n, s in ((64, 5), (225, 12), (400, 17))),
    *((f"rank, m = {nu * nv}", "rank", (nu, nv, True), lambda d: rank(*d))
      for nu, nv in ((25, 40), (125, 128), (250, 256))),
    *((f"least absolute deviations, m = {nu * nv}", "least_absolute_deviations", (nu, nv, True), None)
      for nu, nv in ((125, 128), (250, 256))),
    ("least trimmed squares, m = 1000", "least_trimmed_squares", (25, 40, True), None),
    ("robust Gaussian filter, 200 x 200", "robust_gaussian", (200, 200, True), lambda d: robust_gaussian(*d)),
]  # fmt: skip


def build():
    command = ["cargo", "build", "--release", "--quiet", "--locked", "--package", "engine-benches"]
    subprocess.run([*command, "--example", "compare_peers"], cwd=ROOT, check=True)
    target = Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target"))
    return target / "release" / "examples" / "compare_peers"


def ours(program, folder, work, repeats):
    command = [program, folder, work, str(repeats)]
    environment = {**os.environ, "RAYON_NUM_THREADS": "1"}
    done = subprocess.run(command, env=environment, check=True, capture_output=True, text=True)
    return json.loads(done.stdout)["seconds"]["processor"], np.fromfile(Path(folder) / "coefficients", "<f8")


def main():
    parser = argparse.ArgumentParser(description="Times numpy, scipy and R beside flankfit.")
    parser.add_argument("--program", type=Path, help="the example, already built")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--only", default="", help="cases whose names contain this")
    parser.add_argument("--json", type=Path, help="write the medians here")
    options = parser.parse_args()
    program = options.program.resolve() if options.program else build()
    print(f"scipy {scipy.__version__}, numpy {np.__version__}; seconds of a processor, medians in milliseconds")
    print(f"{'':40}{'ours':>10}{'theirs':>10}{'theirs/ours':>13}   greatest difference")
    rows = {}
    for name, work, nodes, function in CASES:
        if options.only not in name:
            continue
        d = grid(*nodes)
        with tempfile.TemporaryDirectory() as folder:
            for key, array in zip("uvz", d):
                np.ascontiguousarray(array, "<f8").tofile(Path(folder) / key)
            mine, others = [], []
            for _ in range(options.rounds):
                seconds, found = ours(program, folder, work, 3)
                mine += seconds
                theirs = in_r(work, folder, 3) if function is None else timed(lambda: function(d), 3)
                if theirs is None:
                    break
                others += theirs[0]
        row = {"ours": median(mine)}
        line = f"{name:40}{1e3 * row['ours']:10.2f}"
        if others:
            row["theirs"] = median(others)
            gap = np.max(np.abs(theirs[1] - found)) / np.max(np.abs(found))
            line += f"{1e3 * row['theirs']:10.2f}{row['theirs'] / row['ours']:13.2f}   {gap:.1e}"
        else:
            line += f"{'(no R with ' + R_CALLS[work][0] + ')':>30}"
        print(line, flush=True)
        rows[name] = row
    if options.json:
        options.json.write_text(json.dumps(rows, indent=1) + "\n")


if __name__ == "__main__":
    sys.exit(main())
