"""Tests that every function that simulates a cause applies all parts of the cause, or refuses the
cause by name."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.instrument.curves import TableCurves
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.studies.simulate.experiment import Experiment, full, lean
from arctrue.studies.simulate.measured_table import MeasuredTable
from arctrue.table import Cause, Motion, RotaryTable, causes, count_edges, two_heads
from arctrue.table.cause import (
    CAPTURE,
    READING,
    RECORD,
    REFERENCE,
    SIGNALS,
    UnhonouredCauseError,
    acts_on,
)
from arctrue.table.registry import CAUSES, REGISTRY

MOTION = Motion.steady(2.0, 0.5)


def drawn(name: str) -> tuple[Cause, ...]:
    recipe = REGISTRY[name]
    return tuple(recipe.draw(recipe.low, np.random.default_rng(1), full().occasion))


def table(*effects: Cause) -> RotaryTable:
    return RotaryTable(two_heads(), effects, counts_per_rev=4096)


def edges(*effects: Cause) -> None:
    count_edges(table(*effects), 0, MOTION)


def counter(*effects: Cause) -> None:
    # Studies of a calibration method or of an error budget read these counts.
    table(*effects).counts(0, MOTION.state(np.array([0.5])))


def virtual_instrument(*effects: Cause) -> None:
    TableCurves(table(*effects), MOTION, 1e6)


def hidden_effect(*effects: Cause) -> None:
    # ``arctrue hidden`` connects its simulated table to the compiled gateware by TableCurves.
    settings = HiddenSettings.of_lines(64, 4, 400)
    TableCurves(settings.table(effects), MOTION, 1e6)


def bench(one: RotaryTable) -> MeasuredTable:
    random = np.random.default_rng(1)
    return MeasuredTable(one, reference_noise_arcsec=0.1, index_scatter_counts=0, random=random)


def measured(experiment: Experiment, *effects: Cause) -> None:
    bench(table(*effects)).measure(experiment.smaller(50, 1), title="")


def stations_only() -> Experiment:
    return Experiment("polygon", (), full().reference)


def heads_only(*effects: Cause) -> None:
    measured(lean(), *effects)


def polygon_only(*effects: Cause) -> None:
    measured(stations_only(), *effects)


def both(*effects: Cause) -> None:
    measured(full(), *effects)


CONSUMERS = {
    edges: SIGNALS,
    counter: READING,
    virtual_instrument: SIGNALS,
    hidden_effect: SIGNALS,
    heads_only: CAPTURE,
    polygon_only: REFERENCE,
    both: RECORD,
}


@pytest.mark.parametrize("consumer", CONSUMERS, ids=lambda consumer: consumer.__name__)
def test_a_consumer_takes_what_it_honours_and_refuses_the_rest(consumer) -> None:  # type: ignore[no-untyped-def]
    refused, taken = [], []
    for name, recipe in REGISTRY.items():
        kind = CAUSES[recipe.cause].kind
        if acts_on(kind) <= CONSUMERS[consumer]:
            consumer(*drawn(name))
            taken.append(name)
        else:
            with pytest.raises(UnhonouredCauseError, match=kind.__name__):
                consumer(*drawn(name))
            refused.append(name)
    assert taken
    assert refused or consumer is both


def test_all_that_a_cause_can_act_on_is_honoured_by_a_whole_set() -> None:
    assert full().honoured | {"index_variance_counts2"} == RECORD


def test_every_cause_acts_on_something_and_is_in_the_registry() -> None:
    assert all(acts_on(cause.kind) for cause in CAUSES.values())
    for recipe in REGISTRY.values():
        assert {type(effect) for effect in drawn(recipe.name)} == {CAUSES[recipe.cause].kind}
    drawn_causes = {recipe.cause for recipe in REGISTRY.values()}
    # No recipe draws these causes: the first may be in any table, the second is for long runs, and
    # the third is for a study.
    not_drawn = {"disc_eccentricity", "creeping_centre", "loose_centre"}
    assert set(CAUSES) - drawn_causes == not_drawn
    files = {file.stem for file in Path(causes.__path__[0]).glob("*.py")}
    assert files - {"__init__"} == set(CAUSES)


@pytest.mark.parametrize(
    "name", ["hysteresis", "settling_bracket", "sticking_bracket", "wearing_track", "vibration"]
)
def test_conditions_of_a_motion_and_of_stations_reach_the_cause(name: str) -> None:
    # A cause may depend on more than the angle: on the direction, the time since the start of the
    # run, the absolute time, or the travel.
    recipe = REGISTRY[name]
    effects = recipe.draw(recipe.high, np.random.default_rng(3), full().occasion)
    fine = [
        RotaryTable(two_heads(), tuple(acting), counts_per_rev=1 << 24) for acting in ((), effects)
    ]
    back = Motion((0.0, 8.0, 16.0), (1.0, -1.0, 1.0)).state(np.arange(0.0, 16.0, 0.05))
    moved = [fine[1].counts(head, back) - fine[0].counts(head, back) for head in (0, 1)]
    assert max(np.ptp(counts) for counts in moved) >= 4
    if name in ("hysteresis", "wearing_track"):
        without, with_it = (bench(one).measure(stations_only(), title="") for one in fine)
        off = with_it.exact_arcsec["reference"] - without.exact_arcsec["reference"]
        # In each of the two readings, rounding can hide one count of 0.08″; the difference exceeds
        # these two counts.
        assert np.ptp(off) > 0.16


def test_the_module_names_every_method_of_a_cause() -> None:
    assert CAPTURE | REFERENCE | {"index_variance_counts2"} == RECORD
