"""Tests that an error which follows a function or a lag of a recorded condition is described by
this condition and never called a line in time."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.candidates import tried_forms
from arctrue.workbench.diagnose.condition_forms import best_form
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.evidence_of_one import with_evidence
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.survey import Survey
from arctrue.workbench.effects.part_conditions import column_of, form_condition
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in, catalogue
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.likelihood_ratio import Null
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS, PASSES, STEP_S, NOISE = 24, 6, 45.0, 0.2
LAG_S = 900.0


def _times(random: np.random.Generator) -> Float:
    rows = STATIONS * PASSES
    return STEP_S * np.arange(rows) + random.uniform(-2.0, 2.0, rows)


def _made(
    error: Float, time_s: Float, random: np.random.Generator, **recorded: Float
) -> MeasurementSet:
    """Return six passes over 24 stations, up and down, with an error of each row."""
    run = np.repeat(np.arange(PASSES), STATIONS)
    up = np.arange(STATIONS) * 360.0 / STATIONS
    target = np.concatenate([up if one % 2 == 0 else up[::-1] for one in range(PASSES)])
    of_disc = 7.0 * np.cos(np.radians(target) + 0.7) + 1.5 * np.cos(np.radians(2.0 * target))
    temperature_c = recorded.pop("temperature_c", None)
    reference = Reference(
        target,
        of_disc + error + random.normal(0.0, NOISE, run.size),
        run=run,
        time_s=time_s,
        direction=np.where(run % 2 == 0, 1.0, -1.0),
        temperature_c=temperature_c,
        conditions=recorded,
    )
    return MeasurementSet(Table(), None, reference)


def _one_period(time_s: Float, random: np.random.Generator) -> Float:
    return np.asarray(2.2 * np.sin(2.0 * np.pi * time_s / 3700.0 + random.uniform(0.0, 6.0)))


def _two_periods(time_s: Float, random: np.random.Generator) -> Float:
    return _one_period(time_s, random) + 1.3 * np.sin(2.0 * np.pi * time_s / 2300.0)


@cache
def _parabola(room: Callable[[Float, np.random.Generator], Float], seed: int) -> Diagnosis:
    """0.15″/K² about 19.4 °C, of a room about 19.2 °C."""
    random = np.random.default_rng(seed)
    time_s = _times(random)
    true = 19.2 + room(time_s, random)
    recorded = np.round(true + random.normal(0.0, 0.03, true.size), 3)
    return diagnosis_of(_made(0.15 * (true - 19.4) ** 2, time_s, random, temperature_c=recorded))


def _described(found: Diagnosis) -> ProductOfParts:
    assert found.described is not None
    assert isinstance(found.described.effect, ProductOfParts)
    return found.described.effect


@pytest.mark.parametrize("seed", [1, 2])
@pytest.mark.parametrize("room", [_one_period, _two_periods])
def test_a_parabola_of_the_temperature_is_no_line(
    room: Callable[[Float, np.random.Generator], Float], seed: int
) -> None:
    """144 rows of 0.2″ and (T − c)² with a standard deviation of about 2 K² give u = 0.009″/K² of
    the size; the slow error of c, 0.3 K · c, is below 0.1 K. Bounds: five of these."""
    found = _parabola(room, seed)
    assert found.named is None
    product = _described(found)
    assert product.parts == ["temperature^2", "reference"]
    assert product.condition.column_zero == pytest.approx(19.4, abs=0.5)
    assert found.described is not None
    assert found.described.parameters()["size"].value == pytest.approx(0.15, abs=0.045)
    assert "fixed to time" not in " ".join(sentences(found))


@pytest.mark.parametrize("seed", [1, 2])
def test_an_error_above_a_load_leaves_no_line(seed: int, tmp_path: Path) -> None:
    """0.15″/N·m above 36 N·m of a load that rises and falls between 0 and 50 N·m: a third of the
    144 rows, with a standard deviation of about 5 N·m, give u = 0.006″/N·m."""
    random = np.random.default_rng(seed)
    time_s = _times(random)
    load = 25.0 + 25.0 * np.sin(2.0 * np.pi * time_s / 1310.0 + random.uniform(0.0, 6.0))
    error = 0.15 * np.maximum(0.0, load - 36.0)
    recorded = np.round(load + random.normal(0.0, 0.2, load.size), 2)
    found = diagnosis_of(_made(error, time_s, random, load_nm=recorded))
    assert found.verdict == "unknown"
    product = _described(found)
    assert product.parts == ["above:load_nm", "reference"]
    assert product.condition.column_zero == pytest.approx(36.0, abs=4.0)
    assert found.described is not None
    assert found.described.parameters()["size"].value == pytest.approx(0.15, abs=0.03)
    said = " ".join(sentences(found))
    assert "periodic_error explains" not in said
    assert "fixed to time" not in said
    adopt(product, "slips", found.description or "", tmp_path)
    again = catalogue([tmp_path])["slips"]()
    assert again.parts == product.parts
    assert isinstance(again, ProductOfParts)
    assert again.condition.words == product.condition.words


def _lagging(time_s: Float) -> tuple[Float, Float]:
    """Return a room that is switched between two temperatures, and a body behind it, which is
    integrated in steps of 1 s."""
    every_s = np.arange(0.0, time_s[-1] + 1.0)
    room = np.where(np.sin(2.0 * np.pi * every_s / 3100.0 + 0.4) > 0.0, 21.5, 18.5)
    body = np.full(every_s.size, room[0])
    for second in range(1, body.size):
        body[second] = body[second - 1] + (room[second] - body[second - 1]) / LAG_S
    return np.interp(time_s, every_s, room), np.interp(time_s, every_s, body)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_lag_behind_the_temperature_is_described(seed: int, tmp_path: Path) -> None:
    """A body that follows 3 K with 900 s changes by about 2 K: 144 rows of 0.2″ give u = 0.03″/K of
    its size, and about 60 s of the lag. Bounds: five of these."""
    random = np.random.default_rng(seed)
    time_s = np.maximum.accumulate(np.maximum(_times(random), 0.0)) + 1e-3 * np.arange(144)
    room, body = _lagging(time_s)
    recorded = np.round(room + random.normal(0.0, 0.03, room.size), 3)
    found = diagnosis_of(_made(0.6 * (body - 20.0), time_s, random, temperature_c=recorded))
    assert found.verdict == "unknown"
    product = _described(found)
    assert product.parts == ["lag:temperature", "reference"]
    assert product.condition.time_constant_s == pytest.approx(LAG_S, abs=300.0)
    assert found.described is not None
    assert found.described.parameters()["size"].value == pytest.approx(0.6, abs=0.15)
    assert found.lag is not None
    assert found.lag.time_constant_s == product.condition.time_constant_s
    adopt(product, "lags", found.description or "", tmp_path)
    again = catalogue([tmp_path])["lags"]()
    assert isinstance(again, ProductOfParts)
    assert again.settings["time_constant_s"] == product.condition.time_constant_s


def _null(flavour: str, seed: int) -> Residuals:
    """Return the residuals of a set whose error and temperature are independent."""
    random = np.random.default_rng(100 + seed)
    time_s = _times(random)
    temperature_c = 21.0 + np.cumsum(random.normal(0.0, 0.12, time_s.size))
    error = np.zeros(time_s.size)
    if flavour != "white":
        error = np.cumsum(random.normal(0.0, 0.06, time_s.size))
    if flavour == "cycle":
        temperature_c = 21.0 + _one_period(time_s, random)
    made = _made(error, time_s, random, temperature_c=np.round(temperature_c, 3))
    return Residuals(fit([Term(built_in()["graduation_harmonics"](), {})], observations_of(made)))


def _false(flavour: str, seed: int) -> list[str]:
    """Return the descriptions of a null that would be stated."""
    residuals = _null(flavour, seed)
    survey = Survey(residuals, 0.02, len(built_in()))
    null = Null(residuals)
    judged = [
        with_evidence(item, survey, null, 1, lambda text: None)
        for item in tried_forms(residuals, 1)
        if item.p_corrected < 0.3
    ]
    return [
        item.effect.describe({})
        for item in judged
        if item.p_corrected < SIGNIFICANCE and survey.confirmed(item)
    ]


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("flavour", ["white", "walk", "cycle"])
def test_an_independent_temperature_is_not_described(flavour: str, seed: int) -> None:
    assert _false(flavour, seed) == []


@pytest.mark.large
@pytest.mark.parametrize("flavour", ["white", "walk", "cycle"])
def test_few_nulls_of_thirty_are_described(flavour: str) -> None:
    """p is below SIGNIFICANCE in 1 % of the nulls; 3 or more of 30 have a probability of 0.3 %."""
    assert sum(bool(_false(flavour, seed)) for seed in range(30)) < 3


def test_a_form_has_its_values() -> None:
    random = np.random.default_rng(3)
    time_s = _times(random)
    load = random.uniform(0.0, 50.0, time_s.size)
    rows = observations_of(
        _made(np.zeros(time_s.size), time_s, random, load_nm=load, temperature_c=load)
    ).reference
    assert rows is not None
    for column in ("load_nm", "temperature_c"):
        assert column_of(rows, column) == pytest.approx(load)
        for form, expected in (
            ("square", (load - 20.0) ** 2),
            ("size", np.abs(load - 20.0)),
            ("above", np.clip(load - 20.0, 0.0, None)),
            ("below", np.clip(20.0 - load, 0.0, None)),
        ):
            assert form_condition(column, form, 20.0).values(rows) == pytest.approx(expected)
    with pytest.raises(ValueError, match="no form 'cube'"):
        form_condition("load_nm", "cube")
    with pytest.raises(ValueError, match="seconds above 0 for the lag of a column"):
        ProductOfParts(column="load_nm", condition="lag", fixed_to="reference")


def test_a_load_of_three_levels_has_no_form() -> None:
    """A parabola with a free zero fits any three levels."""
    random = np.random.default_rng(4)
    time_s = _times(random)
    load = random.choice([0.0, 20.0, 50.0], time_s.size)
    made = _made(0.1 * np.abs(load - 20.0), time_s, random, load_nm=load)
    base = fit([Term(built_in()["graduation_harmonics"](), {})], observations_of(made))
    assert best_form(Residuals(base)) is None
