"""Tests of whole simulated sets: the effect of a cause in each channel, the noise floor, seeds and
refusals."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, read_measurement_set, write_measurement_set
from arctrue.studies.simulate.experiment import (
    EXPERIMENTS,
    CaptureRun,
    Experiment,
    full,
    lean,
)
from arctrue.studies.simulate.measured_table import MeasuredTable
from arctrue.studies.simulate.simulated_set import LARGEST_SIZE, Wanted, simulate_set
from arctrue.table import RotaryTable, two_heads
from arctrue.table.cause import UnhonouredCauseError
from arctrue.table.causes.shaft_wind_up import ShaftWindUp
from arctrue.table.registry import NOISES, RECIPES, REGISTRY, STRANGERS

Float = NDArray[np.float64]
COUNT_ARCSEC = 1_296_000 / (1 << 24)
ALPHA_COUNTS = 33 / 360 * (1 << 24)
QUIET = {"noise_arcsec": 0.0, "reference_noise_arcsec": 0.0, "index_scatter_counts": 0}
SMALL = full().smaller(600, 2)


@pytest.mark.parametrize("name", REGISTRY)
def test_no_size_gives_a_set_that_cannot_be_read(name: str, tmp_path: Path) -> None:
    def simulated(size: float) -> MeasurementSet:
        wanted = [Wanted(name, size)]
        noise = name in NOISES
        causes, noises = ([], wanted) if noise else (wanted, [])
        return simulate_set(causes, EXPERIMENTS["short"](), 3, noise=noises).measurement

    with pytest.raises(ValueError, match=f"the size of {name} must be at most"):
        simulated(1e99)
    try:
        largest = simulated(LARGEST_SIZE * REGISTRY[name].high)
    except ValueError:
        return  # the cause refuses this size with a message of its own
    write_measurement_set(tmp_path, largest)
    again = read_measurement_set(tmp_path)
    assert again.capture is not None
    assert largest.capture is not None
    np.testing.assert_array_equal(again.capture.run, largest.capture.run)


def difference_arcsec(measurement: MeasurementSet) -> Float:
    capture = measurement.capture
    assert capture is not None
    counts = capture.head2_counts - capture.head1_counts - ALPHA_COUNTS
    return np.asarray(counts * COUNT_ARCSEC)


def reference_arcsec(measurement: MeasurementSet) -> Float:
    assert measurement.reference is not None
    return measurement.reference.error_arcsec


def both(name: str, size: float, seed: int = 5) -> tuple[MeasurementSet, MeasurementSet]:
    """Return a set with a cause and the set without this cause."""
    with_it = simulate_set([Wanted(name, size)], SMALL, seed, **QUIET)  # type: ignore[arg-type]
    without = simulate_set([], SMALL, seed, **QUIET)  # type: ignore[arg-type]
    return with_it.measurement, without.measurement


def test_full_experiment_has_both_directions_three_speeds_and_heat() -> None:
    made = simulate_set([], full(), 1).measurement
    capture = made.capture
    assert capture is not None
    assert capture.temperature_c is not None
    assert capture.run.size == 72_000
    turns = []
    for run in range(4):
        inside = capture.run == run
        counts, times = capture.head1_counts[inside], capture.time_s[inside]
        turns.append((counts[-1] - counts[0]) / (1 << 24))
        assert np.all(np.diff(times) > 0)
        assert turns[-1] * 2 * np.pi / (times[-1] - times[0]) == pytest.approx(
            2 * np.pi / 12 * (1, -1, 3, 1)[run], rel=1e-4
        )
    np.testing.assert_allclose(np.abs(turns), 3, atol=1e-3)
    assert capture.temperature_c[0] == 20.0
    assert (capture.temperature_c[-18_000], capture.temperature_c[-1]) == (23.5, 24.5)
    reference = made.reference
    assert reference is not None
    assert reference.target_deg.size == 480
    assert reference.cycle is not None
    assert reference.cycle.max() == 9


def test_lean_experiment_is_one_run() -> None:
    made = simulate_set([], lean(), 1).measurement
    assert made.reference is None
    assert made.capture is not None
    assert np.all(made.capture.run == 0)


def test_the_same_seed_gives_the_same_set_and_another_another() -> None:
    first, again, other = (simulate_set([Wanted("vibration")], SMALL, seed) for seed in (3, 3, 4))
    np.testing.assert_array_equal(
        difference_arcsec(first.measurement), difference_arcsec(again.measurement)
    )
    assert first.truth == again.truth
    assert first.truth["effects"][0]["size"] != other.truth["effects"][0]["size"]


def test_a_cause_does_not_move_the_table_or_the_noise() -> None:
    with_it = simulate_set([Wanted("count_slip", 4)], SMALL, 9)
    without = simulate_set([], SMALL, 9)
    assert with_it.truth["table"] == without.truth["table"]
    change = difference_arcsec(with_it.measurement) - difference_arcsec(without.measurement)
    assert set(np.round(np.abs(change) / COUNT_ARCSEC)) == {0.0, 4.0}


def test_floor_is_noise_and_rounding() -> None:
    truth = simulate_set([Wanted("subdivision_error", 2.0)], full(), 2).truth
    # Each of the two heads has 0.1″ of noise and a rounding to one count.
    expected = np.sqrt(2 * (0.1**2 + COUNT_ARCSEC**2 / 12))
    assert truth["floor_arcsec"]["capture"] == pytest.approx(expected, rel=0.01)
    assert truth["floor_arcsec"]["reference"] == pytest.approx(0.15, rel=0.12)


def test_the_servo_brings_the_reading_to_the_target() -> None:
    made = simulate_set([Wanted("subdivision_error", 2.4)], SMALL, 2, **QUIET)  # type: ignore[arg-type]
    reference = made.measurement.reference
    assert reference is not None
    assert reference.head1_counts is not None
    target = reference.target_deg / 360 * (1 << 24)
    # A reading is rounded down to a whole count; the solver adds 1e-6 of a count.
    below = target - reference.head1_counts
    assert np.all((below > -1e-6) & (below < 1 + 1e-6))


def test_hysteresis_is_in_the_reference_only() -> None:
    with_it, without = both("hysteresis", 1.0)
    change = reference_arcsec(with_it) - reference_arcsec(without)
    assert with_it.reference is not None
    assert with_it.reference.direction is not None
    # At the displaced angle the graduation error differs by its slope times the displacement: 6e-4
    # of 0.5″.
    np.testing.assert_allclose(np.abs(change), 0.5, atol=1e-3)
    assert np.all(np.sign(change) == np.sign(change[0]) * with_it.reference.direction)
    moved = difference_arcsec(with_it) - difference_arcsec(without)
    assert np.abs(moved).max() <= 2 * COUNT_ARCSEC


@pytest.mark.parametrize(
    ("name", "size"),
    [("polygon_face_error", 0.5), ("polygon_eccentricity", 0.5), ("reference_drift", 3.0)],
)
def test_errors_of_the_instrument_leave_the_capture_alone(name: str, size: float) -> None:
    with_it, without = both(name, size)
    np.testing.assert_array_equal(difference_arcsec(with_it), difference_arcsec(without))
    assert np.std(reference_arcsec(with_it) - reference_arcsec(without)) > 0.01


def test_autocollimator_error_follows_what_it_shows() -> None:
    with_it, without = both("autocollimator_gain", 1.0)
    ratio = reference_arcsec(with_it) / reference_arcsec(without)
    np.testing.assert_allclose(np.abs(ratio - 1), 0.01, rtol=1e-9)


def test_skew_follows_the_signed_speed() -> None:
    with_it, without = both("timing_skew", 20.0)
    change = difference_arcsec(with_it) - difference_arcsec(without)
    speed_arcsec_s = np.array([1, -1, 3, 1]) * 360 * 3600 / 12
    expected = 20e-6 * speed_arcsec_s
    capture = with_it.capture
    assert capture is not None
    found = np.array([change[capture.run == run].mean() for run in range(4)])
    sign = np.sign(found[0])
    # The tolerance covers the rounding of 600 readings to counts, and the error's slope of 6e-4.
    np.testing.assert_allclose(sign * found, expected, atol=0.02)


def test_latency_is_seen_on_the_move_only() -> None:
    with_it, without = both("latency", 50.0)
    moved = difference_arcsec(with_it) - difference_arcsec(without)
    assert np.abs(moved).max() <= 2 * COUNT_ARCSEC
    reference = with_it.reference
    assert reference is not None
    assert reference.run is not None
    standing = int(np.count_nonzero(reference.run == 0))
    change = reference_arcsec(with_it)[:standing] - reference_arcsec(without)
    np.testing.assert_allclose(change, 0, atol=1e-6)
    mean = [reference_arcsec(with_it)[reference.run == run].mean() for run in (1, 2)]
    # The error is −τ·ω in the forward run and +τ·ω in the backward run.
    assert mean[1] - mean[0] == pytest.approx(2 * 50e-6 * 360 * 3600 / 12, abs=0.1)


@pytest.mark.parametrize("name", list(RECIPES))
@pytest.mark.parametrize("experiment", list(EXPERIMENTS))
def test_every_recipe_can_be_measured(name: str, experiment: str) -> None:
    planned = EXPERIMENTS[experiment]().smaller(120, 1)
    recipe = RECIPES[name]
    if not planned.can_honour(recipe):
        # A set without a reference run cannot hide a cause that only the reference shows.
        assert planned.reference is None
        with pytest.raises(UnhonouredCauseError, match=f"experiment {experiment} cannot honour"):
            simulate_set([Wanted(name)], planned, 11)
        return
    made = simulate_set([Wanted(name)], planned, 11)
    assert recipe.low <= made.truth["effects"][0]["size"] <= recipe.high
    assert made.truth["hidden"] == name
    assert made.truth["effects"][0]["causes"]


def test_gear_tells_its_teeth() -> None:
    made = simulate_set([Wanted("drive_gear_error", 1.0)], SMALL, 3)
    teeth = made.measurement.table.drive_gear_teeth
    assert teeth is not None
    assert simulate_set([], SMALL, 3).measurement.table.drive_gear_teeth is None


def test_refusals_are_clear() -> None:
    with pytest.raises(ValueError, match="no cause is called friction"):
        simulate_set([Wanted("friction")], SMALL, 1)
    with pytest.raises(ValueError, match="must be positive, found -1"):
        simulate_set([Wanted("vibration", -1.0)], SMALL, 1)


def test_a_noise_more_leaves_everything_else_as_it_was() -> None:
    plain = simulate_set([Wanted("vibration", 0.5)], SMALL, 6)
    noisy = simulate_set([Wanted("vibration", 0.5)], SMALL, 6, noise=[Wanted("pink", 0.2)])
    before, after = plain.measurement.capture, noisy.measurement.capture
    assert before is not None
    assert after is not None
    off_counts = (after.head2_counts - after.head1_counts) - (
        before.head2_counts - before.head1_counts
    )
    # 0.2" of noise per head, at 0.077" per count, are 3.7 counts in the difference; their slow part
    # is constant during a run.
    assert 1.5 < off_counts.std() < 5.0
    for channel, exact in plain.exact_arcsec.items():
        np.testing.assert_array_equal(exact, noisy.exact_arcsec[channel])
    assert noisy.truth["noise"][0]["size"] == 0.2
    assert (
        noisy.noise["capture"].gaussian.sigma_rad.size
        > plain.noise["capture"].gaussian.sigma_rad.size
    )


def test_lagging_sensor_gaps_and_outliers_are_in_the_set() -> None:
    made = simulate_set(
        [], SMALL, 7, noise=[Wanted("sensor_lag", 5), Wanted("gaps", 10), Wanted("outliers", 1)]
    )
    capture = made.measurement.capture
    assert capture is not None
    assert capture.temperature_c is not None
    true_c = SMALL.temperature.at(capture.time_s)
    assert np.abs(true_c - capture.temperature_c).max() > 0.3
    rows = sum(run.samples for run in SMALL.runs)
    assert 0.85 * rows < capture.run.size < 0.95 * rows
    assert (
        capture.run.size == made.exact_arcsec["capture"].size == made.noise["capture"].struck.size
    )
    struck = made.noise["capture"].struck
    assert 0.005 < struck.mean() < 0.04
    assert made.truth["floor_arcsec"]["capture"] < 0.2


@pytest.mark.parametrize("name", list(STRANGERS))
def test_strangers_are_drawn_and_seen(name: str) -> None:
    with_it = simulate_set([Wanted(name, STRANGERS[name].high)], SMALL, 5)
    without = simulate_set([], SMALL, 5)
    seen = with_it.exact_arcsec["capture"] - without.exact_arcsec["capture"]
    assert seen.std() > 0.02
    assert with_it.truth["effects"][0]["kind"] == "stranger"


def test_noise_that_is_none_is_an_error() -> None:
    with pytest.raises(ValueError, match=r"no cause is called latency\. There are: white"):
        simulate_set([], SMALL, 1, noise=[Wanted("latency")])


def test_a_run_with_a_pause_and_a_reversal() -> None:
    # The table goes forward, pauses, and goes backward. The shaft keeps its wind-up during the
    # pause and changes to the other side after the reversal.
    profile = ((0.0, 0.5), (4.0, 0.5), (5.0, 0.0), (7.0, 0.0), (8.0, -0.5), (12.0, -0.5))
    run = CaptureRun(0.0, 12.0, 0.5, 1200, profile=profile)
    heads = []
    for causes in ((), (ShaftWindUp(1e-4, 0.05),)):
        table = RotaryTable(two_heads(), causes)
        bench = MeasuredTable(
            table,
            reference_noise_arcsec=0.1,
            index_scatter_counts=0,
            random=np.random.default_rng(1),
        )
        capture = bench.measure(Experiment("there and back", (run,), None), title="").measurement
        assert capture.capture is not None
        heads.append(capture.capture.head1_counts)
    turned_rad = (heads[1] - heads[0]) * table.count_rad
    # The run starts as if the table had just reversed. 2 rad are 40 strokes; each stroke reduces
    # the remaining wind-up by the factor 1/e, from 2 at the reversal.
    assert turned_rad[[0, 400, 600, 700]] == pytest.approx([-1e-4, 1e-4, 1e-4, 1e-4], abs=4e-7)
    assert turned_rad[-1] == pytest.approx(-1e-4, abs=4e-7)
    stroke = round((7.0 + np.sqrt(2 * 0.05 / 0.5)) * 100)
    gone = 0.25 * (stroke / 100 - 7.0) ** 2
    assert turned_rad[stroke] == pytest.approx(-1e-4 * (1 - 2 * np.exp(-gone / 0.05)), abs=4e-7)
    steps = np.diff(heads[0])
    assert (steps[:400] > 0).all()
    assert (steps[520:690] == 0).all()
    assert (steps[-400:] < 0).all()
