"""Tests that an error which every pass of a reference shows at the same places is stated as such:
not as noise, not as a line, and not as a change in time."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.visits_of_places import visits_of
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
    gives p below 1e-12. The mean of four readings has u = 0.18″; with 41 coefficients at 72
    stations, u is √(72/31) times as large."""
    off = np.zeros(STATIONS)
    off[43] = 4.0
    found = diagnosis_of(_stations(off, seed))
    assert found.verdict == "unknown"
    assert found.channels["reference"].lack_of_fit_p < 1e-8
    places = found.detections.places
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
    places = found.detections.places
    assert places is not None
    assert sorted(item.angle_deg for item in places.spots) == pytest.approx(
        [25.0, 90.0, 130.0, 215.0, 270.0, 330.0]
    )
    assert "single stations are off" in _text(found)


@pytest.mark.parametrize("seed", [1, 4])
def test_white_errors_of_the_stations_are_no_line(seed: int) -> None:
    """Each of 72 faces has its own error of 0.5″: the order with the largest amplitude repeats in
    every cycle, but it is no line, because the errors are independent."""
    faces = np.random.default_rng([9, seed]).normal(0.0, 0.5, STATIONS)
    found = diagnosis_of(_stations(faces, seed, cycles=3, noise=0.12, faces=STATIONS))
    assert found.verdict == "unknown"
    assert found.description is None
    assert "polygon_face_error" in found.decision.look_alikes
    text = _text(found)
    assert "The error repeats at equal angle in 6 passes" in text
    assert "polygon_face_error would look the same" in text


def test_a_line_among_smaller_errors_of_the_stations_is_named() -> None:
    """A line of order 27 and 1″ explains most of the stations' errors; the remaining errors are
    0.2″."""
    random = np.random.default_rng(5)
    angle = 2.0 * np.pi * np.arange(STATIONS) / STATIONS
    off = np.cos(27.0 * angle + 0.3) + random.normal(0.0, 0.2, STATIONS)
    found = diagnosis_of(_stations(off, 5, cycles=3, noise=0.12))
    assert found.effect_class[:1] == ["periodic_error"]


def _wander(random: np.random.Generator, angle: Float) -> Float:
    """Return an error of orders 1 to 3 whose coefficients, 2″ RMS, are drawn anew in each call."""
    parts = random.normal(0.0, 2.0, (3, 2))
    orders = np.arange(1, 4)[:, np.newaxis]
    waves = parts[:, :1] * np.cos(orders * angle) + parts[:, 1:] * np.sin(orders * angle)
    return np.asarray(waves.sum(axis=0))


def _walk(random: np.random.Generator, angle: Float) -> Float:
    return np.asarray(np.cumsum(random.normal(0.0, 0.2, angle.size)))


@pytest.mark.large
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


def _sweeps(
    angle_deg: Float, error: Callable[[Float], Float], sweeps: int, noise: float, step_s: float
) -> MeasurementSet:
    """Return sweeps up and down over the same angles, each a run; ``error`` is a function of the
    angle in degrees."""
    random = np.random.default_rng(12)
    ways = [angle_deg if run % 2 == 0 else angle_deg[::-1] for run in range(sweeps)]
    angle = np.concatenate(ways)
    run = np.repeat(np.arange(sweeps), angle_deg.size)
    reference = Reference(
        target_deg=angle,
        error_arcsec=error(angle) + random.normal(0.0, noise, angle.size),
        run=run,
        time_s=np.arange(angle.size) * step_s + 3.0 * run,
        direction=1 - 2 * (run % 2),
    )
    return MeasurementSet(Table(), None, reference)


@pytest.mark.large
def test_a_defect_that_every_turn_repeats_is_no_oscillation() -> None:
    """A defect of 120″, 4.7° wide at half its height, in five turns without a stop. Its highest
    reading is within a step of 0.3° of its middle."""
    random = np.random.default_rng(6)
    angle = np.arange(6000) * 0.3
    aside = (angle - 143.0 + 180.0) % 360.0 - 180.0
    error = 100.0 * np.cos(np.radians(angle) - 0.3) + 120.0 * np.exp(-((aside / 2.8) ** 2))
    reference = Reference(
        target_deg=angle,
        error_arcsec=error + random.normal(0.0, 12.0, angle.size),
        time_s=np.arange(angle.size) * 0.005,
        run=np.zeros(angle.size, dtype=np.int64),
        direction=np.ones(angle.size, dtype=np.int64),
    )
    found = diagnosis_of(MeasurementSet(Table(counts_per_rev=1 << 16), None, reference))
    assert found.verdict == "unknown"
    places = found.detections.places
    assert places is not None
    (spot,) = places.spots
    assert spot.angle_deg == pytest.approx(143.0, abs=1.0)
    # Two readings in each of five turns have u = 12/√10″; the curves of the turns absorb a part of
    # the defect.
    assert spot.size_arcsec == pytest.approx(120.0, abs=20.0)
    assert found.detections.oscillation is None
    assert found.detections.causes == ()
    assert "a single place is off in each of 5 passes: 14" in _text(found)


def _without_orders(made: MeasurementSet) -> Diagnosis:
    """Diagnose with a model of a constant, as the commands do on an arc."""
    return diagnose(observations_of(made), [], built_in())


@pytest.mark.parametrize("sweeps", [2, pytest.param(6, marks=pytest.mark.large)])
def test_a_sag_over_an_arc_is_no_change_in_time(sweeps: int) -> None:
    angle = np.arange(10.0, 80.0, 0.5)
    made = _sweeps(angle, lambda at: 35.0 * np.cos(np.radians(at)), sweeps, 2.0, 1.0)
    found = _without_orders(made)
    assert found.verdict == "unknown"
    assert found.detections.slow is None
    assert found.detections.places is not None
    # The slope is described as an error of the travel; the remaining curve repeats at the places.
    sag = 35.0 * np.cos(np.radians(angle))
    curve = float(np.std(sag - np.polyval(np.polyfit(angle, sag, 1), angle)))
    assert found.described is not None
    assert found.described.effect.parts == ["travel", "reference"]
    assert found.detections.places.rms_arcsec == pytest.approx(curve, rel=0.1)
    assert f"The error repeats at equal angle in {sweeps} passes" in _text(found)


@pytest.mark.large
def test_an_error_of_the_travel_is_no_change_in_time() -> None:
    """An error of 0.25″ a degree over four turns is the same at each angle on the way back."""
    angle = np.arange(0.0, 1440.0, 4.0)
    found = diagnosis_of(_sweeps(angle, lambda at: 0.25 * at, 4, 15.0, 0.1))
    assert found.detections.slow is None
    assert "The error repeats at equal angle of travel in 4 passes" in _text(found)


def test_an_arc_over_zero_is_one_pass_each_time() -> None:
    """Six sweeps from −40° to 40° pass each place six times, although each sweep crosses 0°."""
    angle = np.arange(-40.0, 40.5, 0.5)
    found = _without_orders(
        _sweeps(angle, lambda at: 35.0 * np.cos(np.radians(3.0 * at)), 6, 2.0, 1.0)
    )
    assert "in 6 passes" in _text(found)
