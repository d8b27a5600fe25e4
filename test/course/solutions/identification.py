"""A right solution."""

import numpy as np


def estimate(Y, tau):
    return np.linalg.lstsq(Y, tau, rcond=None)[0]


def standard_errors(Y, tau):
    left = tau - Y @ estimate(Y, tau)
    noise = left @ left / (len(tau) - Y.shape[1])
    return np.sqrt(noise * np.diag(np.linalg.inv(Y.T @ Y)))
