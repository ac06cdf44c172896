#!/usr/bin/env python3
"""How often intervals, bands and decisions hold, asked over HTTP: tables of docs/explanation/intervals.md and docs/explanation/prior.md.

Nodes are drawn about a truth that is known, sent to a server, and what it answers is held against the truth. Nothing
of the engine is used, so this is a proof from outside of what the tables made by its examples say.

Subjects: `bands` (with a true norm limit, the truth along the worst determined direction too), `slopes`, `told` (a
prior that is true), `iterations` (a prior of a job's iterations: coefficients, further measurements, the band over all
nodes), `pitches` (decisions where pitches lie at their limits).

Usage: coverage.py SUBJECT [--draws 400] [--url http://127.0.0.1:8080] [--seed 2026]
A server that needs no key; `iterations` makes jobs in its store.
"""

import argparse
import http.client
import json
import urllib.parse

import numpy as np


class Server:
    """One connection that is kept."""

    def __init__(self, url):
        self.connection = http.client.HTTPConnection(urllib.parse.urlsplit(url).netloc, timeout=120)

    def post(self, path, body):
        self.connection.request("POST", path, json.dumps(body), {"content-type": "application/json"})
        answer = self.connection.getresponse()
        text = answer.read()
        if answer.status not in (200, 201):
            raise SystemExit(f"{path}: {answer.status} {text[:600]!r}")
        return json.loads(text)

    def fit(self, x, y, **spec):
        """A linear model without regularisation unless `spec` says otherwise."""
        nodes = {"type": "matrix", "x": x.tolist(), "y": y.tolist()}
        return self.post("/v1/fits", {"nodes": nodes, "model": {"type": "linear"}, **spec})


def cubic(t):
    """Columns of Legendre's polynomials up to degree 3."""
    return np.column_stack([np.ones_like(t), t, 1.5 * t**2 - 0.5, 2.5 * t**3 - 1.5 * t])


def inside(ends, truth):
    ends = np.asarray(ends)
    return (ends[:, 0] <= truth) & (truth <= ends[:, 1])


def intervals(found):
    return [coefficient["interval"] for coefficient in found["coefficients"]]


def rows(places, *kinds):
    return {"at": {"x": places.tolist()}, "kinds": list(kinds)}


def bands(server, rng, draws):
    places = np.linspace(30, 40, 45)
    x = np.column_stack([places**power for power in range(4)])
    lengths = np.linalg.norm(x, axis=0)
    _, sizes, directions = np.linalg.svd(x / lengths, full_matrices=False)
    truths = {"the worst direction": directions[-1], "the best": directions[0], "all alike": directions.sum(0) / 2}
    at = x[::4]
    print("| truth along | noise | coefficients | worst | `confidence` | worst | `prediction` | `simultaneous` |")
    print("|---|---|---|---|---|---|---|---|")
    for name, direction in truths.items():
        truth = direction / lengths
        for noise in (0.1, 1, 10):
            sigma = noise * sizes[-1]
            own, each, further, whole = np.zeros(4), np.zeros(len(at)), 0.0, 0
            for _ in range(draws):
                asked = rows(at, "confidence", "prediction", "simultaneous")
                y = x @ truth + sigma * rng.standard_normal(45)
                found = server.fit(x, y, coefficient_norm_limit=1, predict=asked)
                told, heights = found["predictions"], at @ truth
                own += inside(intervals(found), truth)
                each += inside(told["confidence"], heights)
                again = heights + sigma * rng.standard_normal(len(at))
                further += inside(told["prediction"], again).mean()
                whole += inside(told["simultaneous"], heights).all()
            own, each = own / draws, each / draws
            print(
                f"| {name} | {noise} | {own.mean():.3f} | {own.min():.3f} | {each.mean():.3f} | {each.min():.3f} "
                f"| {further / draws:.3f} | {whole / draws:.3f} |",
                flush=True,
            )


def slopes(server, rng, draws):
    x, at = np.linspace(30, 34, 41), np.linspace(30, 34, 17)
    truth = np.polynomial.Polynomial([1, 0.5, -0.3, 0.05])
    held = np.zeros(17)
    for _ in range(draws):
        nodes = {"type": "curve", "x": x.tolist(), "y": (truth(x - 32) + 0.05 * rng.standard_normal(41)).tolist()}
        predict = {"at": {"x": at.tolist()}, "slopes": True}
        model = {"type": "polynomial", "degree": 3}
        found = server.post("/v1/fits", {"nodes": nodes, "model": model, "predict": predict})
        held += inside(found["predictions"]["slope_u"]["confidence"], truth.deriv()(at - 32))
    print(f"slopes of a cubic at 17 places: {held.mean() / draws:.3f} on average, {held.min() / draws:.3f} at worst")


def told(server, rng, draws):
    print("| nodes | spread in standard errors | coefficients, mean | worst | `prediction` |\n|---|---|---|---|---|")
    for count in (6, 10, 45):
        x = cubic(np.linspace(-1, 1, count))
        errors = np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
        for spread in (0.3, 1, 3):
            held, further = np.zeros(4), 0
            for _ in range(draws):
                truth, at = spread * errors * rng.standard_normal(4), cubic(rng.uniform(-1, 1, 3))
                prior = {"mean": [0, 0, 0, 0], "std_error": (spread * errors).tolist()}
                y = x @ truth + rng.standard_normal(count)
                found = server.fit(x, y, prior=prior, predict=rows(at, "prediction"))
                held += inside(intervals(found), truth)
                further += np.sum(inside(found["predictions"]["prediction"], at @ truth + rng.standard_normal(3)))
            share = held / draws
            cells = [share.mean(), share.min(), further / 3 / draws]
            print(f"| {count} | {spread} | {' | '.join(f'{cell:.3f}' for cell in cells)} |", flush=True)


def iterations(server, rng, draws):
    x = cubic(np.linspace(-1, 1, 20))
    errors = np.sqrt(np.diag(np.linalg.inv(x.T @ x)))
    one = np.array([0, 0, 1, 0])
    moves = {
        "stand still": lambda last: np.zeros(4),
        "all move by 1 σ": lambda last: rng.standard_normal(4),
        "one steps by 3 σ": lambda last: 3 * one * last,
        "all step by 2 σ": lambda last: 2 * np.ones(4) * last,
    }
    print("| six iterations | coefficients, mean | worst | `prediction` | `simultaneous` | let go |")
    print("|---|---|---|---|---|---|")
    for name, move in moves.items():
        held, further, whole, dropped = np.zeros(4), 0.0, 0, 0
        for _ in range(draws):
            path = f"/v1/jobs/{server.post('/v1/jobs', {'name': 'coverage'})['id']}/iterations"
            truth = 3 * rng.standard_normal(4)
            for number in range(6):
                truth = truth + (errors * move(number == 5) if number else 0)
                nodes = {"type": "matrix", "x": x.tolist(), "y": (x @ truth + rng.standard_normal(20)).tolist()}
                body = {"nodes": nodes, "model": {"type": "linear"}, "regularization": {"type": "none"}}
                if number == 5:
                    body["prior"] = {"iterations": "previous"}
                    body["predict"] = rows(x, "prediction", "simultaneous")
                found = server.post(path, body)
            found = found["fits"][0]["result"]
            told = found["predictions"]
            held += inside(intervals(found), truth)
            further += inside(told["prediction"], x @ truth + rng.standard_normal(20)).mean()
            whole += inside(told["simultaneous"], x @ truth).all()
            dropped += found["prior"].get("conflict", {}).get("dropped", False)
        share = held / draws
        print(
            f"| {name} | {share.mean():.3f} | {share.min():.3f} | {further / draws:.3f} | {whole / draws:.3f} "
            f"| {dropped / draws:.3f} |",
            flush=True,
        )


def pitches(server, rng, draws):
    print("| pitches of 50 at the limit | `conforms` | `does_not_conform` |\n|---|---|---|")
    gear = {"teeth": 50, "normal_module_mm": 2, "face_width_mm": 20}
    for count in (1, 5, 20):
        made = {"conforms": 0, "does_not_conform": 0, "undecidable": 0}
        # the last pitch closes the circle, far from the limit above
        truth = np.where(np.arange(50) < count, 6.0, 0.0) - 6.0 * count * (np.arange(50) == 49)
        for _ in range(draws):
            body = {
                "gear": gear,
                "left": {"single_pitch_um": (truth + rng.standard_normal(50)).tolist()},
                "pitch_limits": {"single_pitch_um": [-1000, 6]},
                "standard_uncertainty_um": {"single_pitch": 1},
            }
            made[server.post("/v1/gears/pitch", body)["left"]["single_pitch_conformity"]["verdict"]] += 1
        print(f"| {count} | {made['conforms'] / draws:.3f} | {made['does_not_conform'] / draws:.3f} |", flush=True)


SUBJECTS = {one.__name__: one for one in (bands, slopes, told, iterations, pitches)}


def main():
    parser = argparse.ArgumentParser(description="How often intervals, bands and decisions hold, asked over HTTP.")
    parser.add_argument("subject", choices=SUBJECTS)
    parser.add_argument("--draws", type=int, default=400)
    parser.add_argument("--url", default="http://127.0.0.1:8080")
    parser.add_argument("--seed", type=int, default=2026)
    asked = parser.parse_args()
    SUBJECTS[asked.subject](Server(asked.url), np.random.default_rng(asked.seed), asked.draws)


if __name__ == "__main__":
    main()
