"""Computes the calibration error that chance gives to a perfect calibration."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from arctrue.studies.benchmark.intervals import (
    CONFIDENCE,
    RESAMPLES,
    expected_calibration_error,
    reliability,
)


def perfect_calibration(probability: Sequence[float]) -> tuple[float, float]:
    """Return the mean calibration error of a perfect calibration with these stated values, and the
    value that 5 % of such samples exceed.

    Each answer is drawn as right with its stated probability. A bootstrap interval of the error
    does not show whether the calibration is perfect: the error is a mean of absolute values, so
    that chance makes it larger, and in each resample once more.
    """
    stated = np.asarray(probability, dtype=float)
    random = np.random.default_rng(0)
    drawn = [
        expected_calibration_error(
            reliability(stated, (random.random(stated.size) < stated).astype(float))
        )
        for _ in range(RESAMPLES)
    ]
    return float(np.mean(drawn)), float(np.quantile(drawn, CONFIDENCE))
