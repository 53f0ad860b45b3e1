"""Tests how many independent frequencies the search for a vibration counts, against the largest
value of periodograms of white noise that numpy draws."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import chi2

from arctrue.measurement import Capture, MeasurementSet, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

ROWS, STEP_S = 128, 0.002
COUNTS, NOISE_ARCSEC = 1 << 26, 0.1
FINER = 8
"""Points of a periodogram per 1/T: the largest point is then 0.5 % below the maximum on average."""


def _trials(runs: int) -> float:
    """Return the number of trials of the search in ``runs`` runs of white noise, a turn each."""
    random = np.random.default_rng([21, runs])
    angle = np.tile(np.arange(ROWS) * (2.0 * np.pi / ROWS), runs)
    noise = np.radians(NOISE_ARCSEC / 3600.0) * random.normal(size=(2, angle.size))
    counts = np.round((np.stack([angle, angle + np.radians(33.0)]) + noise) * COUNTS / (2 * np.pi))
    run = np.repeat(np.arange(runs), ROWS)
    capture = Capture(
        run=run,
        time_s=np.tile(np.arange(ROWS) * STEP_S, runs) + 100.0 * run,
        head1_counts=counts[0].astype(np.int64),
        head2_counts=counts[1].astype(np.int64),
    )
    observations = observations_of(
        MeasurementSet(Table(counts_per_rev=COUNTS, head_separation_deg=33.0), capture)
    )
    effects = built_in()
    base = [Term(effects["graduation_harmonics"](orders=[1, 2]), {})]
    known = white_noise(observations, (NOISE_ARCSEC * np.sqrt(2.0), None))
    return places_of(effects["vibration"](), Residuals(fit(base, observations, noise=known)))[
        0
    ].trials


@pytest.mark.parametrize(("runs", "draws"), [(1, 20_000), (3, 10_000)])
def test_a_vibration_counts_as_many_frequencies_as_white_noise_tries(runs: int, draws: int) -> None:
    """With the number of trials that the search counts, corrected p < 0.01 occurs in 1 % of sets.

    The gain of a line in white noise is χ² with two degrees of freedom for each run. The largest
    gain of 1 % of the draws gives the true number of trials, with a standard uncertainty of 1/√200
    = 7 % (20,000 draws) or 10 % (10,000 draws); the bound is three times 10 %.
    """
    random = np.random.default_rng(22)
    largest = []
    for _ in range(draws // 500):
        waves = np.fft.rfft(random.normal(size=(500, runs, ROWS)), FINER * ROWS, axis=2)
        # The search starts at two periods in the run and ends at half the sample rate.
        power = np.sum(np.abs(waves[:, :, 2 * FINER :]) ** 2, axis=1) * (2.0 / ROWS)
        largest.append(power.max(axis=1))
    limit = float(np.quantile(np.concatenate(largest), 0.99))
    assert _trials(runs) == pytest.approx(0.01 / float(chi2.sf(limit, 2 * runs)), rel=0.3)
