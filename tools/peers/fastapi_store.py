"""What a user would write instead: FastAPI, numpy and sqlite3, for `tools/compare_fastapi.py`.

A polynomial of degree (3, 3) is fitted with a fixed share of the greatest eigenvalue as λ. One row is stored with nodes and result, by a
commit of its own that is synced: no spectrum of errors, no numbers within a job, no audit, no idempotency.
"""

import json
import os
import sqlite3
import threading
import uuid

import numpy as np
from fastapi import FastAPI
from pydantic import BaseModel

DATABASE = os.environ["STORE"]
DEGREE = 3
SHARE = 1e-6

app = FastAPI()
mine = threading.local()


class Measurement(BaseModel):
    nodes: dict
    model: dict


def database():
    if not hasattr(mine, "connection"):
        mine.connection = sqlite3.connect(DATABASE, timeout=60, isolation_level=None)
        mine.connection.execute("PRAGMA journal_mode = WAL")
        mine.connection.execute("PRAGMA synchronous = FULL")
    return mine.connection


database().execute("CREATE TABLE IF NOT EXISTS iterations (id TEXT PRIMARY KEY, job TEXT, nodes TEXT, result TEXT)")


def scaled(values):
    values = np.asarray(values)
    return 2 * (values - values.min()) / (values.max() - values.min()) - 1


@app.get("/ready")
def ready():
    return {}


@app.post("/v1/jobs/{job}/iterations", status_code=201)
def create_iteration(job: str, measured: Measurement):
    nodes = measured.nodes
    z = np.asarray(nodes["z"], float).ravel()
    columns = [np.vander(scaled(nodes[axis]), DEGREE + 1, increasing=True) for axis in ("u", "v")]
    design = np.kron(*columns)
    eigenvalues, directions = np.linalg.eigh(design.T @ design)
    ridge = SHARE * eigenvalues[-1]
    coefficients = directions @ ((directions.T @ (design.T @ z)) / (eigenvalues + ridge))
    residuals = z - design @ coefficients
    result = {
        "id": str(uuid.uuid4()),
        "coefficients": coefficients.tolist(),
        "eigenvalues": eigenvalues.tolist(),
        "residuals": residuals.tolist(),
        "sigma": float(np.sqrt(residuals @ residuals / (len(z) - len(coefficients)))),
        "lambda": float(ridge),
    }
    row = (result["id"], job, json.dumps(nodes), json.dumps(result))
    database().execute("INSERT INTO iterations VALUES (?, ?, ?, ?)", row)
    return result
