"""Tests which samples of three or four heads are single wrong rows in the residual of a model.

The residuals are readings of a disc with a scratch, or readings of which one is wrong; no code of
the effects computes them.
"""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.wrong_rows import without_wrong_rows
from tests.workbench.heads.four_heads import NOISE_ARCSEC, PLACES_DEG, FourHeads

SAMPLES_A_TURN = 300
SIZE_ARCSEC = 20.0 * NOISE_ARCSEC
"""Size of the scratch and of the wrong readings, 14 standard deviations of a difference."""
SEED = 5


def _observations(heads: int, turns: int) -> Observations:
    table = FourHeads(
        places_deg=PLACES_DEG[:heads], turns=float(turns), samples=SAMPLES_A_TURN * turns
    )
    return observations_of(table.measured(7))


def _residual(observations: Observations, readings_arcsec: np.ndarray) -> np.ndarray:
    """Return the residual of each row from the errors of the readings, shape (heads, samples): the
    contrast dₖ is √(2(k − 1)/k) times the reading of head k minus the mean of the heads before."""
    rows = observations.capture
    assert rows is not None
    assert rows.channel is not None
    noise = np.random.default_rng(SEED).normal(0.0, NOISE_ARCSEC, readings_arcsec.shape)
    readings = readings_arcsec + noise
    left = np.empty(rows.run.size)
    for channel in range(rows.channels):
        k = channel + 2
        mean = readings[: k - 1].mean(axis=0)
        left[rows.channel == channel] = np.sqrt(2.0 * (k - 1) / k) * (readings[k - 1] - mean)
    return left


def _angle_rad(observations: Observations) -> np.ndarray:
    rows = observations.capture
    assert rows is not None
    assert rows.channel is not None
    return rows.angle_rad[rows.channel == 0]


@pytest.mark.parametrize("heads", [3, 4])
@pytest.mark.parametrize("turns", [1, 3])
def test_a_scratch_of_the_disc_is_kept(heads: int, turns: int) -> None:
    """A scratch is no wrong row: every head reads it in two samples of every turn, each head at its
    own angle of the table."""
    observations = _observations(heads, turns)
    width = 2.0 * 2.0 * np.pi / SAMPLES_A_TURN
    seen = [
        np.mod(_angle_rad(observations) + np.radians(place) - 1.0, 2.0 * np.pi) < width
        for place in PLACES_DEG[:heads]
    ]
    assert all(1 <= np.count_nonzero(each) / (4 * turns) <= 3 for each in seen)
    left = _residual(observations, SIZE_ARCSEC * np.array(seen, dtype=np.float64))
    assert without_wrong_rows(observations, left) is None


@pytest.mark.parametrize(
    ("heads", "head"), [(3, 1), (3, 2), (3, 3), (4, 1), (4, 2), (4, 3), (4, 4)]
)
@pytest.mark.parametrize("turns", [1, 3, 6])
def test_one_wrong_reading_of_any_head_is_found(heads: int, head: int, turns: int) -> None:
    """A reading that is wrong in one turn is found, whichever head reads it; the sample is left out
    with all heads and listed once, with the distance of the difference from its neighbours."""
    observations = _observations(heads, turns)
    rows = observations.capture
    assert rows is not None
    sample = SAMPLES_A_TURN * turns + 100
    wrong = np.zeros((heads, rows.run.size // (heads - 1)))
    wrong[head - 1, sample] = SIZE_ARCSEC
    found = without_wrong_rows(observations, _residual(observations, wrong))
    assert found is not None
    # The header is line 1 of the file.
    assert [item.row for item in found.masked] == [sample + 2]
    # A difference has the noise of two heads; five of its standard deviations.
    assert abs(abs(found.masked[0].away_arcsec or 0.0) - SIZE_ARCSEC) < 5.0 * NOISE_ARCSEC * 1.5
    assert found.capture is not None
    assert found.capture.run.size == rows.run.size - (heads - 1)
    assert found.capture_sample is not None
    assert sample not in found.capture_sample
