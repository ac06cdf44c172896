"""Makes prior_chain.json: a Kalman filter in covariance form, with 50 digits (mpmath).

Cubic powers of x over different nodes in each of four iterations; a correction was made after the
second. Every step is as the definition has it: predict, innovate, update; explicit inverses.
"""
import json
from mpmath import mp, mpf, matrix, log, exp, det, inverse, betainc, sqrt

mp.dps = 50
N = 4


def design(xs):
    return matrix([[mpf(x) ** j for j in range(N)] for x in xs])


truth = [[1.0, -2.0, 0.5, 3.0], [1.02, -2.01, 0.52, 2.99], [1.3, -2.2, 0.5, 3.1], [1.31, -2.19, 0.49, 3.12]]
iterations = []
for k, count in enumerate([9, 12, 10, 11]):
    xs = [float((7 * i + 3 * k) % 25) / 8 - 1.5 for i in range(count)]
    noise = [((37 * i + 11 * k * k) % 29 - 14) / 60 for i in range(count)]
    ys = [float(sum(a * x ** j for j, a in enumerate(truth[k])) + e) for x, e in zip(xs, noise)]
    iterations.append({"x": xs, "y": ys})
# predicted change of each height of iteration 2: not of the model alone
change = [0.25 - 0.18 * x + 0.1 * x ** 3 + 0.01 * ((i % 3) - 1) for i, x in enumerate(iterations[1]["x"])]
iterations[1]["change"] = change

fits, rss, freedom = [], mpf(0), 0
for one in iterations:
    x, y = design(one["x"]), matrix([mpf(v) for v in one["y"]])
    covariance = inverse(x.T * x)
    a = covariance * (x.T * y)
    r = y - x * a
    rss += (r.T * r)[0]
    freedom += len(one["x"]) - N
    fits.append((a, covariance))
variance = rss / freedom
x = design(iterations[1]["x"])
shift = inverse(x.T * x) * (x.T * matrix([mpf(v) for v in change]))
shifts = [matrix(N, 1), shift, matrix(N, 1)]
ratios = [mpf(0)] + [exp(log(mpf("0.01")) + (log(mpf(20)) - log(mpf("0.01"))) * i / 66) for i in range(67)]


def run(move):
    """Posterior, log-likelihoods before and with the last jump, the last distance."""
    a, p = fits[0][0], variance * fits[0][1]
    ln, before, distance = mpf(0), mpf(0), mpf(0)
    for k in range(1, 4):
        a, p = a + shifts[k - 1], p + move
        own, cov = fits[k][0], variance * fits[k][1]
        s, e = p + cov, own - a
        distance = (e.T * inverse(s) * e)[0]
        before, ln = ln, ln - (distance + log(det(s))) / 2
        gain = p * inverse(s)
        a, p = a + gain * e, p - gain * p
    return a, p, before, ln, distance


def tail(f, a, b):
    return betainc(mpf(b) / 2, mpf(a) / 2, 0, b / (b + a * f), regularized=True)


def mix(branches):
    most = max(b[3] for b in branches)
    weights = [exp(b[3] - most) for b in branches]
    total = sum(weights)
    weights = [w / total for w in weights]
    mean, cov = matrix(N, 1), matrix(N, N)
    for w, b in zip(weights, branches):
        mean += w * b[0]
    for w, b in zip(weights, branches):
        d = b[0] - mean
        cov += w * (b[1] + d * d.T)
    most = max(b[2] for b in branches)
    earlier = [exp(b[2] - most) for b in branches]
    earlier = [w / sum(earlier) for w in earlier]
    statistic = sum(w * b[4] / N for w, b in zip(earlier, branches))
    p = sum(w * tail(b[4] / N, N, freedom) for w, b in zip(earlier, branches))
    ls = fits[3][1]
    return {
        "value_dec": [mp.nstr(mean[j], 25) for j in range(N)],
        "std_error": [float(sqrt(cov[j, j])) for j in range(N)],
        "covariance": [[float(cov[i, j]) for j in range(i + 1)] for i in range(N)],
        "share": [float(1 - cov[j, j] / (variance * ls[j, j])) for j in range(N)],
        "statistic": float(statistic),
        "p": float(p),
        "weights": weights,
    }


estimated = mix([run(q * q * variance * fits[3][1]) for q in ratios])
estimated["move_ratio"] = float(sqrt(sum(w * q * q for w, q in zip(estimated["weights"], ratios))))
deviations = [0.05, 0.08, 0.02, 0.06]
told = mix([run(matrix([[mpf(d) ** 2 if i == j else mpf(0) for j in range(N)] for i, d in enumerate(deviations)]))])
for result in (estimated, told):
    del result["weights"]
print(json.dumps({
    "source": "nodes and formula of prior_chain.py",
    "licence": "none needed",
    "verification": "mpmath, 50 digits, covariance form (prior_chain.py)",
    "iterations": iterations,
    "sigma": float(sqrt(variance)),
    "degrees_of_freedom": freedom,
    "move_std_error": deviations,
    "estimated": estimated,
    "told": told,
}, indent=1))
