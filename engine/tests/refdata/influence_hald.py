"""Influence of the nodes of Hald's cement data: statsmodels' OLSInfluence, with weights its WLS.

Run in this folder (statsmodels 0.15, numpy 2.4): python influence_hald.py > influence_hald.json
R 4.2 (lm, hatvalues, rstandard, rstudent, cooks.distance, dffits) gives the same to 1e-10.
"""
import json

import numpy as np
import statsmodels.api as sm
from statsmodels.stats.outliers_influence import OLSInfluence

data = json.load(open("ridge_hald.json"))["data"]
y = np.array(data["y"])
x = np.column_stack([np.ones(len(y))] + [data[f"x{j}"] for j in range(1, 5)])
weight = 0.5 + (np.arange(len(y)) % 4)


def figures(w):
    # rows and heights times √w: what a weight is to every figure but the residuals' unit
    root = np.sqrt(w)
    found = OLSInfluence(sm.OLS(y * root, x * root[:, None]).fit())
    return {
        "leverage": found.hat_matrix_diag.tolist(),
        "internally_studentized": found.resid_studentized_internal.tolist(),
        "externally_studentized": found.resid_studentized_external.tolist(),
        "cooks_distance": found.cooks_distance[0].tolist(),
        "dffits": found.dffits[0].tolist(),
        "press_residual": (found.resid_press / root).tolist(),
        "press": float(np.sum(found.resid_press**2)),
    }


print(json.dumps({
    "name": "influence_hald",
    "source": "influence_hald.py (statsmodels OLSInfluence) on the data of ridge_hald.json",
    "weight": weight.tolist(),
    "plain": figures(np.ones(len(y))),
    "weighted": figures(weight),
}, indent=1))
