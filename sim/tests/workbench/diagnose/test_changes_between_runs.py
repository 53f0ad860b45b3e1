"""Tests that an order that changes once, between two runs, is no growth with time."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.adopted import adopt
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in, catalogue
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.observations.build import observations_of
from tests.workbench.base_diagnosis import diagnosis_of

Float = NDArray[np.float64]
STATIONS, RUNS, NOISE = 36, 6, 0.15


def _with_order_1(factor: Callable[[NDArray[np.int64], Float], Float], seed: int) -> Diagnosis:
    """Diagnose runs up and down over 36 stations, numbered from 1, with 3″ of order 1 times a
    factor of run and time."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(1, RUNS + 1), STATIONS)
    up = np.arange(STATIONS) * 360.0 / STATIONS
    target = np.concatenate([up if number % 2 == 0 else up[::-1] for number in range(RUNS)])
    angle = np.radians(target)
    time_s = 5.0 * np.arange(run.size) + 30.0 * run
    disc = 5.0 * np.cos(angle + 0.3) + np.cos(2.0 * angle)
    error = disc + 3.0 * factor(run, time_s / time_s[-1]) * np.cos(angle - 2.0)
    reference = Reference(
        target,
        error + random.normal(0.0, NOISE, run.size),
        run=run,
        time_s=time_s,
        direction=np.where(run % 2 == 1, 1, -1),
    )
    return diagnosis_of(MeasurementSet(Table(), None, reference))


@pytest.mark.large
@pytest.mark.parametrize("first", [3, 4, 5])
def test_a_reference_that_was_clamped_again_between_two_runs(first: int, tmp_path: Path) -> None:
    """The amplitude of a difference of two means of at least 72 readings of 0.15″ has
    u = 0.15″ · √2 · √(1/72 + 1/144) = 0.03″."""
    found = _with_order_1(lambda run, _: (run >= first).astype(np.float64), seed=first)
    assert found.verdict == "unknown"
    assert found.described is not None
    effect = found.described.effect
    assert isinstance(effect, ProductOfParts)
    assert effect.parts == ["run", "order:1", "reference"]
    size = found.described.parameters()["amplitude"].value
    assert size == pytest.approx(3.0, abs=0.12)
    assert found.description == (
        f"order 1 changes by {size:.2g}″ between two runs, at the start of run {first}, "
        "reference only"
    )
    assert "the stand, the mounts" in (found.next_measurement or "")
    adopt(effect, "clamped_again", found.description, tmp_path)
    again = catalogue([tmp_path])["clamped_again"]()
    assert isinstance(again, ProductOfParts)
    assert again.condition.from_run == first


@pytest.mark.parametrize("runs", [40, 41])
def test_runs_that_are_too_many_are_stated(runs: int) -> None:
    """The diagnosis searches changes between at most 40 runs; for more runs it states that it did
    not search."""
    random = np.random.default_rng(runs)
    target = np.tile(np.arange(12) * 30.0, runs)
    error = 5.0 * np.cos(np.radians(target)) + random.normal(0.0, NOISE, target.size)
    reference = Reference(target, error, run=np.repeat(np.arange(runs), 12))
    said = " ".join(sentences(diagnosis_of(MeasurementSet(Table(), None, reference))))
    words = "did not search for an order that changes between two runs: the reference has 41 runs"
    assert (words in said) == (runs == 41)


@pytest.mark.parametrize("seed", [pytest.param(1, marks=pytest.mark.large), 2])
def test_a_growth_with_time_is_no_change_between_two_runs(seed: int) -> None:
    found = _with_order_1(lambda _, time: time, seed)
    assert found.described is not None
    assert found.described.effect.parts == ["time", "order:1", "reference"]


def test_an_order_that_follows_the_direction_is_no_change_between_two_runs() -> None:
    found = _with_order_1(lambda run, _: np.where(run % 2 == 1, 1.0, -1.0), seed=1)
    assert found.described is not None
    assert found.described.effect.parts == ["direction", "order:1", "reference"]


@pytest.mark.parametrize("seed", [1, 2])
def test_white_noise_has_no_change_between_two_runs(seed: int) -> None:
    found = _with_order_1(lambda run, _: np.zeros(run.size), seed)
    assert found.described is None
    assert found.effect_class == []


@pytest.mark.parametrize("seed", [1019, 1020])
def test_zeros_of_the_runs_are_no_product_of_parts(seed: int) -> None:
    """The zeros of six runs scatter by 1″. Order 24 is constant at 24 stations, and one of 34
    products follows the six zeros by chance: the diagnosis must not describe the zeros by such a
    product."""
    random = np.random.default_rng(seed)
    run = np.repeat(np.arange(RUNS), 24)
    up = np.arange(24) * 15.0
    target = np.concatenate([up if number % 2 == 0 else up[::-1] for number in range(RUNS)])
    if seed % 2:
        load = random.choice([0.0, 10.0, 20.0], RUNS)[run]
    else:
        load = np.round(10.0 + 5.0 * random.normal(size=RUNS), 1)[run]
    error = 5.0 * np.cos(np.radians(target)) + 1.5 * np.sin(np.radians(2.0 * target))
    error = error + random.normal(0.0, NOISE, run.size) + random.normal(0.0, 1.0, RUNS)[run]
    reference = Reference(
        target,
        error,
        run=run,
        time_s=5.0 * np.arange(run.size) + 35.0 * run,
        direction=1 - 2 * (run % 2),
        conditions={"load_nm": load},
    )
    found = diagnosis_of(MeasurementSet(Table(), None, reference))
    assert found.described is None
    assert found.effect_class == []


def test_one_change_between_runs_is_listed_for_an_order() -> None:
    """A change at the start of run 15 of 30 gains 300; a change some runs earlier gains
    less, and is no second description."""
    random = np.random.default_rng(1)
    run = np.repeat(np.arange(30), 72)
    target = np.tile(np.arange(72) * 5.0, 30)
    angle = np.radians(target)
    error = 5.0 * np.cos(angle) + 2.0 * (run >= 15) * np.cos(2.0 * angle + 1.0)
    reference = Reference(
        target,
        error + random.normal(0.0, 0.3, run.size),
        run=run,
        time_s=5.0 * np.arange(run.size) + 30.0 * run,
    )
    observations = observations_of(MeasurementSet(Table(), None, reference))
    graduation = Term(built_in()["graduation_harmonics"](), {})
    found = best_parts(Residuals(fit([graduation], observations)))
    changes = [item.effect.condition.from_run for item in found if "order:2" in item.effect.parts]
    assert [first for first in changes if first is not None] == [15]
