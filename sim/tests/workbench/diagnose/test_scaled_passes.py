"""Tests that the diagnosis reports a run of a reference in another unit, or with the other sign, as
a fault of the data, and that it does not report a real error that differs between the runs."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS = 30
SIGMA = 0.25
WAY = np.arange(STATIONS) / STATIONS
"""Turns of each station."""


def _curve() -> Float:
    angle = 2.0 * np.pi * WAY
    return 9.0 * np.cos(angle + 0.3) + 3.0 * np.sin(2.0 * angle) + 1.5 * np.cos(5.0 * angle - 1.0)


def _noisy(runs: int, seed: int, curve: Float | None = None, sigma: float = SIGMA) -> Float:
    """Return the errors of each run at the stations, (runs, stations)."""
    curve = _curve() if curve is None else curve
    return curve + np.random.default_rng(seed).normal(0.0, sigma, (runs, STATIONS))


def _set(errors: Float, *, down: tuple[int, ...] = (), **columns: Float) -> MeasurementSet:
    """Return a set with one pass in each run; ``down``: runs from the last station to the first."""
    runs = errors.shape[0]
    number = np.tile(np.arange(STATIONS), (runs, 1))
    number[list(down)] = number[list(down), ::-1]
    return MeasurementSet(
        Table(),
        None,
        Reference(
            target_deg=360.0 * WAY[number].ravel(),
            error_arcsec=np.take_along_axis(errors, number, axis=1).ravel(),
            run=np.repeat(np.arange(runs), STATIONS),
            time_s=np.arange(number.size) * 9.0,
            **columns,
        ),
    )


def _faults(measurement: MeasurementSet) -> list[str]:
    return [text for text in data_faults(observations_of(measurement)) if "times those" in text]


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize(
    ("factor", "words"),
    [
        (1.0 / 60.0, "its errors seem to be in arcminutes"),
        (60.0, "the other errors seem to be in arcminutes"),
        (1.0 / 3600.0, "its errors seem to be in degrees"),
        (np.pi / 648_000.0, "its errors seem to be in radians"),
        (np.pi / 648.0, "its errors seem to be in milliradians"),
        (np.pi / 0.648, "its errors seem to be in microradians"),
        (0.001, "one unit is 1,000 times the other"),
        (1.0 / 7.3, "the unit or the gain differs"),
        (-1.0 / 60.0, "its errors seem to be in arcminutes, with the other sign"),
        (-1.0, "the sign of error_arcsec is wrong in one of them"),
    ],
)
def test_one_of_five_runs(factor: float, words: str, seed: int) -> None:
    """The factor agrees with the true one within four of its own uncertainties."""
    errors = _noisy(5, seed)
    errors[2] *= factor
    (found,) = _faults(_set(errors))
    assert found.startswith(f"reference, run 2, from line {2 * STATIONS + 2} of the file")
    assert words in found
    said = found.partition("its errors are ")[2].partition(" times")[0]
    size, _, sigma = said.rstrip(")").partition(" (u ")
    assert float(size) == pytest.approx(factor, abs=4.5 * float(sigma))


def test_the_verdict_is_bad_data() -> None:
    errors = _noisy(3, 5)
    errors[0] /= 60.0
    found = diagnosis_of(_set(errors))
    assert found.verdict == "bad_data"
    assert "arcminutes" in found.decision.faults[0]


def test_the_rounding_of_the_file_hides_the_scatter() -> None:
    """Degrees with five decimals: the step of 0.036″ is a seventh of
    the noise."""
    errors = _noisy(3, 6)
    errors[1] = np.round(errors[1] / 3600.0, 5)
    assert "in degrees" in _faults(_set(errors))[0]


def test_one_of_two_runs() -> None:
    """No other run shows the noise; the factor alone shows the unit."""
    errors = _noisy(2, 7)
    errors[1] /= 60.0
    assert "run 1" in _faults(_set(errors))[0]
    errors[1] *= 60.0 / 7.3
    assert _faults(_set(errors)) == []


def test_some_cycles_of_a_run() -> None:
    made = _noisy(5, 8)
    made[3] /= 3600.0
    measured = _set(made)
    assert measured.reference is not None
    run = measured.reference.run
    cycles = Reference(
        target_deg=measured.reference.target_deg,
        error_arcsec=measured.reference.error_arcsec,
        run=np.zeros_like(run),
        time_s=measured.reference.time_s,
        cycle=run,
    )
    (found,) = _faults(MeasurementSet(Table(), None, cycles))
    assert "run 0, pass 4" in found


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("gain", [1.0, 0.75, 1.28])
def test_a_gain_is_no_unit(gain: float, seed: int) -> None:
    errors = _noisy(3, seed)
    errors[1] *= gain
    assert _faults(_set(errors)) == []


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("factor", [1.0 / 60.0, 60.0, -1.0])
def test_noise_hides_the_curve(factor: float, seed: int) -> None:
    """The noise is as large as the curve: a factor of it explains at most half of a pass."""
    errors = _noisy(3, seed, 0.03 * _curve())
    errors[1] *= factor
    assert _faults(_set(errors)) == []


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("left", [0.0, 1.0 / 60.0, 0.1, 0.3])
def test_a_run_with_compensation(left: float, seed: int) -> None:
    """Run 1 has the compensation on: a part of the curve is left, and the noise is the same."""
    errors = _noisy(3, seed)
    errors[1] -= (1.0 - left) * _curve()
    assert _faults(_set(errors)) == []


@pytest.mark.parametrize("seed", range(2))
def test_an_error_that_grows_with_a_condition(seed: int) -> None:
    """The error of run 1 has the other sign, or a fifth of the size, with another load; in the
    second case the noise is a fifth as well."""
    load = np.repeat([10.0, -10.0, 10.1], STATIONS)
    errors = _noisy(3, seed)
    errors[1] -= 2.0 * _curve()
    assert len(_faults(_set(errors))) == 1
    assert _faults(_set(errors, conditions={"load_nm": load})) == []
    errors = _noisy(3, seed)
    errors[1] *= 0.2
    assert len(_faults(_set(errors))) == 1
    assert _faults(_set(errors, conditions={"load_nm": load})) == []


def test_an_error_that_changes_its_sign_with_the_direction() -> None:
    errors = _noisy(4, 3)
    errors[[1, 3]] *= -1.0
    assert _faults(_set(errors, down=(1, 3))) == []


@pytest.mark.parametrize("seed", range(2))
def test_a_line_in_time_turned_by_half_a_period(seed: int) -> None:
    """The period is two passes, or two thirds of a pass and a half: run 1 has the other sign."""
    for periods in (0.5, 1.5, 2.5):
        errors = _noisy(3, seed, np.zeros(STATIONS))
        errors += 6.0 * np.sin(2.0 * np.pi * periods * (np.arange(3)[:, np.newaxis] + WAY) + 0.4)
        assert _faults(_set(errors)) == []


@pytest.mark.parametrize("seed", range(5))
def test_drifts(seed: int) -> None:
    """Random walks of two passes, straight drifts there and back, and a temperature that settles:
    each pass is then a constant times the pass before."""
    random = np.random.default_rng(seed)
    walks = np.cumsum(random.normal(0.0, 0.5, (2, STATIONS)), axis=1)
    assert _faults(_set(walks)) == []
    slopes = np.array([[8.0], [-8.0], [7.5]]) * WAY + random.normal(0.0, SIGMA, (3, STATIONS))
    assert _faults(_set(slopes)) == []
    time = np.arange(3)[:, np.newaxis] + WAY
    settling = 60.0 * np.exp(-time * 1.5) + random.normal(0.0, SIGMA, (3, STATIONS))
    assert _faults(_set(settling)) == []
    assert _faults(_set(settling[:2])) == []


def test_a_single_station_is_no_curve() -> None:
    """One station is off by 60″ in run 0 and by 1″ in run 1."""
    errors = np.random.default_rng(2).normal(0.0, 0.02, (2, STATIONS))
    errors[:, 11] += [60.0, 1.0]
    made = observations_of(_set(errors))
    assert not [text for text in data_faults(made) if "times those" in text]
