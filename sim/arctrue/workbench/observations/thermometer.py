"""Removes the noise of a thermometer from the temperature of the rows of a capture.

The column of a temperature effect is the recorded temperature. White noise of the sensor in this
column contradicts the effect in every row, so that a fit to many rows prefers an effect of size 0
to the effect that the means of the runs show (Carroll, Ruppert, Stefanski and Crainiceanu,
Measurement Error in Nonlinear Models, chapter 4: regression calibration replaces the recorded value
by its expectation).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct

from arctrue.base.runs import run_spans

Float = NDArray[np.float64]

LEAST_ROWS = 64
"""Smallest number of rows of a run whose noise is removed. The share of the noise that remains,
1/rows with a constant temperature, is then below 2 %."""
LONGEST_STEP_S = 1.0
"""Longest time between two rows at which a change from row to row is noise of the sensor: parts of
a table need minutes to follow the temperature of the room."""
LARGEST_SHARE = 0.25
"""Largest number of waves of the temperature, as a share of the rows. If more are significant, the
changes are not white noise, and the column is kept as it is."""
FARTHEST = 6.0
"""Largest distance of a row from the smooth curve, in standard deviations; chance exceeds it once
in 5·10⁸ rows. A run with such a row is kept as it is, so that a spike is listed as a fault."""


def without_sensor_noise(temperature_c: Float, time_s: Float, run: NDArray[np.int64]) -> Float:
    """Return the temperature of each row without the white noise of the thermometer.

    A run's temperature is expanded in cosines over its rows. The slowest of them are kept, as many
    as Schwarz's criterion (BIC) of a smooth curve in white noise selects: one, the mean, if the
    temperature of the run is constant.

    Parameters
    ----------
    temperature_c, time_s : ndarray, shape (rows,)
        Recorded temperature, °C, and time of each row, seconds.
    run : ndarray, shape (rows,)
        Number of the run.

    Returns
    -------
    ndarray, shape (rows,)
        Temperature, °C; a run without white noise keeps its values.
    """
    found = temperature_c.astype(np.float64)
    for start, end in run_spans(run):
        shown = found[start:end]
        if end - start < LEAST_ROWS or not np.all(np.isfinite(shown)):
            continue
        if float(np.median(np.diff(time_s[start:end]))) <= LONGEST_STEP_S:
            found[start:end] = _smooth(shown)
    return found


def _smooth(shown_c: Float) -> Float:
    """Return the smooth part of one run's temperature, or the temperature itself if its changes are
    not white noise."""
    rows = shown_c.size
    mean = float(shown_c.mean())
    waves = dct(shown_c - mean, norm="ortho")
    square = waves**2
    most = int(LARGEST_SHARE * rows)
    # Sum of the squares that remain if the first 1, 2, … waves are kept.
    left = np.cumsum(square[::-1])[::-1][1 : most + 1]
    if left[-1] <= np.finfo(np.float64).eps * rows * max(mean**2, 1.0):
        return shown_c
    kept = np.arange(1, most + 1)
    best = int(np.argmin(rows * np.log(left) + kept * np.log(rows)))
    if best == most - 1:
        return shown_c
    waves[best + 1 :] = 0.0
    smooth = np.asarray(idct(waves, norm="ortho") + mean)
    away = np.abs(shown_c - smooth)
    return smooth if away.max() <= FARTHEST * np.sqrt(np.mean(away**2)) else shown_c
