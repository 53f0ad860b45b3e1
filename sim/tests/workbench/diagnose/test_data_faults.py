"""Tests that the diagnosis reports faults of the record with their row, and not as effects of the
table."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import COUNTS_PER_REV, SAMPLES_A_TURN, measurement_set

from arctrue.calibration.head_separation import doubts_of
from arctrue.measurement import Capture, MeasurementSet
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.simulate.experiment import full
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.workbench.diagnose.data_faults import cut_runs, data_faults, too_short
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.outliers.excursions import excursions, step_scatter

ROW = 5_000
"""A row in run 1; the set has four runs of 3,600 samples."""


def _copied() -> tuple[MeasurementSet, Capture]:
    made = measurement_set()
    assert made.capture is not None
    fields = {
        name: value.copy()
        for name, value in vars(made.capture).items()
        if isinstance(value, np.ndarray)
    }
    return made, replace(made.capture, **fields)


def _faults(made: MeasurementSet, capture: Capture) -> list[str]:
    return data_faults(observations_of(replace(made, capture=capture)))


def test_a_good_set_has_none() -> None:
    assert data_faults(observations_of(measurement_set())) == []


@pytest.mark.parametrize("rows", [1, 2, 3])
@pytest.mark.parametrize("head", [1, 2])
def test_a_head_that_is_off_and_back_at_once_is_masked_and_reported(head: int, rows: int) -> None:
    made, capture = _copied()
    counts = capture.head1_counts if head == 1 else capture.head2_counts
    counts[ROW : ROW + rows] += 3_000
    seen = observations_of(replace(made, capture=capture))
    assert [item.row for item in seen.masked] == list(range(ROW + 2, ROW + 2 + rows))
    sign = -1.0 if head == 1 else 1.0
    for item in seen.masked:
        # The row is off by 3,000 counts, to within the noise and the slope of the error over three
        # rows.
        assert item.away_arcsec == pytest.approx(sign * 3_000 * 0.0772, abs=3.0)
        assert str(item).startswith(f"capture.csv, row {item.row}: outlier (")
    assert data_faults(seen) == []


def test_a_slip_stays_and_is_an_effect() -> None:
    """The diagnosis reports a slip of any size as an effect: from one instant on the counter is
    wrong by a constant, as in count_slip."""
    made, capture = _copied()
    capture.head2_counts[ROW : 2 * 3 * SAMPLES_A_TURN] += 3_000
    assert _faults(made, capture) == []


@pytest.mark.parametrize("rows", [10, 40, 300])
@pytest.mark.parametrize("head", [1, 2])
def test_a_head_that_stands_while_the_other_goes_on_is_reported(head: int, rows: int) -> None:
    """The only fault is the frozen stretch with its rows. The frozen rows falsify the error of the
    disc, but no step of the other rows is reported."""
    made, capture = _copied()
    counts = capture.head1_counts if head == 1 else capture.head2_counts
    counts[ROW : ROW + rows] = counts[ROW]
    first_of_run = int(np.flatnonzero(capture.run == 1)[0])
    assert _faults(made, capture) == [
        f"capture, run 1, sample {ROW - first_of_run} of the run (row {ROW} of the data, line "
        f"{ROW + 2} of the file), and the {rows - 1} rows after it: head {head} keeps one count "
        "while another head moves; mask these rows (mask.csv)"
    ]


def test_a_head_that_jumps_again_and_again_is_reported() -> None:
    """The diagnosis reports a head as faulty if it steps by 3,000 counts and back at 20 places,
    which is more often than slips occur."""
    made, capture = _copied()
    for number in range(20):
        capture.head2_counts[ROW + 40 * number : ROW + 40 * number + 6] += 3_000
    found = _faults(made, capture)
    assert len(found) == 1
    assert "head 2 moves by" in found[0]
    assert "40 such steps in this run" in found[0]


@pytest.mark.parametrize("head", [1, 2])
@pytest.mark.parametrize("bits", [21, 22, 23])
def test_a_counter_of_too_few_bits_is_reported(head: int, bits: int) -> None:
    """A counter of 21 to 23 bits starts anew 8, 4 or 2 times in a turn of 2²⁴ counts."""
    made, capture = _copied()
    counts = capture.head1_counts if head == 1 else capture.head2_counts
    before = counts.copy()
    counts %= 1 << bits
    fell = np.flatnonzero((np.diff(counts) != np.diff(before)) & (np.diff(capture.run) == 0))
    (found,) = _faults(made, capture)
    first = int(fell[0]) + 1
    assert f"(row {first} of the data, line {first + 2} of the file): head {head} moves" in found
    moved = int(counts[first] - counts[first - 1])
    assert f"head {head} moves by {moved:+,d} counts, as in {fell.size} rows" in found
    # The stated number of counts agrees with 2^bits within the noise of some counts.
    number = int(found.split("anew about every ")[1].split(" counts")[0].replace(",", ""))
    assert number == pytest.approx(1 << bits, abs=10)


@pytest.mark.parametrize("size", [300_000, 2_000_000])
def test_equal_slips_are_no_counter_that_starts_anew(size: int) -> None:
    """A head that loses the same number of counts in each of two runs has no counter that starts
    anew."""
    made, capture = _copied()
    for run in (0, 2):
        of_run = np.flatnonzero(capture.run == run)
        capture.head2_counts[of_run[1500:]] -= size
    assert not any("starts anew" in text for text in _faults(made, capture))


def test_dense_rows_of_coarse_counts_are_no_jumps() -> None:
    """The diagnosis finds no jumps in dense rows of coarse counts. Each step from row to row is ten
    counts with 1.5 counts of noise, so that a deviation of a tenth of a step is no fault.
    """
    random = np.random.default_rng(5)
    size = 40_000
    turn = np.arange(size) * 10.0
    heads = [np.round(turn + random.normal(0.0, 1.0, size)).astype(np.int64) for _ in range(2)]
    made, _ = _copied()
    table = replace(made.table, counts_per_rev=size * 10)
    shift = round(33.0 / 360.0 * size * 10)
    capture = Capture(
        np.zeros(size, dtype=np.int64), np.arange(size) * 1e-3, heads[0], heads[1] + shift
    )
    assert data_faults(observations_of(MeasurementSet(table, capture))) == []


def test_a_temperature_of_a_broken_sensor_is_reported() -> None:
    made, capture = _copied()
    assert capture.temperature_c is not None
    capture.temperature_c[ROW] += 7.0
    assert "changes by +7.0 K and back" in _faults(made, capture)[0]
    capture.temperature_c[ROW:] = -999.0
    assert "temperature_c is -999, expected" in _faults(made, capture)[0]


def test_heads_that_stand_elsewhere_than_the_description_says_are_reported() -> None:
    made, capture = _copied()
    swapped = replace(capture, head1_counts=capture.head2_counts, head2_counts=capture.head1_counts)
    assert "head 2 reads -33.0" in _faults(made, swapped)[0]
    wrong = replace(made, table=replace(made.table, head_separation_deg=32.0))
    assert "reads 33.00" in data_faults(observations_of(wrong))[0]
    near = replace(made, table=replace(made.table, head_separation_deg=32.9))
    assert data_faults(observations_of(near)) == []


@pytest.mark.parametrize("head", [1, 2])
@pytest.mark.parametrize("bits", [24, 16])
def test_a_head_that_counts_backwards_is_stated_as_such(head: int, bits: int) -> None:
    """A head with A and B exchanged counts the negative angle. At 2¹⁶ counts a row of these sets is
    55 counts. The counters start at any place."""
    made, capture = _copied()
    coarse = 1 << (24 - bits)
    counts = [capture.head1_counts // coarse, capture.head2_counts // coarse]
    counts[head - 1] = 12_345 - counts[head - 1]
    made = replace(made, table=replace(made.table, counts_per_rev=1 << bits))
    capture = replace(capture, head1_counts=counts[0], head2_counts=counts[1])
    (found,) = _faults(made, capture)
    (said,) = doubts_of(replace(made, capture=capture))
    for text in (found, said):
        assert "heads 1 and 2 count in opposite directions in every run" in text
        assert "A and B" in text
        assert "ahead" not in text
        assert "index" not in text


def test_a_run_in_which_a_head_counts_backwards_is_stated() -> None:
    made, capture = _copied()
    capture.head2_counts[capture.run == 2] *= -1
    (found,) = (text for text in _faults(made, capture) if "opposite" in text)
    assert "heads 1 and 2 count in opposite directions in run 2" in found


def test_heads_of_a_standing_table_that_vibrates_do_not_count_backwards() -> None:
    """Two opposite heads see a vibration of the axis with opposite signs; the table does not
    turn."""
    made, _ = _copied()
    wave = np.round(300.0 * np.sin(np.arange(4_000) * 0.3)).astype(np.int64)
    capture = Capture(np.zeros(4_000, dtype=np.int64), np.arange(4_000) * 1e-3, wave, -wave)
    made = replace(made, table=replace(made.table, head_separation_deg=0.0))
    assert not any("opposite" in text for text in _faults(made, capture))


def test_a_clock_that_stands_is_reported() -> None:
    made, capture = _copied()
    capture.time_s[capture.run == 1] = 60.0
    found = _faults(made, capture)
    assert len(found) == 1
    assert "run 1: time_s stays at 60 s" in found[0]


def test_one_reading_of_a_station_far_from_its_others_is_reported() -> None:
    made = measurement_set(cycles=4)
    assert made.reference is not None
    made.reference.error_arcsec[100] += 6.0
    seen = observations_of(made)
    assert [(item.channel, item.row) for item in seen.masked] == [("reference", 102)]
    assert data_faults(seen) == []


@pytest.mark.parametrize("name", ["bearing_ball_pass", "count_slip", "reference_drift"])
def test_the_largest_effects_are_no_faults(name: str) -> None:
    """The largest effects are no faults of the record, although at the stations they cause errors
    that differ from cycle to cycle."""
    from arctrue.table.registry import RECIPES

    made = simulate_set([Wanted(name, RECIPES[name].high)], full().smaller(2000, 4), 77)
    assert data_faults(observations_of(made.measurement)) == []


@pytest.mark.large
def test_a_disturbance_of_one_turn_is_no_defect_of_the_disc() -> None:
    """The diagnosis names no defect of the disc if eight rows of one turn are off by 60 counts and
    the other eleven turns do not have this error."""
    made, capture = _copied()
    capture.head2_counts[ROW : ROW + 8] += 60
    _, found = diagnosed(replace(made, capture=capture))
    tempting = {item.name: item.p_corrected for item in found.candidates}
    # The probability p of the effect is less than a tenth of the limit for a name, so that only the
    # other turns contradict the effect.
    assert tempting["graduation_defect"] < 1e-3
    assert found.named is None
    assert found.effect_class == []


def test_white_noise_has_the_scatter_that_it_was_made_with() -> None:
    """The estimated scatter is right to 2 %, which is four standard errors of a median absolute
    deviation of 80,000 values."""
    noise = np.random.default_rng(9).normal(0.0, 0.3, 80_000)
    ramp = 5.0 * np.arange(noise.size) + 40.0 * np.sin(np.arange(noise.size) / 500.0)
    steps = np.diff(noise + ramp)
    assert step_scatter(steps) == pytest.approx(0.3 * np.sqrt(2.0), rel=0.02)


def test_what_is_off_for_longer_than_three_rows_is_no_excursion() -> None:
    values = np.zeros(50)
    values[20:24] = 5.0
    assert excursions(values, 1.0) == []
    values[23] = 0.0
    assert excursions(values, 1.0) == [(20, 23, 5.0)]


@pytest.mark.parametrize(("gap_rows", "warnings"), [(60, 0), (0, 1)])
def test_a_run_that_ends_in_a_gap_is_not_cut(gap_rows: int, warnings: int) -> None:
    """A run of three turns without its last 50 rows gives a warning, if no other run has a gap."""
    made, capture = _copied()
    kept = np.ones(capture.run.size, dtype=bool)
    kept[ROW : ROW + gap_rows] = False
    end = int(np.flatnonzero(capture.run == 2)[-1]) + 1
    kept[end - 50 : end] = False
    seen = observations_of(replace(made, capture=capture.where(kept)))
    assert data_faults(seen) == []
    found = cut_runs(seen)
    assert len(found) == warnings
    assert all("cut after 2.958 turns" in text for text in found)


@pytest.mark.large
def test_a_cut_run_is_used_and_the_effect_is_named() -> None:
    """One of four runs has 2.3 turns. The diagnosis uses its rows and names the effect of the set:
    an error of 1.5″ with the period of the signal."""
    made = measurement_set(electrical=lambda phase: 1.5 * np.cos(phase + 0.3))
    capture = made.capture
    assert capture is not None
    end = int(np.flatnonzero(capture.run == 1)[-1]) + 1
    kept = np.ones(capture.run.size, dtype=bool)
    kept[end - round(0.7 * SAMPLES_A_TURN) : end] = False
    _, found = diagnosed(replace(made, capture=capture.where(kept)))
    assert found.named is not None
    assert found.named.name == "subdivision_error"
    assert len(cut_runs(found.observations)) == 1


def _cut(capture: Capture, turns: dict[int, float]) -> Capture:
    """Return the capture with some runs cut after a number of turns."""
    kept = np.ones(capture.run.size, dtype=bool)
    for run, length in turns.items():
        start, *_, end = np.flatnonzero(capture.run == run)
        kept[start + round(length * SAMPLES_A_TURN) : end + 1] = False
    return capture.where(kept)


@pytest.mark.parametrize("standing", [1, 2])
def test_runs_of_less_than_a_turn_are_left_out(standing: int) -> None:
    """The runs of whole turns are used; rows keep their lines in the file."""
    made, capture = _copied()
    cut = _cut(capture, {0: 0.5, 2: 0.7})
    seen = observations_of(replace(made, capture=cut))
    assert data_faults(seen) == []
    assert too_short(seen) is None
    (said,) = seen.left_out
    assert "run 0 has 0.500 of a turn; run 2 has 0.700 of a turn" in said
    assert seen.capture is not None
    assert seen.capture.runs == 2
    assert seen.capture.run.size == np.isin(cut.run, [1, 3]).sum()
    # The first used sample follows the header and the rows of run 0.
    assert seen.sample_line(0) == 2 + np.count_nonzero(cut.run == 0)
    # A run in which the table stands still is no short run.
    cut.head1_counts[cut.run == standing] = cut.head1_counts[cut.run == standing][0]
    still = observations_of(replace(made, capture=cut))
    assert any("stands still" in text for text in data_faults(still))


def test_an_outlier_behind_a_short_run_is_listed_with_its_line() -> None:
    made, capture = _copied()
    cut = _cut(capture, {0: 0.5})
    cut.head2_counts[ROW] += 3_000
    seen = observations_of(replace(made, capture=cut))
    assert [item.row for item in seen.masked] == [ROW + 2]


@pytest.mark.parametrize("place", ["end", "inside"])
def test_a_wrong_row_makes_no_run_short(place: str) -> None:
    """A reading that is off by a quarter turn in the last row of a whole run, or by half a turn
    inside it, is masked; only the run that really has 0.7 of a turn is left out."""
    made, capture = _copied()
    cut = _cut(capture, {2: 0.7})
    row = np.flatnonzero(cut.run == 1)[-1] if place == "end" else ROW
    cut.head1_counts[row] += COUNTS_PER_REV // (-4 if place == "end" else 2)
    seen = observations_of(replace(made, capture=cut))
    assert [item.row for item in seen.masked] == [row + 2]
    (said,) = seen.left_out
    assert "capture: run 2 has 0.700 of a turn, and" in said
    assert too_short(seen) is None


def test_a_capture_of_arcs_cannot_tell() -> None:
    """Sweeps of 150° of two heads are no faulty data."""
    made, capture = _copied()
    cut = _cut(capture, dict.fromkeys(range(4), 150.0 / 360.0))
    seen = observations_of(replace(made, capture=cut))
    assert data_faults(seen) == []
    assert seen.left_out == ()
    _, found = diagnosed(replace(made, capture=cut))
    assert found.verdict == "cannot_tell"
    said = " ".join(sentences(found))
    assert "4 of the 4 runs have 0.417 of a turn" in said
    assert "a capture with runs of a whole turn or more" in said
