"""Tests that noise scales of runs that a missing effect caused become 1 with the effect in the
model."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.noise.estimate import ChannelRows, estimated_law
from arctrue.workbench.noise.fit import FIRST_ROUNDS, NEXT_ROUNDS
from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.likelihood import FixedTerms
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.noise.spectrum_fit import WhiteBounds

ROWS = 360
STEPS_S = (1.0 / 30.0, 1.0 / 15.0, 1.0 / 21.0)
"""Intervals in seconds between rows at three speeds over the same stations; each speed has its own
spectrum."""
TRUE = Spectrum(2.6, np.array([0.4]), np.array([2.3]))
SCALES = np.array([1.3, 1.5, 0.5])
"""Noise scales of the runs if the model of a reference at these speeds lacks a delay of 280″ per
rad/s.

The test divides the true spectra by the squares of these scales, so that spectra and scales
together give each run its true variance.
"""
TOLERANCE = 0.02
"""Relative tolerance of a variance: a quarter of √(2/360), the uncertainty of a variance from 360
rows."""
NO_FIXED_TERMS = FixedTerms(np.zeros((0, 0)), np.zeros(0))
BOUNDS = WhiteBounds(1e-12)


def _rows(seed: int) -> ChannelRows:
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(3), ROWS)
    clock = np.concatenate(
        [900.0 * number + np.arange(ROWS) * step for number, step in enumerate(STEPS_S)]
    )
    starts = np.arange(3) * ROWS
    noise = RowNoise(clock, starts, (TRUE,) * 3, np.ones(run.size))
    angle = np.tile(np.arange(ROWS) * 2.0 * np.pi / ROWS, 3)
    return ChannelRows(
        "reference", clock, run, angle, noise.draw(random), np.ones(run.size),
        np.zeros((run.size, 0)), False,
    )  # fmt: skip


@pytest.mark.parametrize("seed", range(6))
def test_the_search_begins_at_the_scatter_that_the_runs_have(seed: int) -> None:
    """If the search starts at the noise of the model without the effect, it needs only a few steps
    and ends at the same noise as a search with many steps from its usual start.

    If the search took the spectra without the scales, it would begin at 0.4 to 4 times the
    variance. It would end with a tenth too much variance in slow parts, which absorb the offsets
    between the runs; a delay would then gain less than a line of low frequency.
    """
    rows = _rows(seed)
    alone, _ = estimated_law(rows, NO_FIXED_TERMS, BOUNDS, None, FIRST_ROUNDS)
    np.testing.assert_array_equal(alone.run_scale, 1.0)
    spectra = tuple(
        Spectrum(item.white / scale**2, item.constants, item.variances / scale**2)
        for item, scale in zip(alone.spectra, SCALES, strict=True)
    )
    before = NoiseLaw(spectra, alone.runs, SCALES)
    found, _ = estimated_law(rows, NO_FIXED_TERMS, BOUNDS, before, NEXT_ROUNDS)
    np.testing.assert_array_equal(found.run_scale, 1.0)
    for now, expected in zip(found.spectra, alone.spectra, strict=True):
        assert now.variance == pytest.approx(expected.variance, rel=TOLERANCE)
