"""Tests that a spectrum fitted to noise agrees with the known spectrum of this noise, with and
without a fitted model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.workbench.noise.likelihood import FixedTerms, RestrictedLikelihood, Stretch
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum, time_constants
from arctrue.workbench.noise.spectrum_fit import SpectrumFit, WhiteBounds, fit_spectrum

STEP = 0.01
ROWS = 6000
TRUE = Spectrum(0.01, np.array([2.0]), np.array([0.01]))


def _stretches(columns: int, seed: int = 1) -> tuple[list[Stretch], FixedTerms]:
    """Return three runs of noise, minus a fit of ``columns`` waves. The noise is Ornstein–Uhlenbeck
    noise of 0.1″ with a time constant of 2 s, plus 0.1″ of white noise."""
    random = np.random.default_rng(seed)
    clock = np.arange(ROWS) * STEP
    noise = RowNoise(clock, np.array([0]), (TRUE,), np.ones(ROWS))
    waves = [
        wave(2.0 * np.pi * order * clock / 20.0)
        for order in range(1, columns // 2 + 1)
        for wave in (np.cos, np.sin)
    ]
    design = np.stack(waves, axis=1) if waves else np.zeros((ROWS, 0))
    values = np.concatenate([noise.draw(random) for _ in range(3)])
    full = np.column_stack([np.tile(design, (3, 1)), np.repeat(np.eye(3), ROWS, axis=0)])
    left = values - full @ np.linalg.lstsq(full, values, rcond=None)[0]
    found = [
        Stretch(clock, part, design, run, np.ones(ROWS))
        for run, part in enumerate(np.split(left, 3))
    ]
    return found, FixedTerms(np.zeros((columns, columns)), np.zeros(columns))


@pytest.mark.parametrize("columns", [0, 40])
def test_density_is_found_from_the_slowest_to_the_fastest(columns: int) -> None:
    """The fitted spectrum contains all of the slow noise, although the model of 40 columns absorbs
    a third of it."""
    stretches, fixed_terms = _stretches(columns)
    found = fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6)).spectrum
    frequency = np.array([0.08, 0.3, 1.0, 10.0, 40.0])
    ratio = found.density(frequency, STEP) / TRUE.density(frequency, STEP)
    # At the slow end, some tens of independent values determine a level to 20 %; at the fast end,
    # thousands determine it to 3 %.
    assert np.all(np.abs(np.log(ratio[:2])) < 0.5)
    np.testing.assert_allclose(ratio[2:], 1.0, atol=0.15)


@pytest.mark.large
def test_a_kept_fit_serves_the_same_numbers_only() -> None:
    stretches, fixed_terms = _stretches(4)
    kept: dict[bytes, SpectrumFit] = {}
    alone = fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6))
    first = fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6), kept=kept)
    assert first.spectrum.equals(alone.spectrum)
    assert fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6), kept=kept) is first
    # One changed number of one row, of the bounds or of the start makes another fit.
    residual = stretches[0].residual.copy()
    residual[7] += 1e-9
    moved = [replace(stretches[0], residual=residual), *stretches[1:]]
    others = [
        fit_spectrum(moved, fixed_terms, WhiteBounds(1e-6), kept=kept),
        fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6, 0.02), kept=kept),
        fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6), start=alone.spectrum, kept=kept),
    ]
    assert all(item is not first for item in others)


def test_likelihood_of_rows_as_they_are_is_the_written_out_one() -> None:
    random = np.random.default_rng(4)
    clock = np.arange(80) * STEP
    constants = np.array([0.05, 0.4])
    columns = random.normal(size=(80, 3))
    residual = random.normal(size=80)
    stretch = Stretch(clock, residual, columns, 0, np.ones(80))
    likelihood = RestrictedLikelihood(
        [stretch], STEP, constants, FixedTerms(np.eye(3), np.zeros(3))
    )

    def written_out(spectrum: Spectrum) -> float:
        covariance = spectrum.white * np.eye(80)
        for constant, variance in zip(constants, spectrum.variances, strict=True):
            covariance += variance * np.exp(-np.abs(clock[:, None] - clock) / constant)
        full = np.column_stack([columns, np.ones(80)])
        normal = full.T @ np.linalg.solve(covariance, full)
        normal[:3, :3] += np.eye(3)
        moment = full.T @ np.linalg.solve(covariance, residual)
        square = residual @ np.linalg.solve(covariance, residual)
        square -= moment @ np.linalg.solve(normal, moment)
        return -0.5 * (square + np.linalg.slogdet(covariance)[1] + np.linalg.slogdet(normal)[1])

    first, second = (
        Spectrum(white, constants, np.array([slow, slow])) for white, slow in ((1.0, 0.1), (0.5, 2))
    )
    expected = written_out(first) - written_out(second)
    assert likelihood(first) - likelihood(second) == pytest.approx(expected, abs=1e-4)


def test_time_constants_of_the_fit_are_those_of_the_rows() -> None:
    stretches, fixed_terms = _stretches(0)
    found = fit_spectrum(stretches, fixed_terms, WhiteBounds(1e-6), rounds=1).spectrum
    np.testing.assert_allclose(found.constants, time_constants(STEP, (ROWS - 1) * STEP))


def test_direction_that_no_row_shows_only_adds_a_constant() -> None:
    """A column of zeros only adds a constant to the likelihood, although rounding makes its
    information slightly negative."""
    random = np.random.default_rng(5)
    clock = np.arange(80) * STEP
    constants = np.array([0.05, 0.4])
    columns, residual = random.normal(size=(80, 2)), random.normal(size=80)
    ones = np.ones(80)
    padded = np.column_stack([columns, np.zeros(80)])
    information = np.diag([1.0, 1.0, -1e-11])
    with_it = RestrictedLikelihood(
        [Stretch(clock, residual, padded, 0, ones)],
        STEP,
        constants,
        FixedTerms(information, np.zeros(3)),
    )
    without = RestrictedLikelihood(
        [Stretch(clock, residual, columns, 0, ones)],
        STEP,
        constants,
        FixedTerms(information[:2, :2], np.zeros(2)),
    )
    spectra = [Spectrum(w, constants, np.array([a, 0.3])) for w, a in ((0.5, 0.1), (0.9, 0.6))]
    rise = [likelihood(spectra[1]) - likelihood(spectra[0]) for likelihood in (with_it, without)]
    assert np.isfinite(rise).all()
    assert rise[0] == pytest.approx(rise[1], abs=1e-6)


@pytest.mark.parametrize("constants", [np.array([0.05, 0.4]), np.geomspace(0.02, 20.0, 6)])
def test_gradient_is_that_of_the_likelihood(constants: np.ndarray) -> None:
    """The gradient equals central differences of the likelihood, for rows and for means over
    blocks.

    The second case has six exponentials, more than the library's own backward pass handles
    correctly.
    """
    stretches, _ = _stretches(6)
    fixed_terms = FixedTerms(30.0 * np.eye(6), np.arange(6.0))
    likelihood = RestrictedLikelihood(stretches, STEP, constants, fixed_terms)
    logs = np.log(np.concatenate([[0.01], 1e-3 * np.arange(1.0, 1.0 + constants.size)]))

    def at(place: np.ndarray) -> Spectrum:
        return Spectrum(float(np.exp(place[0])), constants, np.exp(place[1:]))

    value, slopes = likelihood.with_gradient(at(logs))
    assert value == likelihood(at(logs))
    for index in range(logs.size):
        move = np.zeros(logs.size)
        move[index] = 1e-4
        change = (likelihood(at(logs + move)) - likelihood(at(logs - move))) / 2e-4
        # The derivatives are up to some thousands; the rounding of the differences is about 1e-6 of
        # that.
        assert np.exp(logs[index]) * slopes[index] == pytest.approx(change, rel=1e-3, abs=0.02)
