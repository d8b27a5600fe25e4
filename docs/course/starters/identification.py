"""Identification: fill in the functions; tau = Y pi + noise."""

import numpy as np


def estimate(Y, tau):
    """Return the parameters of least squares, one for each column of Y."""
    return np.zeros(Y.shape[1])


def standard_errors(Y, tau):
    """Return their standard errors, with the noise taken from what is left over."""
    return np.ones(Y.shape[1])
