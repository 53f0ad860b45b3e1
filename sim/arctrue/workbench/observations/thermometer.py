"""Removes the noise of a thermometer from the temperature of the rows of a capture.

The column of a temperature effect is the recorded temperature. With white noise of the sensor in
this column, the fit to many rows makes the effect too small, even if the means of the runs show it
clearly. The remedy is regression calibration, which replaces the recorded value by its expectation
(Carroll, Ruppert, Stefanski and Crainiceanu, Measurement Error in Nonlinear Models, chapter 4).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.fft import dct, idct

from arctrue.base.runs import run_spans

Float = NDArray[np.float64]

LEAST_ROWS = 64
"""Smallest number of rows of a run whose noise is removed. If the temperature is constant, 1/rows
of the noise variance remains, less than 2 %."""
LONGEST_STEP_S = 1.0
"""Longest median time between rows at which white changes from row to row count as noise of the
sensor: parts of a table need minutes to follow the temperature of the room."""
LARGEST_SHARE = 0.25
"""Largest number of kept cosines, as a share of the rows. If more are significant, the changes are
not white noise, and the run keeps its recorded values."""
FARTHEST = 6.0
"""Largest distance of a row from the smooth curve, in standard deviations; chance exceeds it once
in 5·10⁸ rows. A run with a larger distance keeps its recorded values, so that the report lists the
spike as a fault."""


def without_sensor_noise(temperature_c: Float, time_s: Float, run: NDArray[np.int64]) -> Float:
    """Return the temperature of each row without the white noise of the thermometer.

    The temperature of a run is expanded in cosines over its rows, and only the slowest cosines are
    kept. Schwarz's criterion (BIC) selects their number for a smooth curve in white noise. If the
    temperature is constant, only the mean is kept.

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
    # Sum of the squares that remain if the first 1, 2, … cosines are kept.
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
