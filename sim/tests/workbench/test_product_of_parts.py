"""Tests that a product of parts (condition times wave) works like any other effect, and that its
settings define it completely, also in a model file."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.effects.part_conditions import (
    ALWAYS,
    CONDITIONS,
    TEMPERATURE,
    Condition,
    column_condition,
    settling_condition,
)
from arctrue.workbench.effects.product_of_parts import Frame, ProductOfParts
from arctrue.workbench.effects.registry import ORDER, absent_effects, catalogue
from arctrue.workbench.model.growth import AlreadyThereError, add_effect
from arctrue.workbench.model.model import default_model
from arctrue.workbench.model.model_file import read_model, write_model
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set

CONTEXT = FitContext()


@pytest.fixture(scope="module")
def observations() -> Observations:
    return observations_of(measurement_set())


@pytest.mark.parametrize(
    ("condition", "orders", "frame", "head"),
    [
        *((condition, (2.0, 3.5), "disc", None) for condition in CONDITIONS.values()),
        (settling_condition(5.0, True), (1.0,), "stator", None),
        (settling_condition(90.0, False), (), "head2", None),
        (column_condition("load_nm", 2.5), (4.0,), "reference", None),
        (TEMPERATURE, (1.0, 2.0), "head1", 1),
    ],
)
def test_settings_say_the_same_product(
    condition: Condition,
    orders: tuple[float, ...],
    frame: Frame,
    head: int | None,
    observations: Observations,
) -> None:
    made = ProductOfParts.of(condition, orders, frame, head)
    again = ProductOfParts(**made.settings)
    assert again.settings == made.settings
    assert (again.parts, again.describe({})) == (made.parts, made.describe({}))
    rows = observations.capture
    assert rows is not None
    ours, theirs = (one.capture_columns(rows, {}, CONTEXT) for one in (made, again))
    assert (ours is None) == (theirs is None)
    if ours is not None and theirs is not None:
        np.testing.assert_array_equal(ours, theirs)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"condition": "warmth"}, "no condition 'warmth'; there are: 'temperature'"),
        ({"condition": "time", "column": "load_nm"}, "condition: expected only one of"),
        ({"orders": [0]}, "orders: expected a list of numbers above 0, found \\[0\\]"),
        ({"orders": [True]}, "orders: expected a list of numbers above 0"),
        ({"fixed_to": "axis"}, "fixed_to: expected one of disc, stator, head1"),
        ({"electrical_head": 5}, "electrical_head: expected 1 to 4"),
        ({"time_constant_s": -1.0}, "time_constant_s: expected seconds above 0"),
        ({"order": [1]}, "unknown setting order"),
    ],
)
def test_settings_that_say_none_are_refused(settings: dict[str, object], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        ProductOfParts(**settings)


def test_it_is_listed_and_nobody_looks_for_it_without_settings(observations: Observations) -> None:
    effects = catalogue()
    assert set(effects) - set(ORDER) == {"product_of_parts"}
    # The set has no angle of a second axis, so that a mount's geometry is not considered.
    expected = set(ORDER) - {"hysteresis", "pointing_geometry"}
    assert set(absent_effects(effects, ["hysteresis"], observations)) == expected


def test_two_products_stand_in_a_model_file(tmp_path: Path, observations: Observations) -> None:
    effects, path = catalogue(), tmp_path / "m.toml"
    model, first = default_model(), {"orders": [25], "fixed_to": "head2"}
    for settings in (first, {"orders": [27], "fixed_to": "head2"}):
        model, _ = add_effect(model, "product_of_parts", settings, observations, effects, "set")
        write_model(path, model)
        model = read_model(path)
    assert [len(entry.coefficients) for entry in model.effects[1:]] == [2, 2]
    assert [entry.effect(effects).parts for entry in model.effects[1:]] == [
        ["order:25", "head2"],
        ["order:27", "head2"],
    ]
    with pytest.raises(AlreadyThereError):
        add_effect(model, "product_of_parts", first, observations, effects, "set")
    assert ProductOfParts().parts == ProductOfParts.of(ALWAYS, (), "disc").parts
