"""Tests that the diagnosis describes noise with a resonance but gives it no name; the noise is
integrated from an equation of motion."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.inference.forward.oscillation import oscillation_of
from arctrue.workbench.inference.forward.prominence import density
from arctrue.workbench.inference.forward.record import record_of
from arctrue.workbench.inference.forward.search import search_lines
from arctrue.workbench.noise.kernel import Part
from tests.workbench.base_diagnosis import diagnosis_of
from tests.workbench.noisy_logs import (
    NULLS,
    clock,
    driven_oscillator,
    moving_mean,
    ornstein_uhlenbeck,
    walk,
)
from tests.workbench.small_sets import measurement_set

OF_A_FREQUENCY = 0.2
"""Relative tolerance of a frequency; a resonance of quality 8 has a relative width of 1/8 at half
power."""
OF_QUALITY_4 = 3.0 / 8.0
"""Half the width, in Hz, of a resonance of 3 Hz and quality 4."""


def _log(
    error_arcsec: np.ndarray, time_s: np.ndarray, run: np.ndarray | None = None
) -> MeasurementSet:
    reference = Reference(
        target_deg=time_s * 360.0 / 86_164.1,
        error_arcsec=error_arcsec,
        time_s=time_s,
        run=np.zeros(time_s.size, dtype=np.int64) if run is None else run,
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.parametrize("period_s", [9.0, pytest.param(40.0, marks=pytest.mark.large)])
def test_in_a_log(period_s: float) -> None:
    """The diagnosis describes an oscillation of 0.5″ RMS in 0.4″ of white noise; the log of an hour
    contains at least 90 periods."""
    random = np.random.default_rng(3)
    time_s = clock(random, 1500, 2.4, "even")
    shaken = driven_oscillator(random, time_s, period_s, 8.0)
    found = diagnosis_of(_log(0.5 * shaken + 0.4 * random.normal(size=time_s.size), time_s))
    assert found.verdict == "unknown"
    oscillation = found.detections.oscillation
    assert oscillation is not None
    assert oscillation.hz * period_s == pytest.approx(1.0, abs=OF_A_FREQUENCY)
    assert oscillation.rms_arcsec == pytest.approx(0.5, rel=0.3)
    assert "a damped oscillation near" in sentences(found)[0]
    assert "noise-driven" in sentences(found)[0]
    assert diagnosis_data(found, [])["findings"]["oscillation"]["channel"] == "reference"


@pytest.mark.large
def test_faster_than_the_averaged_rows() -> None:
    """An oscillation of 3 Hz and quality 4 in 9,000 rows of 0.05 s is found in single rows: the
    search for lines averages 6 rows, 0.3 s, in which it almost vanishes."""
    random = np.random.default_rng(11)
    time_s = 0.05 * np.arange(9000.0)
    shaken = driven_oscillator(random, time_s, 1.0 / 3.0, 4.0)
    found = diagnosis_of(_log(0.5 * shaken + 0.4 * random.normal(size=time_s.size), time_s))
    assert found.verdict == "unknown"
    oscillation = found.decision.oscillation
    assert oscillation is not None
    assert oscillation.hz == pytest.approx(3.0, abs=OF_QUALITY_4)
    assert oscillation.rms_arcsec == pytest.approx(0.5, rel=0.3)


@pytest.mark.parametrize(
    "seed",
    [21, pytest.param(22, marks=pytest.mark.large), pytest.param(23, marks=pytest.mark.large)],
)
def test_the_alias_of_a_faster_oscillation_is_none(seed: int) -> None:
    """The detections state an oscillation of 7 Hz and quality 60 at 7 Hz only, although averages of
    6 rows of 0.02 s contain its alias at 1/0.12 s − 7 Hz = 1.33 Hz, with sinc(7 Hz · 0.12 s) = 18 %
    of its size."""
    random = np.random.default_rng(seed)
    time_s = 0.02 * np.arange(9600.0)
    shaken = driven_oscillator(random, time_s, 1.0 / 7.0, 60.0)
    found = diagnosis_of(_log(0.5 * shaken + 0.1 * random.normal(size=time_s.size), time_s))
    assert found.verdict == "unknown"
    assert found.detections.oscillation is not None
    assert found.detections.oscillation.hz == pytest.approx(7.0, rel=1.0 / 120.0)
    said = [words for words in sentences(found) if "oscillation near" in words]
    assert len(said) == 1, said


@pytest.mark.parametrize("seed", [32, pytest.param(34, marks=pytest.mark.large)])
def test_a_narrow_peak_far_above_slow_noise_is_stated(seed: int) -> None:
    """An oscillation of 0.25″ in a random walk of 2″ RMS has a few percent of the mean square. At
    its frequency f of 0.04 Hz, however, its density 0.25²·Q/(πf) = 5 ″²/Hz is twenty times that of
    the walk: with steps s = 2″·√(6/3000) each 0.5 s, s²/0.5 s/(2πf)² = 0.25 ″²/Hz."""
    random = np.random.default_rng(seed)
    time_s = 0.5 * np.arange(3000.0)
    shaken = driven_oscillator(random, time_s, 25.0, 10.0)
    wandering = 2.0 * walk(random, time_s, 1e6) + 0.1 * random.normal(size=time_s.size)
    found = diagnosis_of(_log(0.25 * shaken + wandering, time_s))
    assert found.verdict == "unknown"
    oscillation = found.decision.oscillation
    assert oscillation is not None
    assert oscillation.hz * 25.0 == pytest.approx(1.0, abs=OF_A_FREQUENCY)
    assert oscillation.rms_arcsec == pytest.approx(0.25, rel=0.3)


@pytest.mark.large
@pytest.mark.parametrize("rows", [5, 12, 40])
@pytest.mark.parametrize("seed", [1, 2])
def test_the_side_lobes_of_a_moving_mean_are_no_oscillation(rows: int, seed: int) -> None:
    """White noise averaged over some rows has a density with zeros, which no kernel has, and humps
    between them."""
    random = np.random.default_rng((34, rows, seed))
    time_s = np.arange(1500.0)
    values = moving_mean(random, time_s, rows) + 0.05 * random.normal(size=time_s.size)
    none, one = np.zeros((time_s.size, 0)), np.zeros(time_s.size, dtype=np.int64)
    record = record_of(time_s, time_s, one, values, none, in_time=True)
    assert oscillation_of(search_lines(record), "reference") is None


@pytest.mark.parametrize(
    ("part", "covariance"),
    [
        (Part("exponential", 0.7, 3.0), lambda t: 0.7 * np.exp(-t / 3.0)),
        (Part("smooth", 0.7, 3.0), lambda t: 0.7 * (1.0 + t / 3.0) * np.exp(-t / 3.0)),
        (
            Part("oscillator", 0.7, 3.0, 0.4),
            lambda t: (
                0.7
                * np.exp(-t / 3.0)
                * (np.cos(0.8 * np.pi * t) + np.sin(0.8 * np.pi * t) / (0.8 * np.pi * 3.0))
            ),
        ),
    ],
)
def test_the_density_of_a_part_is_the_transform_of_its_covariance(
    part: Part, covariance: Callable[[np.ndarray], np.ndarray]
) -> None:
    """The densities at 0.1 Hz and 0.4 Hz agree with a trapezoidal sum, which over 90 s in steps of
    1 ms is exact to 10⁻⁵."""
    time_s = np.arange(0.0, 90.0, 1e-3)
    for hz in (0.1, 0.4):
        summed = 2.0 * np.trapezoid(covariance(time_s) * np.cos(2.0 * np.pi * hz * time_s), time_s)
        assert density(part, hz) == pytest.approx(summed, rel=1e-4)


def test_an_oscillation_is_stated_once() -> None:
    """Single rows and averages of two rows show the same oscillation of 0.3″ in slow noise of 0.5″,
    with slightly different values; the report states it once."""
    random = np.random.default_rng(25)
    time_s = 0.5 * np.arange(3000.0)
    shaken = driven_oscillator(random, time_s, 6.25, 10.0)
    slow = ornstein_uhlenbeck(random, time_s, 50.0)
    white = random.normal(size=time_s.size)
    found = diagnosis_of(_log(0.3 * shaken + 0.5 * slow + 0.1 * white, time_s))
    assert found.verdict == "unknown"
    said = [words for words in sentences(found) if "oscillation near" in words]
    assert len(said) == 1, said


@pytest.mark.large
def test_faster_than_the_averaged_rows_of_short_runs() -> None:
    """The oscillation of the test above is found too in four runs of 1,000 rows, of which the
    search for lines averages 3 rows."""
    random = np.random.default_rng(12)
    run = np.repeat(np.arange(4), 1000)
    time_s = 0.05 * np.arange(4000.0) + 60.0 * run
    shaken = driven_oscillator(random, time_s, 1.0 / 3.0, 4.0)
    found = diagnosis_of(_log(0.5 * shaken + 0.4 * random.normal(size=time_s.size), time_s, run))
    oscillation = found.decision.oscillation
    assert oscillation is not None
    assert oscillation.hz == pytest.approx(3.0, abs=OF_QUALITY_4)
    assert oscillation.rms_arcsec == pytest.approx(0.5, rel=0.3)


def test_at_stations_that_each_turn_repeats() -> None:
    """A product of parts must not describe an oscillation that noise drives: a table turns ten
    times past 120 angles, one each second, so that every turn meets the same angles."""
    random = np.random.default_rng(13)
    time_s = np.arange(1200.0)
    shaken = driven_oscillator(random, time_s, 23.0, 9.0)
    made = _log(1.5 * shaken + 0.5 * random.normal(size=time_s.size), time_s)
    assert made.reference is not None
    made.reference.target_deg[:] = 3.0 * time_s
    found = diagnosis_of(made)
    assert found.description is None
    oscillation = found.decision.oscillation
    assert oscillation is not None
    assert oscillation.hz * 23.0 == pytest.approx(1.0, abs=OF_A_FREQUENCY)
    assert oscillation.rms_arcsec == pytest.approx(1.5, rel=0.3)


def test_an_error_of_the_stations_is_no_oscillation() -> None:
    """An error of 1″ that ten turns repeat at each of 120 stations is no oscillation."""
    random = np.random.default_rng(14)
    time_s = np.arange(1200.0)
    of_places = np.tile(random.normal(size=120), 10)
    made = _log(of_places + 0.5 * random.normal(size=time_s.size), time_s)
    assert made.reference is not None
    made.reference.target_deg[:] = 3.0 * time_s
    found = diagnosis_of(made)
    assert found.detections.places is not None
    assert found.decision.oscillation is None


@pytest.mark.large
@pytest.mark.parametrize(
    ("hz", "quality", "turns"),
    [
        (6.0, 8.0, 3),
        (0.7, 6.0, 6),
        (3.0, 30.0, 3),
    ],
)
def test_in_a_capture(hz: float, quality: float, turns: int) -> None:
    """The diagnosis describes the oscillation of head 2's bracket in a run of 12 s a turn. The
    stated frequency is right within half the width at half power, hz/(2·quality), or a tenth of the
    frequency."""
    random = np.random.default_rng(4)

    def ringing(time_s: np.ndarray, speed_rad_s: float) -> np.ndarray:
        return 0.4 * driven_oscillator(random, time_s, 1.0 / hz, quality)

    measured = measurement_set(head2_only=ringing, seed=6, runs=1, reference=False, turns=turns)
    found = diagnosis_of(measured)
    assert found.verdict == "unknown"
    assert found.decision.seen is not None
    assert "a damped oscillation near" in found.decision.seen
    near = float(found.decision.seen.partition("near ")[2].partition(" Hz")[0])
    assert near == pytest.approx(hz, rel=min(0.5 / quality, 0.1))


@pytest.mark.large
def test_a_line_in_time_is_no_oscillation() -> None:
    """A steady sine of 6 Hz in noise without a resonance is no driven oscillation."""
    found = diagnosis_of(
        measurement_set(
            head2_only=lambda time_s, speed: 0.4 * np.sin(2.0 * np.pi * 6.0 * time_s),
            seed=7,
            runs=1,
            reference=False,
        )
    )
    assert found.decision.seen is None
    assert found.verdict != "adequate"


@pytest.mark.parametrize(
    "kind",
    [
        "white",
        pytest.param("OU 30 s", marks=pytest.mark.large),
        pytest.param("random walk", marks=pytest.mark.large),
        "flicker 1/f",
    ],
)
def test_noise_without_a_resonance_has_none(kind: str) -> None:
    """The diagnosis finds no resonance in noise that is white or wanders, in a log like those of
    the tests above."""
    random = np.random.default_rng((5, list(NULLS).index(kind)))
    time_s = clock(random, 1500, 2.4, "jitter")
    assert diagnosis_of(_log(NULLS[kind](random, time_s), time_s)).detections.oscillation is None


@pytest.mark.large
def test_the_frequency_is_known_within_its_uncertainty() -> None:
    """The stated uncertainty u of the frequency is right: the deviations of ten records, divided by
    u, are compared with χ², and u is compared with the theory.

    A record has 1,200 s with quality 8 at 0.1 Hz. Without white noise, maximum likelihood has u =
    √(γ/T)/(2π), γ = πf/Q (Gersch, IEEE Trans. Autom. Control 19 (1974) 558). White noise of half
    the size increases u, and the scatter of the estimated damping changes u by about 20 %.
    """
    hz, quality, time_s = 0.1, 8.0, np.arange(1200.0)
    none, one = np.zeros((time_s.size, 0)), np.zeros(time_s.size, dtype=np.int64)
    least = np.sqrt(np.pi * hz / quality / time_s.size) / (2.0 * np.pi)
    deviations, sigmas = [], []
    for seed in range(10):
        random = np.random.default_rng((9, seed))
        values = driven_oscillator(random, time_s, 1.0 / hz, quality)
        values = values + 0.5 * random.normal(size=time_s.size)
        record = record_of(time_s, time_s, one, values, none, in_time=True)
        found = oscillation_of(search_lines(record), "reference")
        assert found is not None
        deviations.append((found.hz - hz) / found.sigma_hz)
        sigmas.append(found.sigma_hz)
    # The bounds are the 0.1 and 99.9 % quantiles of χ² with 10 degrees of freedom.
    assert 1.48 < np.sum(np.square(deviations)) < 29.6
    assert 0.8 * least < np.median(sigmas) < 2.0 * least
