"""k of ridge by restricted likelihood on Hald's cement data, columns of unit length, no constant.

y ~ N(0, s² (I + X Xᵀ/k)), s² and k at the maximum of the density, by scipy. With s = 2.5 given, k alone.
Run in this folder (scipy, numpy 2.4): python reml_hald.py > reml_hald.json
R 4.2, mgcv: gam(y ~ X - 1, paraPen = list(X = list(diag(4))), method = "REML")$sp is k to 5 digits.
"""
import json

import numpy as np
from scipy.optimize import minimize, minimize_scalar
from scipy.stats import multivariate_normal

data = json.load(open("ridge_hald.json"))["data"]
y = np.array(data["y"])
x = np.column_stack([data[f"x{j}"] for j in range(1, 5)])
x = x / np.linalg.norm(x, axis=0)
m = len(y)


def surprise(k, s):
    return -multivariate_normal(np.zeros(m), s**2 * (np.eye(m) + x @ x.T / k)).logpdf(y)


options = {"xatol": 1e-11, "fatol": 1e-13, "maxiter": 20000, "maxfev": 20000}
both = minimize(lambda p: surprise(np.exp(p[0]), np.exp(p[1])), [np.log(1e-3), 1.0], method="Nelder-Mead", options=options)
given = minimize_scalar(lambda x: surprise(np.exp(x), 2.5), bounds=[-20, 5], method="bounded", options={"xatol": 1e-10})
print(json.dumps({
    "name": "reml_hald",
    "source": "reml_hald.py (scipy's normal density) on the data of ridge_hald.json",
    "k": float(np.exp(both.x[0])),
    "sigma": 2.5,
    "k_with_sigma": float(np.exp(given.x)),
}, indent=1))
