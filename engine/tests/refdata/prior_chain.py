"""Makes prior_chain.json: a Kalman filter in covariance form, with 50 digits (mpmath).

Cubic powers of x over different nodes in each of four iterations; a correction was made after the
second. Every step is as the definition has it: predict, innovate, update; explicit inverses.
Intervals by the definition of engine/estimation/src/prior/form_interval.rs.
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
    alone = len(one["x"]) - N
    variance_alone = (r.T * r)[0] / alone
    fits.append((a, covariance))
variance = rss / freedom
x = design(iterations[1]["x"])
shift = inverse(x.T * x) * (x.T * matrix([mpf(v) for v in change]))
shifts = [matrix(N, 1), shift, matrix(N, 1)]
ratios = [mpf(0)] + [exp(log(mpf("0.01")) + (log(mpf(20)) - log(mpf("0.01"))) * i / 66) for i in range(67)]


def run(move, last=None):
    """Posterior, log-likelihoods before and with the last jump, the last distance, and what was
    predicted before it. The last move may be another."""
    a, p = fits[0][0], variance * fits[0][1]
    ln, before, distance = mpf(0), mpf(0), mpf(0)
    for k in range(1, 4):
        a, p = a + shifts[k - 1], p + (last if last is not None and k == 3 else move)
        predicted = a, p
        own, cov = fits[k][0], variance * fits[k][1]
        s, e = p + cov, own - a
        distance = (e.T * inverse(s) * e)[0]
        before, ln = ln, ln - (distance + log(det(s))) / 2
        gain = p * inverse(s)
        a, p = a + gain * e, p - gain * p
    return a, p, before, ln, distance, predicted


def tail(f, a, b):
    return betainc(mpf(b) / 2, mpf(a) / 2, 0, b / (b + a * f), regularized=True)


def normed(logarithms):
    most = max(logarithms)
    weights = [exp(l - most) for l in logarithms]
    total = sum(weights)
    return [w / total for w in weights]


def ln_sum(logarithms):
    most = max(logarithms)
    return most + log(sum(exp(l - most) for l in logarithms))


def median(weights):
    total = mpf(0)
    for k, w in enumerate(weights):
        total += w
        if total >= mpf(1) / 2:
            return k


def mix(branches, stepped=()):
    """Moments of the posterior of branches, and of those with a step of probability 0.2."""
    logarithms = [b[3] for b in branches]
    if stepped:
        logarithms = [l + log(mpf(4) / 5) for l in logarithms]
        earlier = ln_sum([b[2] for b in branches])
        logarithms += [earlier + b[3] - b[2] + log(mpf(1) / 5 / len(stepped)) for b in stepped]
    weights = normed(logarithms)
    mean, cov = matrix(N, 1), matrix(N, N)
    for w, b in zip(weights, [*branches, *stepped]):
        mean += w * b[0]
    for w, b in zip(weights, [*branches, *stepped]):
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
    }


def student(t):
    """P(T > t), by the degrees of freedom of the nodes of now."""
    if t < 0:
        return 1 - student(-t)
    return betainc(mpf(alone) / 2, mpf(1) / 2, 0, alone / (alone + t * t), regularized=True) / 2


def beside(j, predicted):
    """Mean and variance of coefficient j by a prediction and by all sums of least squares of now whose
    errors have nothing to do with that of its own, and the log-likelihood of these."""
    a, p = predicted
    c = variance * fits[3][1]
    sums = matrix([[mpf(int(i == k)) - (c[i, j] / c[j, j] if k == j else 0) for k in range(N)]
                   for i in range(N) if i != j])
    spread = inverse(sums * (p + c) * sums.T)
    error = sums * (fits[3][0] - a)
    along = sums * p[:, j]
    ln = -((error.T * spread * error)[0] - log(det(spread))) / 2
    return a[j] + (along.T * spread * error)[0], p[j, j] - (along.T * spread * along)[0], ln


def interval(j, branches, stepped, value):
    """That of coefficient j at level 0.95, widened to the value."""
    pooled = sqrt(variance * fits[3][1][j, j])
    unit = sqrt(variance_alone * fits[3][1][j, j])
    y = fits[3][0][j] / unit
    before = [log(max(q, mpf("0.01"))) for q in ratios]
    own = []
    for q in ratios:
        m, v, ln = fits[0][0][j] / pooled, variance * fits[0][1][j, j] / pooled ** 2, mpf(0)
        for k in range(1, 3):
            m, v = m + shifts[k - 1][j] / pooled, v + q * q
            seen, spread = fits[k][0][j] / pooled, variance * fits[k][1][j, j] / pooled ** 2
            ln -= ((seen - m) ** 2 / (v + spread) + log(v + spread)) / 2
            m, v = m + v / (v + spread) * (seen - m), v * spread / (v + spread)
        own.append((ln, pooled * (m + shifts[2][j] / pooled), pooled ** 2 * (v + q * q)))
    both = [b[2] + l for b, l in zip(branches, before)]
    single = [o[0] + l for o, l in zip(own, before)]
    rest = [b - a + l for b, a, l in zip(both, single, before)]
    odds = mpf(9) * exp(ln_sum(single) + ln_sum(rest) - ln_sum(both) - ln_sum(before))
    share = odds / (1 + odds)
    found = [beside(j, b[5]) for b in branches]
    seen = [l + f[2] for l, f in zip(both, found)]
    parts = []
    for w, u, f, o in zip(normed(seen), normed(single), found, own):
        parts.append(((1 - share) * w, f[0], f[1]))
        parts.append((share * u, o[1], o[2]))
    _, m, v = parts[median([w for w, _, _ in parts])]
    parts = [(w * mpf(7) / 10, m, v) for w, m, v in parts]
    single = mpf(15) / 100 / len(steps)
    parts += [(single, m, v + (s * pooled) ** 2) for s in [*steps, *far]]
    still = ln_sum(seen) - ln_sum(both)
    whole = [(single * exp(f[2] - still), f[0], f[1]) for f in (beside(j, b[5]) for b in stepped)]
    w, m, v = max(whole, key=lambda part: part[0])
    parts += whole + [(single * w, m, v + (s * pooled) ** 2) for s in far]
    parts = [(w, m / unit, v / unit ** 2) for w, m, v in parts]

    def mean(c):
        weights = [w * exp(-(c - m) ** 2 / (1 + v) / 2) / sqrt(1 + v) for w, m, v in parts]
        return sum(w * (m + v / (1 + v) * (c - m)) for w, (_, m, v) in zip(weights, parts)) / sum(weights)

    def held(c):
        aside, distance = abs(c - mean(c)), abs(c - y)
        return student(distance - aside) + student(distance + aside) >= mpf("0.05")

    def end(way):
        last = next(d for d in (mpf(k) / 4 for k in range(80, -1, -1)) if held(y + way * d))
        low, high = last, last + mpf(1) / 4
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (middle, high) if held(y + way * middle) else (low, middle)
        return unit * mean(y + way * low)

    return [float(min(end(-1), value)), float(max(end(1), value))]


own = variance * fits[3][1]
branches = [run(q * q * own) for q in ratios]
middle = ratios[median(normed([b[2] for b in branches]))]
steps = [sqrt(mpf(10)) ** k for k in range(7)]
far = [mpf(10) ** 6, mpf(10) ** 9, mpf(10) ** 12]
stepped = [run(middle ** 2 * own, (middle ** 2 + s * s) * own) for s in steps]
estimated = mix(branches, stepped)
weights = normed([b[3] for b in branches])
estimated["move_ratio"] = float(sqrt(sum(w * q * q for w, q in zip(weights, ratios))))
estimated["intervals"] = [interval(j, branches, stepped, mpf(estimated["value_dec"][j])) for j in range(N)]
deviations = [0.05, 0.08, 0.02, 0.06]
given = mix([run(matrix([[mpf(d) ** 2 if i == j else mpf(0) for j in range(N)] for i, d in enumerate(deviations)]))])
print(json.dumps({
    "source": "nodes and formula of prior_chain.py",
    "licence": "none needed",
    "verification": "mpmath, 50 digits, covariance form (prior_chain.py)",
    "iterations": iterations,
    "sigma": float(sqrt(variance)),
    "degrees_of_freedom": freedom,
    "move_std_error": deviations,
    "estimated": estimated,
    "given": given,
}, indent=1))
