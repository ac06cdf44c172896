"""Least squares under constraints on the shape, by scipy: derivatives are kept from being negative on a fine grid, which
is made finer about the places where they vanish, and the quadratic problem is solved as one of least distance by
non-negative least squares (Lawson and Hanson, chapter 23). Raw arithmetic of doubles in bases made here by numpy.

Run in this folder (scipy 1.17, numpy 2.4): python constrained.py > constrained.json
"""
import json

import numpy as np
from numpy.polynomial import chebyshev as C
from scipy.interpolate import BSpline
from scipy.optimize import nnls


def axis(kind, degree, domain, knots=None):
    low, high = domain
    if kind == "chebyshev":
        def rows(x, d=0):
            t = (2 * np.asarray(x) - low - high) / (high - low)
            out = []
            for j in range(degree + 1):
                c = np.zeros(degree + 1)
                c[j] = 1
                out.append(C.chebval(t, C.chebder(c, d) if d else c) * (2 / (high - low)) ** d)
            return np.array(out).T.reshape(len(x), -1)
        return rows

    def rows(x, d=0):
        n = len(knots) - degree - 1
        out = []
        for j in range(n):
            c = np.zeros(n)
            c[j] = 1
            b = BSpline(np.array(knots), c, degree)
            out.append(b.derivative(d)(x) if d else b(x))
        return np.array(out).T
    return rows


def solve(X, y, G):
    """min |Xc - y| with Gc >= 0."""
    q, r = np.linalg.qr(X)
    b = q.T @ y
    g = np.linalg.solve(r.T, G.T).T
    norms = np.linalg.norm(g, axis=1)
    g, used = g[norms > 0] / norms[norms > 0][:, None], norms > 0
    # nearest point of the cone to b: b + g'u with u >= 0 least |b + g'u|, the dual
    u, _ = nnls(g.T, -b, maxiter=100000)
    return np.linalg.solve(r, b + g.T @ u), np.flatnonzero(used)[u > 1e-12]


def curve(rows, x, y, constraints, domain):
    places = [np.linspace(*(c.get("domain") or domain), 1501) for c in constraints]
    for _ in range(5):
        G = np.vstack([s * rows(p, d) for p, (d, s) in zip(places, map(form, constraints))])
        c, active = solve(rows(x), y, G)
        at, start, fresh = [], 0, []
        for p in places:
            here = p[[k - start for k in active if start <= k < start + len(p)]]
            start += len(p)
            step = np.diff(np.unique(p)).min()
            more = (here[:, None] + np.linspace(-1.5, 1.5, 41) * step).ravel()
            fresh.append(np.unique(np.concatenate([p, more[(more >= p.min()) & (more <= p.max())]])))
        places = fresh
    return c


def form(c):
    return {"increasing": (1, 1), "decreasing": (1, -1), "convex": (2, 1), "concave": (2, -1)}[c["kind"]]


def noise(n, seed):
    return np.random.default_rng(seed).normal(size=n)


cases = []


def case(name, nodes, model, domain, constraints, c, heights, X):
    cases.append({"name": name, "nodes": nodes, "model": model, "domain": domain, "constraints": constraints,
                  "coefficients": c.tolist(), "rss": float(np.sum((X @ c - heights) ** 2))})


def one_curve(name, kind, degree, domain, y, x, constraints, knots=None):
    rows = axis(kind, degree, domain, knots)
    c = curve(rows, x, y, constraints, domain)
    model = {"type": kind, "degree": degree} | ({"knots": knots} if knots else {})
    case(name, {"x": x.tolist(), "y": y.tolist()}, model, {"u": domain}, constraints, c, y, rows(x))


x = np.linspace(0, 9, 40)
one_curve("rising_quintic", "chebyshev", 5, [0, 9], np.round(np.tanh(x - 5) + 0.25 * noise(40, 1), 6), x,
          [{"kind": "increasing"}])
one_curve("rising_and_bent", "chebyshev", 6, [0, 9], np.round(0.02 * x**2 + 0.3 * noise(40, 2), 6), x,
          [{"kind": "increasing"}, {"kind": "convex", "domain": [1, 6]}])
knots = [0.0] * 4 + [1.5, 3.0, 4.0, 5.5, 7.0] + [9.0] * 4
one_curve("concave_spline", "b_spline", 3, [0, 9], np.round(-0.1 * (x - 4) ** 2 + 0.4 * noise(40, 3), 6), x,
          [{"kind": "concave"}], knots)
one_curve("falling_spline", "b_spline", 3, [0, 9], np.round(np.exp(-x / 2) + 0.1 * noise(40, 4), 6), x,
          [{"kind": "decreasing"}, {"kind": "convex"}], knots)

# a surface that rises along u and is concave along v
u, v = np.linspace(0, 4, 9), np.linspace(-1, 3, 11)
du, dv = [0, 4], [-1, 3]
ru, rv = axis("chebyshev", 3, du), axis("chebyshev", 4, dv)
uu, vv = (a.ravel() for a in np.meshgrid(u, v, indexing="ij"))
z = np.round(0.3 * np.sqrt(uu + 0.1) - 0.05 * (vv - 1) ** 2 + 0.15 * noise(len(uu), 5), 6)


def product(a, b):
    return (a[:, :, None] * b[:, None, :]).reshape(len(a), -1)


X = product(ru(uu), rv(vv))
fine = [np.linspace(0, 4, 81), np.linspace(-1, 3, 81)]
pu, pv = (a.ravel() for a in np.meshgrid(*fine, indexing="ij"))
where = [(pu, pv), (pu, pv)]
for turn in range(8):
    (au, av), (bu, bv) = where
    G = np.vstack([product(ru(au, 1), rv(av)), -product(ru(bu), rv(bv, 2))])
    c, active = solve(X, z, G)
    size = 0.05 / 3**turn
    # only about the active places from now on, and the coarse grid
    fresh = []
    for (p, q), first in zip(where, (0, len(au))):
        here = [k - first for k in active if first <= k < first + len(p)]
        local = np.linspace(-2, 2, 17) * size
        mu, mv = (a.ravel() for a in np.meshgrid(local, local, indexing="ij"))
        nu = np.clip((p[here][:, None] + mu).ravel(), 0, 4)
        nv = np.clip((q[here][:, None] + mv).ravel(), -1, 3)
        fresh.append((np.concatenate([pu, p[here], nu]), np.concatenate([pv, q[here], nv])))
    where = fresh
case("surface", {"u": u.tolist(), "v": v.tolist(), "z": z.tolist()}, {"type": "chebyshev", "degree": [3, 4]},
     {"u": du, "v": dv}, [{"kind": "increasing", "along": "u"}, {"kind": "concave", "along": "v"}], c, z, X)

print(json.dumps({"name": "constrained", "source": "constrained.py (scipy's non-negative least squares)",
                  "cases": cases}, indent=1))
