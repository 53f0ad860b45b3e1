"""Tests that the default model does not absorb a slow error over a short arc of a reference.

The logs are computed in this module, with plain numpy.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

import arctrue as at
from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.measurement.writer import write_measurement_set
from arctrue.report.analysis import Analysis
from arctrue.report.sections import set_section
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.model.growth import fitted, settle
from arctrue.workbench.model.model import Model, ModelEffect, default_model
from arctrue.workbench.model.stations import on_its_arc, warnings_of_the_arc
from arctrue.workbench.observations.build import observations_of
from tests.command_line import arctrue

Float = NDArray[np.float64]

EFFECTS = built_in()
NOISE_ARCSEC = 0.08
STEP_S = 3.0
ROWS = 1200


def _log(
    error_arcsec: NDArray[np.float64], arc_deg: float, temperature_c: NDArray[np.float64] | None
) -> MeasurementSet:
    """Return a log of one pass over an arc at constant speed, with white noise."""
    rows = error_arcsec.size
    noise = NOISE_ARCSEC * np.random.default_rng(12).standard_normal(rows)
    return MeasurementSet(
        table=Table(),
        reference=Reference(
            target_deg=np.linspace(0.0, arc_deg, rows),
            error_arcsec=error_arcsec + noise,
            run=np.zeros(rows, dtype=np.int64),
            time_s=np.arange(rows, dtype=np.float64) * STEP_S,
            direction=np.ones(rows, dtype=np.int64),
            temperature_c=temperature_c,
        ),
    )


def _diagnosed(measured: MeasurementSet) -> Diagnosis:
    observations = observations_of(measured)
    return diagnose(observations, settle(default_model(), observations, EFFECTS), EFFECTS)


def test_a_scale_that_follows_the_air() -> None:
    """An interferometer reads 1.4″/K over an arc of 70°, while the air warms and its control
    swings seven times; orders 1 to 20 of the turn would explain nearly all of this."""
    time_s = np.arange(ROWS) * STEP_S
    air = (
        21.0 + 1.1 * (1.0 - np.exp(-time_s / 1100.0)) + 0.12 * np.sin(2.0 * np.pi * time_s / 515.0)
    )
    sensor = air + 0.01 * np.random.default_rng(3).standard_normal(ROWS)
    found = _diagnosed(_log(1.4 * (air - air[0]), 70.0, sensor))
    assert found.verdict == "unknown"
    assert found.described is not None
    assert found.described.effect.parts == ["temperature", "reference"]
    (size,) = found.described.parameters().values()
    # The sensor's noise of 0.01 K reduces the slope by 1/600, its share of the temperature's
    # variance.
    assert size.value == pytest.approx(1.4, rel=0.02)


def test_a_control_of_the_air_without_a_thermometer() -> None:
    """A swing of 0.9″ over seven periods of time, on an arc of 70°, is found with its period."""
    time_s = np.arange(ROWS) * STEP_S
    found = _diagnosed(_log(0.9 * np.sin(2.0 * np.pi * time_s / 515.0), 70.0, None))
    assert found.named is not None
    assert found.named.name == "periodic_error"
    seconds = 1.0 / (found.named.nonlinear["order"] * (70.0 / 360.0) / time_s[-1])
    # Seven periods with an amplitude of eleven times the noise: u is a thousandth of a period.
    assert seconds == pytest.approx(515.0, rel=0.02)


@pytest.mark.large
def test_a_settling_far_above_a_line() -> None:
    """The diagnosis states a settling of 25″ with its time constant, and not only a line of 1″."""
    time_s = np.arange(ROWS) * STEP_S
    settling = 25.0 * np.exp(-time_s / 800.0)
    found = _diagnosed(_log(settling + np.sin(2.0 * np.pi * time_s / 211.0), 15.0, None))
    assert any("slow change" in text or "exp(−t/" in text for text in sentences(found))


@pytest.mark.parametrize("arc_deg", [9.0, 70.0, 179.0])
def test_no_order_of_the_disc_below_half_a_turn(arc_deg: float) -> None:
    observations = observations_of(_log(np.zeros(ROWS), arc_deg, None))
    assert on_its_arc(default_model(), observations).effects == []
    own = Model([ModelEffect("graduation_harmonics", {"orders": [1, 2]})])
    assert on_its_arc(own, observations) == own


def test_the_orders_of_two_thirds_of_a_turn_are_determined() -> None:
    """On 240° each coefficient has at most ten times the uncertainty over whole turns, and the
    eccentricity is among the orders."""
    observations = observations_of(_log(np.zeros(ROWS), 240.0, None))
    model, solution = fitted(default_model(), observations, EFFECTS)
    orders = model.effects[0].settings["orders"]
    assert isinstance(orders, list)
    assert orders[0] == 1
    # Over whole turns u = σ·√(2/N). The fit may take a part of the white noise for slow noise: 30 %
    # are allowed.
    most = 1.3 * 10.0 * NOISE_ARCSEC * np.sqrt(2.0 / ROWS)
    assert np.sqrt(np.diag(solution.covariance)).max() < most


def test_a_whole_turn_and_most_of_one_keep_twenty_orders() -> None:
    for arc_deg in (300.0, 345.0, 720.0):
        observations = observations_of(_log(np.zeros(ROWS), arc_deg, None))
        assert on_its_arc(default_model(), observations) == default_model()


@pytest.mark.large
def test_the_python_interface_and_the_page_state_it_in_the_same_words() -> None:
    """``fit``, ``compare`` and ``diagnose`` of Python and the page give one warning in the same
    words; a whole turn gets none."""
    for arc_deg, warned in ((70.0, True), (720.0, False)):
        measured = _log(np.zeros(ROWS), arc_deg, None)
        (text,) = warnings_of_the_arc(default_model(), observations_of(measured)) or [""]
        assert text.startswith("the reference covers 70° of the turn") == warned
        observations = observations_of(measured)
        model, solution = fitted(default_model(), observations, EFFECTS)
        page = set_section(Analysis(measured, "arc", observations, model, solution, EFFECTS), None)
        for warnings in (
            at.fit(measured).warnings,
            at.compare(measured).warnings,
            at.diagnose(measured).warnings,
            page["warnings"],
        ):
            assert (text in warnings) == warned


def test_the_commands_state_it(tmp_path: Path) -> None:
    """``compare`` and ``explain`` use the same model and warn that it has no order."""
    time_s = np.arange(ROWS) * STEP_S
    swing = 0.9 * np.sin(2.0 * np.pi * time_s / 515.0)
    write_measurement_set(tmp_path / "arc", _log(swing, 70.0, None))
    for command in ("compare", "explain"):
        result = arctrue(command, tmp_path / "arc")
        assert result.exit_code == 0
        assert "the reference covers 70° of the turn" in result.stderr
        assert "periodic_error" in result.stdout or command == "compare"


PASSES, PLACES = 12, 41


def _to_and_fro(
    error_arcsec: Callable[[Float, Float], Float], arc_deg: float, seed: int
) -> MeasurementSet:
    """Return twelve passes to and fro over stations of an arc; the error is a function of the place
    from −1 to 1 and of the direction, and a reading has 0.15″ of noise."""
    random = np.random.default_rng(seed)
    places = np.linspace(-1.0, 1.0, PLACES)
    number = np.repeat(np.arange(PASSES), PLACES)
    direction = np.where(number % 2 == 0, 1, -1)
    place = np.where(direction > 0, np.tile(places, PASSES), np.tile(places[::-1], PASSES))
    error = error_arcsec(place, direction) + random.normal(0.0, 0.15, place.size)
    reference = Reference(
        0.5 * arc_deg * place,
        error,
        run=number // 2,
        time_s=1.8 * np.arange(place.size, dtype=np.float64) + 10.0 * number,
        direction=direction,
    )
    return MeasurementSet(Table(), None, reference, title="to and fro")


@pytest.mark.parametrize("arc_deg", [pytest.param(20.0, marks=pytest.mark.large), 150.0])
def test_a_scale_on_an_arc_and_a_reversal_error(arc_deg: float) -> None:
    """A scale of the reference of 6″ at each end, and a reversal error of ±0.4″.

    All passes share the scale, as they would share an error of the disc. On 20° the speed is nearly
    the same in all passes, so that a latency is possible too.
    """
    found = _diagnosed(_to_and_fro(lambda x, d: 6.0 * x + 0.4 * d, arc_deg, 1))
    assert found.effect_class[:1] == ["hysteresis"]
    said = " ".join(sentences(found))
    # A straight line from −6″ to 6″ has the RMS 6/√3.
    shared = re.search(r"share a smooth curve of the angle, (\S+)″ RMS", said)
    assert shared is not None
    assert float(shared[1]) == pytest.approx(6.0 / 3**0.5, abs=5 * 0.15 / 492**0.5)
    reversal = re.search(r"(differ by|reversal error) (\S+)″", said)
    assert reversal is not None
    # The standard uncertainty of the difference of two means of 246 readings.
    assert float(reversal[2]) == pytest.approx(0.8, abs=5 * 0.15 * (2 / 246) ** 0.5)
    assert "slow change" not in said


def test_a_curve_of_the_angle_is_no_line_and_no_slow_change() -> None:
    """A nonlinearity of 3″ at both ends, in proportion to the cube of the angle."""
    found = _diagnosed(_to_and_fro(lambda x, d: 3.0 * x**3 + 0.0 * d, 20.0, 2))
    assert found.verdict == "cannot_tell"
    assert found.detections.slow is None
    # The cube has the RMS 3/√7 = 1.13″.
    assert "share a smooth curve of the angle, 1.1" in " ".join(sentences(found))


def test_noise_on_an_arc_has_no_scale() -> None:
    found = _diagnosed(_to_and_fro(lambda x, d: 0.0 * x * d, 20.0, 3))
    assert found.verdict in ("adequate", "cannot_tell")


def test_a_drift_of_a_single_pass_is_of_the_time() -> None:
    """In one pass the angle and the time are proportional; the time comes first."""
    rows = 300
    random = np.random.default_rng(4)
    time_s = np.arange(rows, dtype=np.float64) * 2.0
    reference = Reference(
        np.linspace(0.0, 20.0, rows),
        0.01 * time_s + random.normal(0.0, 0.15, rows),
        run=np.zeros(rows, dtype=np.int64),
        time_s=time_s,
    )
    found = _diagnosed(MeasurementSet(Table(), None, reference, title="one pass"))
    assert "travel" not in " ".join(sentences(found))
    assert found.effect_class[:1] == ["reference_drift"]


@pytest.mark.large
def test_an_error_that_grows_over_ten_turns() -> None:
    """A rope that winds over ten turns up and down three times: 4″ per turn."""
    turns = np.concatenate([np.linspace(0.0, 10.0, 200), np.linspace(10.0, 0.0, 200)] * 3)
    random = np.random.default_rng(5)
    reference = Reference(
        360.0 * turns,
        4.0 * turns + random.normal(0.0, 2.0, turns.size),
        run=np.zeros(turns.size, dtype=np.int64),
        time_s=np.arange(turns.size, dtype=np.float64) * 2.0,
        direction=np.repeat([1, -1] * 3, 200),
    )
    found = _diagnosed(MeasurementSet(Table(), None, reference, title="lift"))
    assert found.described is not None
    assert found.described.effect.parts == ["travel", "reference"]
    (slope,) = found.described.parameters().values()
    assert 360.0 * slope.value == pytest.approx(4.0, abs=0.2)
    assert found.detections.slow is None
