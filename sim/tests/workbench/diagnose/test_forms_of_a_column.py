"""Tests errors that grow with the square or the size of a recorded condition, and a reversal error
that grows with time."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.effects.part_conditions import conditions
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS, NOISE = 24, 0.15
LOADS = np.array([0.0, 50.0, -50.0, 100.0, -100.0, 0.0, 100.0, -100.0, 50.0, -50.0])
"""Torque of each run: ten runs, both signs, not in the order of time."""


def _loaded(size: Float, wave_order: int, seed: int) -> MeasurementSet:
    """Return ten runs over 24 stations with an error of ``size`` in each run."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(LOADS.size), STATIONS)
    target = np.tile(np.arange(STATIONS) * 360.0 / STATIONS, LOADS.size)
    angle = np.radians(target)
    wave = np.cos(wave_order * angle - 1.0) if wave_order else np.ones(run.size)
    error = 5.0 * np.cos(angle + 0.3) + np.cos(2.0 * angle + 1.0) + size[run] * wave
    reference = Reference(
        target,
        error + random.normal(0.0, NOISE, run.size),
        run=run,
        time_s=5.0 * np.arange(run.size) + random.uniform(-0.5, 0.5, run.size) + 30.0 * run,
        direction=np.ones(run.size),
        conditions={"load_nm": LOADS[run]},
    )
    return MeasurementSet(Table(), None, reference)


def _described(found: Diagnosis) -> tuple[list[str], float]:
    assert found.verdict == "unknown"
    assert found.described is not None
    values = found.described.parameters()
    return found.described.effect.parts, abs((values.get("amplitude") or values["size"]).value)


@pytest.mark.parametrize("seed", [1, 2, 3])
@pytest.mark.parametrize(
    ("form", "part"),
    [
        (np.square, "load_nm^2"),
        (np.abs, "|load_nm|"),
        (lambda x: x * np.abs(x), "load_nm*|load_nm|"),
    ],
)
def test_a_form_of_a_load_is_described(form: object, part: str, seed: int, tmp_path: Path) -> None:
    """The mean of 24 readings of 0.15″ has u = 0.031″. The sum of squares of the factors about
    their mean exceeds 1 over the ten runs, so that u of the size is below 0.031″. The bound of 0.3″
    allows for noise between the runs."""
    assert callable(form)
    found = diagnosis_of(_loaded(2.0 * form(LOADS / 100.0), 0, seed))
    parts, size = _described(found)
    assert parts == [part, "reference"]
    scale = 100.0 if part == "|load_nm|" else 1e4
    assert size * scale == pytest.approx(2.0, abs=0.3)
    assert isinstance(found.described.effect, ProductOfParts)
    adopt(found.described.effect, "loaded", found.description or "", tmp_path)
    again = catalogue([tmp_path])["loaded"]()
    assert isinstance(again, ProductOfParts)
    assert again.parts == parts


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_order_that_grows_with_the_square_of_a_load_is_described(seed: int) -> None:
    found = diagnosis_of(_loaded(2.0 * (LOADS / 100.0) ** 2, 2, seed))
    parts, size = _described(found)
    assert parts == ["load_nm^2", "order:2", "reference"]
    assert size * 1e4 == pytest.approx(2.0, abs=0.15)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_load_in_proportion_keeps_the_simple_form(seed: int) -> None:
    parts, _ = _described(diagnosis_of(_loaded(2.0 * LOADS / 100.0, 0, seed)))
    assert parts == ["load_nm", "reference"]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_load_without_an_effect_is_not_described(seed: int) -> None:
    assert diagnosis_of(_loaded(np.zeros(LOADS.size), 0, seed)).described is None


def test_the_description_states_that_an_error_falls() -> None:
    """A torque of 100 N·m reduces the error by 2″."""
    found = diagnosis_of(_loaded(-2.0 * LOADS / 100.0, 0, 1))
    assert (found.description or "").endswith("reference only, −0.02″/N·m")
    assert "load_nm outside −100 to 100 N·m" in (found.next_measurement or "")


def test_a_column_far_from_zero_has_no_forms() -> None:
    """The search tries no square of an air pressure of 990 to 1010 hPa: pressure and square, scaled
    alike, differ by 10⁻⁴ of their change."""
    made = _loaded(np.zeros(LOADS.size), 0, 1)
    assert made.reference is not None
    made.reference.conditions["load_nm"][:] = 1000.0 + 0.1 * made.reference.conditions["load_nm"]
    assert not [item for item in conditions(observations_of(made)) if item.form]


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_reversal_error_that_grows_with_time(seed: int) -> None:
    """The error changes by ±1.5″ per hour with the direction, over 36 stations up and down for two
    hours."""
    random = np.random.default_rng(seed)
    runs, stations = 20, 36
    run = np.repeat(np.arange(runs), stations)
    up = np.arange(stations) * 10.0
    target = np.concatenate([up if number % 2 == 0 else up[::-1] for number in range(runs)])
    time_s = 7200.0 * np.arange(run.size) / run.size
    direction = np.where(run % 2 == 0, 1.0, -1.0)
    error = 5.0 * np.cos(np.radians(target)) + 1.5 * direction * time_s / 3600.0
    reference = Reference(
        target,
        error + random.normal(0.0, 0.2, run.size),
        run=run,
        time_s=time_s,
        direction=direction,
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference))
    parts, size = _described(found)
    assert parts == ["direction", "time", "reference"]
    assert size == pytest.approx(1.5, abs=0.1)
