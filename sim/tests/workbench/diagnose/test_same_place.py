"""Tests that an error which every pass of a reference shows at the same places is stated as such:
not as noise, not as a line, and not as a change in time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.report import diagnosis_data, sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.same_place import visits_of
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS = 72
SIGMA = 0.35


def _stations(
    off_arcsec: Float, seed: int, *, cycles: int = 2, noise: float = SIGMA, faces: int | None = None
) -> MeasurementSet:
    """Return cycles up and down over evenly spaced stations of a table with orders 1 to 3;
    ``off_arcsec`` is the own error of each station."""
    random = np.random.default_rng(seed)
    up = np.arange(off_arcsec.size)
    number = np.tile(np.concatenate([up, up[::-1]]), cycles)
    angle = 2.0 * np.pi * number / off_arcsec.size
    error = 3.0 * np.cos(angle - 0.4) + 1.2 * np.cos(2.0 * angle + 1.0) + 0.7 * np.sin(3.0 * angle)
    error = error + off_arcsec[number] + random.normal(0.0, noise, number.size)
    return MeasurementSet(
        Table(),
        None,
        Reference(
            target_deg=np.degrees(angle),
            error_arcsec=error,
            run=np.zeros(number.size, dtype=np.int64),
            time_s=np.arange(number.size) * 12.0,
            cycle=np.repeat(np.arange(cycles), 2 * up.size),
            direction=np.tile(np.repeat([1, -1], up.size), cycles),
            faces=faces,
        ),
    )


def _text(found: Diagnosis) -> str:
    return " ".join(sentences(found))


@pytest.mark.parametrize("seed", [1, 2])
def test_one_station_that_is_off_in_every_pass(seed: int) -> None:
    """A station of 4″ in 0.35″ of noise: the classical F test of 72 stations against the repeats
    gives p below 1e-12. The error of four readings is 0.18″, with 41 coefficients at 72 stations
    √(72/31) times as much."""
    off = np.zeros(STATIONS)
    off[43] = 4.0
    found = diagnosis_of(_stations(off, seed))
    assert found.verdict == "unknown"
    assert found.channels["reference"].lack_of_fit_p < 1e-8
    places = found.findings.places
    assert places is not None
    (spot,) = places.spots
    assert spot.angle_deg == pytest.approx(215.0)
    assert spot.size_arcsec == pytest.approx(4.0, abs=3.0 * 0.27)
    assert spot.sigma_arcsec == pytest.approx(0.27, rel=0.3)
    assert "a single station is off in each of 4 passes: 215° by" in _text(found)
    data = diagnosis_data(found, [])
    assert data["findings"]["repeated_at_places"]["single_places"][0]["angle_deg"] == (
        spot.angle_deg
    )
    assert "graduation_defect" in data["look_alikes"]


def test_six_stations() -> None:
    off = np.zeros(STATIONS)
    off[[5, 18, 26, 43, 54, 66]] = [3.0, -3.0, 3.0, 3.0, -3.0, 3.0]
    found = diagnosis_of(_stations(off, 3, noise=0.3))
    assert found.verdict == "unknown"
    assert found.description is None
    places = found.findings.places
    assert places is not None
    assert sorted(item.angle_deg for item in places.spots) == pytest.approx(
        [25.0, 90.0, 130.0, 215.0, 270.0, 330.0]
    )
    assert "single stations are off" in _text(found)


@pytest.mark.parametrize("seed", [1, 4])
def test_white_errors_of_the_stations_are_no_line(seed: int) -> None:
    """Each of 72 faces has its own error of 0.5″: the largest order of 72 independent errors
    repeats in every cycle, but it is no line."""
    faces = np.random.default_rng([9, seed]).normal(0.0, 0.5, STATIONS)
    found = diagnosis_of(_stations(faces, seed, cycles=3, noise=0.12, faces=STATIONS))
    assert found.verdict == "unknown"
    assert found.description is None
    assert "polygon_face_error" in found.decision.look_alikes
    text = _text(found)
    assert "The error repeats at equal angle in 6 passes" in text
    assert "polygon_face_error would look the same" in text


def test_a_line_among_smaller_errors_of_the_stations_is_named() -> None:
    """A line of order 27 and 1″ explains most of the stations' errors; the others are 0.2″."""
    random = np.random.default_rng(5)
    angle = 2.0 * np.pi * np.arange(STATIONS) / STATIONS
    off = np.cos(27.0 * angle + 0.3) + random.normal(0.0, 0.2, STATIONS)
    found = diagnosis_of(_stations(off, 5, cycles=3, noise=0.12))
    assert found.effect_class[:1] == ["periodic_error"]


def _wander(random: np.random.Generator, angle: Float) -> Float:
    """Return an error of orders 1 to 3, another one for each call: 2″ each."""
    parts = random.normal(0.0, 2.0, (3, 2))
    orders = np.arange(1, 4)[:, np.newaxis]
    waves = parts[:, :1] * np.cos(orders * angle) + parts[:, 1:] * np.sin(orders * angle)
    return np.asarray(waves.sum(axis=0))


def _walk(random: np.random.Generator, angle: Float) -> Float:
    return np.asarray(np.cumsum(random.normal(0.0, 0.2, angle.size)))


@pytest.mark.parametrize("of_cycle", [_wander, _walk])
def test_cycles_that_wander_show_no_repeated_error(
    of_cycle: Callable[[np.random.Generator, Float], Float],
) -> None:
    """Each of 40 sets has four passes that wander; p below 0.01 is expected in 0.4 of them, and in
    more than four with the probability 0.0001 (Poisson)."""
    sure = 0
    for seed in range(40):
        random = np.random.default_rng([3, seed])
        made = _stations(np.zeros(STATIONS), seed)
        rows = made.reference
        assert rows is not None
        angle = np.radians(rows.target_deg)
        one_pass = np.arange(angle.size) // STATIONS
        error = rows.error_arcsec.copy()
        for number in np.unique(one_pass):
            error[one_pass == number] += of_cycle(random, angle[one_pass == number])
        rows.error_arcsec[:] = error
        base = [Term(built_in()["graduation_harmonics"](), {})]
        visits = visits_of(fit(base, observations_of(made)))
        assert visits is not None
        assert visits.by_place.p > 1e-4
        sure += visits.lack_of_fit_p < 0.01
    assert sure <= 4
