"""Tests with a Gaussian process whether the residual contains a discrepancy in addition to noise.

The discrepancy of Kennedy and O'Hagan (2001) is a smooth function of the conditions that is added
to the model.
"""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.studies.benchmark.peers.textbook import Fit, Float, Problem, Whole, problem

try:
    from sklearn.exceptions import ConvergenceWarning
    from sklearn.gaussian_process import GaussianProcessRegressor
    from sklearn.gaussian_process.kernels import RBF, ConstantKernel, WhiteKernel
except ImportError as error:
    raise ValueError(
        "the subject gaussian_process needs scikit-learn: pip install 'arctrue[studies]'"
    ) from error

BLOCKS_A_RUN = 48
CYCLES_TOGETHER = 2


def gaussian_process(folder: Path) -> dict[str, Any]:
    """Answer ``unknown`` if a smooth function has a lower BIC than white noise, else ``adequate``.

    This rival names no effects. The computing time grows with the cube of the number of rows;
    therefore each run is averaged in 48 stretches, and the reference over two cycles.
    """
    fit = Fit(problem(folder))
    left = fit.left()
    channels = (
        _capture(fit.given, left[fit.part(0)]),
        _reference(fit.given, left[fit.part(1)]),
    )
    # The verdict is ``unknown`` if the residual of one channel is not noise; an effect need not
    # appear in both channels.
    sees = any(_beats_noise(*channel) for channel in channels if channel[1].size > 4)
    verdict = "unknown" if sees else "adequate"
    return {"verdict": verdict, "named": None, "class": [], "further": []}


def _capture(given: Problem, left: Float) -> tuple[Float, Float]:
    """Average the rows in each of 48 stretches per run; return conditions ``(n, c)`` and residual
    ``(n,)``."""
    if not left.size:
        return np.zeros((0, 4)), left
    order = np.zeros(left.size, dtype=np.int64)
    for place, number in enumerate(given.runs):
        inside = np.flatnonzero(given.run == number)
        stretch = np.arange(inside.size) * BLOCKS_A_RUN // inside.size
        order[inside] = place * BLOCKS_A_RUN + stretch
    conditions = [np.cos(given.theta), np.sin(given.theta), given.time_s, given.speed]
    if given.warmth_k.size:
        conditions.append(given.warmth_k)
    return _means(order, conditions, left)


def _reference(given: Problem, left: Float) -> tuple[Float, Float]:
    """Average the readings of each station and direction of approach over neighbouring cycles."""
    if not left.size:
        return np.zeros((0, 4)), left
    station = np.unique(np.round(np.degrees(given.target), 6), return_inverse=True)[1]
    side = station * 2 + (given.direction > 0)
    # The k-th visit to a station from one side counts as cycle k.
    order = np.argsort(side, kind="stable")
    begins = np.flatnonzero(np.diff(side[order], prepend=-1))
    visit = np.empty(side.size, dtype=np.int64)
    visit[order] = np.arange(side.size) - np.repeat(begins, np.diff(begins, append=side.size))
    together = side * (side.size + 1) + visit // CYCLES_TOGETHER
    conditions = [np.cos(given.target), np.sin(given.target), given.reference_s, given.direction]
    return _means(together, conditions, left)


def _means(group: Whole, conditions: list[Float], left: Float) -> tuple[Float, Float]:
    _, place, number = np.unique(group, return_inverse=True, return_counts=True)
    columns = [np.bincount(place, column) / number for column in (*conditions, left)]
    return np.stack(columns[:-1], axis=1), columns[-1]


def _beats_noise(conditions: Float, values: Float) -> bool:
    spread = conditions.std(axis=0)
    inputs = (conditions / np.where(spread > 0, spread, 1.0))[:, spread > 0]
    outputs = values / max(float(values.std()), 1e-12)
    lengths = np.ones(inputs.shape[1])
    smooth = ConstantKernel(0.5) * RBF(lengths, (0.05, 1e3)) + WhiteKernel(0.5)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", ConvergenceWarning)
        found = GaussianProcessRegressor(smooth, random_state=0).fit(inputs, outputs)
    gain = float(found.log_marginal_likelihood_value_) - _white_log_likelihood(outputs)
    # The process has one parameter for white noise, one amplitude, and one length for each
    # condition.
    return gain > 0.5 * (1 + lengths.size) * float(np.log(values.size))


def _white_log_likelihood(values: Float) -> float:
    """Return the log likelihood of white noise with the most likely variance."""
    variance = float(np.mean(values**2))
    return -0.5 * values.size * (float(np.log(2 * np.pi * variance)) + 1.0)
