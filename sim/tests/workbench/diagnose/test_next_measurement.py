"""Tests that the measurement that a diagnosis requests separates the effects of the class once its
simulated rows are added to the set; tests of the rows and kinds of such measurements."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import measurement_set

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.simulate.experiment import EXPERIMENTS, FURTHER, full, lean, with_further
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.table.registry import RECIPES
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.next_measurement import OF_PARTS, measurement_for_parts
from arctrue.workbench.diagnose.planned import PLANS, PlannedMeasurement
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.part_conditions import ALWAYS, SIMPLE_CONDITIONS, settling_condition
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.model.growth import add_effect, as_stored
from arctrue.workbench.model.model import Model, default_model
from arctrue.workbench.observations.build import observations_of

SAMPLES, CYCLES = 1500, 5
EFFECTS = built_in()


def asked(
    name: str,
    experiment: str,
    share: float,
    seed: int,
    samples: int = SAMPLES,
    verdict: str = "ambiguous",
) -> tuple[Diagnosis, Diagnosis]:
    """Return the diagnosis of a set, and the diagnosis after the requested measurement was added.

    ``share`` sets the size of the hidden effect: its position within the range of sizes, on a
    logarithmic scale.
    """
    size = RECIPES[name].low ** (1 - share) * RECIPES[name].high ** share
    planned = EXPERIMENTS[experiment]().smaller(samples, CYCLES)

    def found(*further: str) -> Diagnosis:
        wanted = [Wanted(name, size)]
        scatter = seed % 2
        made = simulate_set(wanted, planned, seed, index_scatter_counts=scatter, further=further)
        return diagnosed(made.measurement)[1]

    first = found()
    assert first.verdict == verdict
    assert first.next_measurement_kind is not None
    return first, found(first.next_measurement_kind)


@pytest.mark.large
@pytest.mark.parametrize(
    ("name", "experiment", "share", "seed", "rival", "kind"),
    [
        # In a single run, a head angle and a skew are both constants, and a line may be fixed to
        # time or to angle.
        ("head_angle_error", "lean", 0.5, 3, "timing_skew", "speed"),
        ("timing_skew", "lean", 0.8, 3, "head_angle_error", "speed"),
        ("bearing_ball_pass", "lean", 0.5, 3, "vibration", "speed"),
        # At 24 faces, 90 teeth look like order 6; stations between the faces separate the two. The
        # seed was selected because it draws 90 teeth and a small wobble of the pitch.
        ("drive_gear_error", "full", 0.15, 58, "radial_error_motion", "polygon_turned"),
    ],
)
def test_next_measurement_splits_the_pair(
    name: str, experiment: str, share: float, seed: int, rival: str, kind: str
) -> None:
    first, after = asked(name, experiment, share, seed)
    assert {name, rival} <= set(first.effect_class)
    assert first.next_measurement_kind == kind
    assert after.named is not None
    assert after.named.name == name


@pytest.mark.large
def test_one_line_asks_for_another_speed_though_it_has_no_rival() -> None:
    first, after = asked("vibration", "lean", 0.5, 3)
    assert first.effect_class == ["vibration"]
    assert first.next_measurement_kind == "speed"
    assert after.named is not None
    assert after.named.name == "vibration"


@pytest.mark.large
def test_a_half_order_of_one_run_is_no_line_of_any_frequency() -> None:
    """The diagnosis names no vibration for a half-integer order of one run: only one vibration in
    thousands would be within a thousandth of such an order. The diagnosis still requests another
    speed."""
    first, after = asked("half_order", "lean", 0.5, 20_093, 6000, "unknown")
    assert first.effect_class == []
    assert first.probability["vibration"] < 0.05
    assert first.described is not None
    assert list(first.described.effect.parts) == ["order:2.5", "stator"]  # type: ignore[attr-defined]
    assert first.next_measurement_kind == "speed"
    assert after.verdict == "unknown"


def _reference_chi_square(model: Model, measurement: MeasurementSet) -> float:
    residuals = Residuals(as_stored(model, observations_of(measurement), EFFECTS))
    values = residuals.reference_arcsec
    assert values is not None
    return float(values @ values) / 0.15**2


@pytest.mark.parametrize(
    ("hidden", "size", "moves"),
    [
        ("polygon_eccentricity", 0.5, True),
        pytest.param("autocollimator_gain", 0.45, False, marks=pytest.mark.large),
    ],
)
def test_a_polygon_put_on_again_tells_its_own_error_from_a_gain(
    hidden: str, size: float, moves: bool
) -> None:
    """A polygon that is turned on the table separates its own error from a gain: an eccentric
    polygon looks like a gain of the reference if its eccentricity has the direction of the disc's
    eccentricity."""
    wanted, planned = [Wanted(hidden, size)], full().smaller(SAMPLES, CYCLES)
    first = simulate_set(wanted, planned, 418).measurement
    again = simulate_set(wanted, planned, 418, again=1, further=["polygon_reindexed"]).measurement
    for name in ("polygon_eccentricity", "autocollimator_gain"):
        model, _ = add_effect(default_model(), name, {}, observations_of(first), EFFECTS, "first")
        left = [_reference_chi_square(model, item) for item in (first, again)]
        # The mean of χ² with 240 rows is 240 ± 22; the model was fitted to the noise of the other
        # set, which adds 24.
        assert left[0] == pytest.approx(48 * CYCLES, abs=90)
        if moves:
            # The eccentricity has moved by 90°, which causes 0.5″ RMS in 240 rows of 0.15″.
            assert left[1] > 48 * CYCLES + 1000
        else:
            assert left[1] == pytest.approx(48 * CYCLES, abs=120)


def _cooled() -> PlannedMeasurement:
    """Return the plan of one more run at the temperature of the first run."""
    return next(plan for plan in PLANS if "back at the temperature" in plan.words)


def test_a_temperature_that_rises_with_the_time_goes_on_rising_unless_it_is_asked_to_fall() -> None:
    """The table warms by 2 K in 104 s. A run that begins 600 s later is 12 K warmer, and only a
    table that is back at its first temperature separates the temperature from the time."""
    made = measurement_set(runs=1, turns=4)
    assert made.capture is not None
    since = made.capture.time_s - made.capture.time_s[0]
    warm = replace(made.capture, temperature_c=20.0 + 2.0 * since / since[-1])
    observations = observations_of(replace(made, capture=warm))
    again = next(plan for plan in PLANS if plan.kind == "speed").with_it(observations)
    cooled = _cooled().with_it(observations)
    assert again is not None
    assert again.capture is not None
    assert cooled is not None
    assert cooled.capture is not None
    end = float(since[-1])
    # The planned rows begin 600 s after the last row.
    assert again.capture.temperature_c is not None
    start = float(again.capture.temperature_c[again.capture.run == 1][0])
    assert start == pytest.approx(20.0 + 2.0 * (end + 600.0) / end, abs=0.01)
    assert cooled.capture.temperature_c is not None
    assert cooled.capture.temperature_c[-1] == pytest.approx(21.0, abs=0.01)


def _warming_stations(seed: int = 1, *, even: bool = True) -> MeasurementSet:
    """Return 24 stations up and down, three cycles, whose zero follows a temperature that rises by
    4 K, evenly with the time or with swings."""
    random = np.random.default_rng(seed)
    up = np.arange(24) * 15.0
    target = np.tile(np.concatenate([up, up[::-1]]), 3)
    time_s = 5.0 * np.arange(target.size)
    share = time_s / time_s[-1]
    warm = 20.0 + 4.0 * (share if even else 0.5 - 0.5 * np.cos(9.0 * share))
    error = 5.0 * np.cos(np.radians(target + 40.0)) + 0.8 * (warm - 20.0)
    reference = Reference(
        target,
        error + random.normal(0.0, 0.3, target.size),
        time_s=time_s,
        cycle=np.repeat(np.arange(3), 48),
        direction=np.tile(np.repeat([1, -1], 24), 3),
        temperature_c=warm,
    )
    return MeasurementSet(Table(), None, reference, title="stations")


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_an_even_temperature_must_be_held_or_return_to_separate_it_from_the_time(seed: int) -> None:
    """A second speed or direction does not separate temperature and time, because nothing stops the
    temperature from rising on."""
    found = diagnosed(_warming_stations(seed))[1]
    assert found.verdict == "ambiguous"
    assert found.effect_class[0] == "reference_drift"
    assert found.described is not None
    assert found.next_measurement is not None
    assert found.next_measurement.startswith("the same reference run once more, with the temp")
    # 0.8″/K × 4 K over the 715 s of the record.
    said = " ".join(sentences(found))
    rate = float(said.split("rate ")[1].split("″/h")[0])
    assert rate == pytest.approx(0.8 * 4.0 * 3600.0 / 715.0, abs=1.0)


@pytest.mark.parametrize("kind", ["moving_reference", "polygon_turned"])
def test_a_planned_reference_goes_on_warming(kind: str) -> None:
    """In the planned rows the temperature rises on by 4 K in 715 s; they begin at least 600 s after
    the last row of the set."""
    made = _warming_stations()
    if kind == "polygon_turned":
        assert made.reference is not None
        made = replace(made, reference=replace(made.reference, faces=24))
    there = next(plan for plan in PLANS if plan.kind == kind).with_it(observations_of(made))
    assert there is not None
    assert there.reference is not None
    assert there.reference.time_s is not None
    assert there.reference.temperature_c is not None
    expected = 20.0 + 4.0 / 715.0 * (there.reference.time_s - there.reference.time_s[0])
    np.testing.assert_allclose(there.reference.temperature_c, expected, atol=1e-6)
    assert float(there.reference.temperature_c[-1]) > 24.0 + 4.0 / 715.0 * 600.0


def test_a_reference_that_need_not_cool_has_no_plan_for_it() -> None:
    cooled = next(plan for plan in PLANS if plan.kind is None)
    assert cooled.with_it(observations_of(_warming_stations(even=False))) is None
    assert cooled.with_it(observations_of(_warming_stations())) is not None


def test_a_temperature_that_does_not_rise_with_the_time_need_not_fall() -> None:
    assert _cooled().with_it(observations_of(measurement_set())) is None


def test_every_kind_that_is_asked_for_can_be_simulated() -> None:
    asked = {plan.kind for plan in PLANS if plan.kind is not None} | {
        kind for kind, _ in OF_PARTS.values()
    }
    assert asked - {"reference_back"} <= set(FURTHER)
    assert all(kind in FURTHER for kind in ("polygon_reindexed", "turns", "samples"))


@pytest.mark.parametrize(
    "plan",
    # The simulator always measures in both directions, and its temperature does not rise evenly
    # with the time, so that it cannot make three of the plans.
    [plan for plan in PLANS if plan.kind not in (None, "reference_back") and plan is not _cooled()],
    ids=lambda plan: plan.kind,
)
def test_planned_rows_are_like_those_that_the_simulator_measures(plan) -> None:  # type: ignore[no-untyped-def]
    planned = lean() if plan.kind == "reference" else full()
    before = planned.smaller(SAMPLES, 2)
    made = simulate_set([], before, 5).measurement
    rows = plan.with_it(observations_of(made))
    assert rows is not None
    measured = observations_of(simulate_set([], with_further(before, plan.kind), 5).measurement)
    if plan.kind in ("reference", "polygon_turned", "moving_reference"):
        found, expected = rows.reference, measured.reference
        assert found is not None
        assert expected is not None
        assert set(found.direction) == set(expected.direction)
        new = found.target_rad[-200:] % 0.2618
        assert new.max() == pytest.approx((expected.target_rad[-200:] % 0.2618).max(), abs=0.02)
        return
    found, expected = rows.capture, measured.capture
    assert found is not None
    assert expected is not None
    assert found.runs == expected.runs == 5
    assert found.speed_rad_s[-1] == pytest.approx(expected.speed_rad_s[-1], rel=1e-3)
    assert found.direction[-1] == expected.direction[-1]
    assert found.temperature_c[-1] == pytest.approx(expected.temperature_c[-1], abs=0.5)
    turns = [
        abs(item.angle_rad[-1] - item.angle_rad[item.run == 4][0]) for item in (found, expected)
    ]
    assert turns[0] == pytest.approx(turns[1], rel=0.01)


@pytest.mark.parametrize("condition", [*SIMPLE_CONDITIONS, settling_condition(5.0, True)])
def test_every_condition_has_a_measurement_of_its_own(condition) -> None:  # type: ignore[no-untyped-def]
    # The set has one run at one speed and one temperature.
    bare = observations_of(measurement_set(runs=1, turns=1, reference=False))
    asked = measurement_for_parts(ProductOfParts.of(condition, (2.0,), "disc"), bare)
    assert asked.kind == OF_PARTS[condition.part][0]


def test_a_wave_without_condition_asks_for_what_moves_its_frame() -> None:
    always, faces = ALWAYS, observations_of(measurement_set(runs=1, turns=1, cycles=1))
    kinds = [
        measurement_for_parts(ProductOfParts.of(always, orders, frame), faces).kind  # type: ignore[arg-type]
        for orders, frame in (((0.5,), "stator"), ((3.0,), "reference"), ((3.0,), "disc"))
    ]
    assert kinds == ["turns", "polygon_reindexed", None]
