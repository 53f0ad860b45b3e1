"""Tests that rows with recording errors are masked and listed, and that rows with errors of the
table are kept."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.workbench.small_sets import (
    ALPHA,
    ARCSEC,
    COUNTS_PER_REV,
    SAMPLES_A_TURN,
    TURNS,
    measurement_set,
    paper_error,
)

from arctrue.measurement import Capture, MeasurementSet, Reference
from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.observations.build import observations_of
from arctrue.workbench.observations.outliers.far_rows import (
    FALSE_ROWS,
    far_from_neighbours,
    far_threshold,
    local_scatter,
)
from arctrue.workbench.observations.outliers.reference_rows import reference_outliers
from arctrue.workbench.observations.wrong_rows import without_wrong_rows

ROWS = 4 * TURNS * SAMPLES_A_TURN
SPIKE_ARCSEC = 5.0
"""Size of a spike: fifty times the noise of a head."""


def _with_head2(made: MeasurementSet, rows: NDArray[np.int64], arcsec: float) -> MeasurementSet:
    assert made.capture is not None
    counts = made.capture.head2_counts.copy()
    counts[rows] += round(arcsec * ARCSEC / (2.0 * np.pi) * COUNTS_PER_REV)
    return replace(made, capture=replace(made.capture, head2_counts=counts))


def _masked(made: MeasurementSet, channel: str = "capture") -> list[int]:
    return [item.row - 2 for item in observations_of(made).masked if item.channel == channel]


def test_a_good_set_keeps_every_row() -> None:
    assert observations_of(measurement_set()).masked == ()


def test_each_single_wrong_row_is_masked_and_no_other() -> None:
    # The first and the last five rows of a run are predicted from one side only, and the next two
    # rows from fewer rows than the others.
    run = ROWS // 4
    ends = np.array([0, 2, 6, run - 7, run - 2, 2 * run - 1, 2 * run + 1])
    wrong = np.random.default_rng(3).choice(ROWS // 10, 40, replace=False) * 10 + 9
    wrong = np.union1d(wrong[np.mod(wrong + 10, run) > 20], ends)
    seen = observations_of(_with_head2(measurement_set(), wrong, SPIKE_ARCSEC))
    assert sorted(item.row - 2 for item in seen.masked) == sorted(wrong.tolist())
    assert seen.capture is not None
    assert seen.capture.run.size == ROWS - wrong.size
    # The stated distance equals the added spike within five standard deviations of R₂ − R₁. The
    # distance of a row that is predicted from one side scatters 1.3 times as much.
    for item in seen.masked:
        assert item.away_arcsec == pytest.approx(SPIKE_ARCSEC, abs=1.3 * 5.0 * 0.1 * np.sqrt(2.0))


@pytest.mark.parametrize("missing", [60, 400])
def test_a_wrong_row_with_missing_rows_is_masked(missing: int) -> None:
    """A wrong row next to missing rows is masked: the error of the table changes over the gap, and
    this change must not count as a distance from the neighbouring rows."""
    wrong = np.array([1_999, 2_000 + missing, 5_003, 5_005 + missing])
    made = _with_head2(measurement_set(), wrong, SPIKE_ARCSEC)
    assert made.capture is not None
    left = np.ones(ROWS, dtype=bool)
    left[2_000 : 2_000 + missing] = left[5_004 : 5_004 + missing] = False
    seen = observations_of(replace(made, capture=made.capture.where(left)))
    kept = np.flatnonzero(left)
    assert [kept[item.row - 2] for item in seen.masked] == wrong.tolist()


def test_a_wrong_row_between_two_gaps_is_masked_and_the_rows_around_it_are_not() -> None:
    """A wrong row between two gaps is masked, and the rows around it are not: ten rows lie between
    two gaps of 18° each, and over each gap R₂ − R₁ changes by up to 16″.

    A running median that extends across a gap cannot predict these rows.
    """
    left = np.ones(ROWS, dtype=bool)
    for first in range(1_000, ROWS - 200, 500):
        left[first : first + 60] = left[first + 70 : first + 130] = False
    wrong = np.arange(1_000, ROWS - 200, 1_000) + 64
    made = _with_head2(measurement_set(), wrong, SPIKE_ARCSEC)
    assert made.capture is not None
    seen = observations_of(replace(made, capture=made.capture.where(left)))
    kept = np.flatnonzero(left)
    assert [kept[item.row - 2] for item in seen.masked] == wrong.tolist()


@pytest.mark.parametrize("scatter_counts", [0.75, 1.5, 2.1, 6.0])
def test_the_scatter_of_whole_counts_is_that_of_the_noise(scatter_counts: float) -> None:
    """The estimated scatter equals that of the noise, although the values are whole counts;
    rounding adds a variance of 1/12 count² (Sheppard)."""
    noise = np.random.default_rng(11).normal(0.0, scatter_counts, 20_000)
    away = np.round(noise) + 0.5 * np.round(
        2.0 * np.random.default_rng(12).normal(0.0, 0.3, 20_000)
    )
    found = float(np.median(local_scatter(away, 1.0)))
    expected = float(np.std(away))
    # The largest of three scatters, each from 256 rows, is on average 1.08 times the true one.
    assert 0.95 * expected < found < 1.25 * expected


@pytest.mark.parametrize("place", [5, 6, 7, 192, 193, 194])
def test_a_wrong_row_near_an_end_is_far_where_the_values_curve(place: int) -> None:
    """A wrong row near an end is found although the values follow a curve. A period has 25 rows,
    like order 20 with 500 rows per turn, so that a straight line through 14 rows predicts a row
    badly.

    A prediction from the rows 1 to 7 away on both sides errs by at most 2·(1 − cos(2π·4/25)) = 0.93
    of the amplitude.
    """
    values = 2.0 * np.sin(2.0 * np.pi * np.arange(200) / 25.0)
    values += 0.1 * np.random.default_rng(place).standard_normal(200)
    values[place] += 9.0
    away, scatter = far_from_neighbours(values, 0.0)
    assert np.flatnonzero(np.abs(away) > 6.0 * scatter).tolist() == [place]


def test_outliers_of_both_signs_do_not_vouch_for_each_other() -> None:
    """Outliers of both signs do not confirm each other. If one of a hundred rows is an outlier,
    some outliers lie by chance at the distance α from an outlier of the other sign, as with dirt on
    the disc."""
    random = np.random.default_rng(4)
    wrong = random.choice(ROWS // 20, ROWS // 100, replace=False) * 20 + 9
    made = measurement_set()
    above = random.random(wrong.size) < 0.5
    made = _with_head2(made, wrong[above], SPIKE_ARCSEC)
    made = _with_head2(made, wrong[~above], -SPIKE_ARCSEC)
    assert sorted(_masked(made)) == sorted(wrong.tolist())


def test_what_comes_again_at_the_same_angle_is_kept() -> None:
    """Rows with dirt on the disc are kept: dirt that spoils only a few rows (its standard deviation
    is one row) shows in both heads in every revolution."""

    def dirty(disc: NDArray[np.float64], temperature: object, speed: object) -> object:
        away = np.angle(np.exp(1j * (disc - 1.0)))
        dirt = SPIKE_ARCSEC * np.exp(-0.5 * (away / (2.0 * np.pi / SAMPLES_A_TURN)) ** 2)
        return paper_error(disc, temperature, speed) + dirt  # type: ignore[arg-type]

    assert observations_of(measurement_set(dirty)).masked == ()  # type: ignore[arg-type]


def test_dirt_in_a_single_turn_is_kept_because_both_heads_see_it() -> None:
    made = measurement_set(runs=1, turns=1)
    assert made.capture is not None
    angle = made.capture.head1_counts * (2.0 * np.pi / COUNTS_PER_REV)
    at = int(np.argmin(np.abs(np.angle(np.exp(1j * (angle - 2.0))))))
    before = int(np.argmin(np.abs(np.angle(np.exp(1j * (angle - 2.0 + ALPHA))))))
    # R₂ − R₁ decreases when head 1 is over the dirt, and increases when head 2 is over the dirt.
    dirty = _with_head2(_with_head2(made, np.array([at]), -SPIKE_ARCSEC), np.array([before]), 5.0)
    assert _masked(dirty) == []
    assert _masked(_with_head2(made, np.array([at]), -SPIKE_ARCSEC)) == [at]


def test_lost_counts_stay_and_are_kept() -> None:
    assert _masked(_with_head2(measurement_set(), np.arange(2_000, ROWS), 40.0)) == []


def test_noise_three_times_as_large_over_a_part_of_the_turn_is_no_outlier() -> None:
    random = np.random.default_rng(8)
    made = measurement_set()
    assert made.capture is not None
    angle = np.mod(made.capture.head1_counts * (2.0 * np.pi / COUNTS_PER_REV), 2.0 * np.pi)
    noisy = np.where(angle < 1.5, 3.0 * 0.1, 0.0) / 0.0772
    counts = made.capture.head2_counts + np.round(random.normal(0.0, 1.0, ROWS) * noisy)
    rough = replace(made, capture=replace(made.capture, head2_counts=counts.astype(np.int64)))
    assert _masked(rough) == []


def test_one_reading_of_a_station_that_its_other_visits_contradict_is_masked() -> None:
    made = measurement_set(cycles=6, reversal_arcsec=2.0)
    assert made.reference is not None
    made.reference.error_arcsec[[30, 100]] += [6.0, -4.0]
    assert _masked(made, "reference") == [30, 100]
    seen = observations_of(made)
    assert seen.reference is not None
    assert seen.reference.run.size == made.reference.error_arcsec.size - 2


def _down_from_zero(stations: int, cycles: int) -> Reference:
    """Return passes up from 0° and down from 0° with an error of order 1 (120″) and noise of
    0.3″."""
    random = np.random.default_rng(4)
    up = np.arange(stations) * (360.0 / stations)
    target = np.tile(np.concatenate([up, np.mod(-up, 360.0)]), cycles)
    error = 120.0 * np.cos(np.radians(target) - 0.5) + random.normal(0.0, 0.3, target.size)
    half = np.repeat(np.arange(2 * cycles), stations)
    return Reference(target, error, cycle=half, direction=1 - 2 * np.mod(half, 2))


@pytest.mark.parametrize("stations", [12, 24, 36])
def test_a_pass_downwards_from_zero_has_no_outliers(stations: int) -> None:
    found, _ = reference_outliers(_down_from_zero(stations, 5))
    assert not found.any()


@pytest.mark.parametrize("rows", [1, 2])
def test_a_pass_of_one_or_two_rows_does_not_make_others_outliers(rows: int) -> None:
    """Nothing in a pass of one or two rows shows how far the pass deviates, so that its rows say
    nothing about other rows of their stations. The rows of such passes are up to 120″ from the mean
    of the turn."""
    made = _down_from_zero(24, 3)
    again = np.tile(np.arange(rows), 4)
    assert made.cycle is not None
    short = Reference(
        np.concatenate([made.target_deg, made.target_deg[again]]),
        np.concatenate([made.error_arcsec, made.error_arcsec[again]]),
        cycle=np.concatenate([made.cycle, 100 + np.repeat(np.arange(4), rows)]),
    )
    found, _ = reference_outliers(short)
    assert not found.any()


def test_what_comes_again_after_each_reversal_is_kept() -> None:
    """Readings that lag after each reversal are kept: the first two readings lag by 3″ and 1.5″,
    and such readings are more than 5 % of all rows."""
    made = measurement_set(cycles=6)
    assert made.reference is not None
    error, sense = made.reference.error_arcsec, np.asarray(made.reference.direction)
    for since, behind in enumerate((3.0, 1.5)):
        error[since::24] -= behind * sense[since::24]
    error[108] -= 6.0
    assert _masked(made, "reference") == [108]


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_a_head_that_knocks_between_two_stops_is_no_faulty_recording(seed: int) -> None:
    """The check reports no fault if a loose head moves between two stops, up to 5″ apart: on
    average it changes to the other stop at every third row."""
    made = measurement_set(cycles=10, turns=1)
    assert made.reference is not None
    random = np.random.default_rng(seed)
    rows = made.reference.error_arcsec.size
    side = np.where(np.cumsum(random.random(rows) < 1.0 / 3.0) % 2, 1.0, -1.0)
    made.reference.error_arcsec[:] += 2.5 * side * np.linspace(0.3, 1.0, rows)
    assert data_faults(observations_of(made)) == []


@pytest.mark.parametrize("passes", [1, 3])
def test_a_wrong_reading_of_a_dense_pass_is_masked(passes: int) -> None:
    """A wrong reading of a dense pass is masked: three visits of a station cannot show which of
    them is wrong, but the neighbouring rows can."""
    random = np.random.default_rng(2)
    target = np.tile(np.linspace(0.0, 40.0, 800), passes)
    error = 5.0 * np.sin(np.radians(target * 18.0)) + random.normal(0.0, 0.3, target.size)
    error[400] += 6.0
    cycle = np.repeat(np.arange(passes), 800)
    made = MeasurementSet(measurement_set().table, reference=Reference(target, error, cycle=cycle))
    assert _masked(made, "reference") == [400]


WHITE_SETS = 200
"""Number of sets with white noise. Each set has FALSE_ROWS masked rows on average, which is 4 rows
in all sets; the probability of 12 or more is 0.001."""
MOST_FALSE_ROWS = 12


def _white_reference(rows: int, stations: int | None, random: np.random.Generator) -> Reference:
    """Return normal white noise, at stations that are visited in turn or, with None, in one dense
    pass."""
    error = random.normal(0.0, 1.0, rows)
    if stations is None:
        return Reference(np.linspace(0.0, 0.5 * rows, rows), error)
    row = np.arange(rows)
    return Reference(row % stations * 360.0 / stations, error, cycle=row // stations)


@pytest.mark.parametrize(
    ("rows", "stations"), [(96, 24), (40, 8), (240, 24), (24, None), (60, None)]
)
def test_white_noise_of_few_rows_has_no_outliers(rows: int, stations: int | None) -> None:
    random, table = np.random.default_rng(12), measurement_set().table
    assert FALSE_ROWS * WHITE_SETS <= 4.0
    found = 0
    for _ in range(WHITE_SETS):
        made = MeasurementSet(table, reference=_white_reference(rows, stations, random))
        found += len(_masked(made, "reference"))
    assert found < MOST_FALSE_ROWS


@pytest.mark.parametrize("rows", [7, 10, 30])
def test_a_scatter_that_few_rows_tell_asks_for_more(rows: int) -> None:
    """If the scatter is estimated from few rows, the threshold is a larger multiple of the scatter.
    The test compares with simulated sets, in which the scatter of the other rows decides whether
    the first row is an outlier."""
    sets = 40_000
    noise = np.random.default_rng(14).normal(size=(sets, rows + 1))
    scatter = 1.4826 * np.median(np.abs(noise[:, 1:]), axis=1)
    false_share = float(np.mean(np.abs(noise[:, 0]) > far_threshold(rows, rows) * scatter))
    # The bound is the expected number FALSE_ROWS/rows·sets, plus four of its standard deviations.
    mean = FALSE_ROWS / rows * sets
    assert false_share * sets < mean + 4.0 * np.sqrt(mean)


@pytest.mark.parametrize("stations", [8, 24, None])
def test_white_noise_of_many_rows_has_no_outliers(stations: int | None) -> None:
    random = np.random.default_rng(13)
    reference = _white_reference(100_000, stations, random)
    assert _masked(MeasurementSet(measurement_set().table, reference=reference), "reference") == []


@pytest.mark.large
def test_wrong_rows_that_a_larger_effect_hid_are_found_in_what_it_leaves() -> None:
    """Wrong rows are found after the effect that hid them is in the model: errors of 1.5″, ten
    times the noise of R₂ − R₁, are hidden by an interpolation error of 2.5″ per head.

    Rows are 33 signal periods apart, so that the interpolation error looks like noise.
    """
    wrong = np.arange(500, ROWS, 1_300)
    hidden = measurement_set(electrical=lambda phase: 2.5 * np.cos(phase))
    made = _with_head2(hidden, wrong, 1.5)
    assert _masked(made) == []
    assert made.capture is not None
    done = diagnosed(made)[1]
    assert done.named is not None
    assert done.named.name == "subdivision_error"
    assert done.further == []
    masked = done.observations.masked
    assert [item.row - 2 for item in masked if item.channel == "capture"] == wrong.tolist()
    # The mask that the set itself states has priority.
    said = replace(made.capture, mask=np.zeros(ROWS, dtype=bool), trusted=np.ones(ROWS, dtype=bool))
    seen = observations_of(replace(made, capture=said))
    assert without_wrong_rows(seen, 100.0 * (np.arange(ROWS) == 500)) is None


def test_so_many_outliers_are_a_faulty_recording() -> None:
    # 8 % of the rows are wrong, at least five rows apart; single wrong rows may be at most 5 %.
    # Some rows are also wrong at the same angle of another turn and do not count.
    wrong = np.random.default_rng(6).choice(ROWS // 5, round(0.08 * ROWS), replace=False) * 5
    seen = observations_of(_with_head2(measurement_set(), wrong, SPIKE_ARCSEC))
    assert seen.masked == ()
    (fault,) = data_faults(seen)
    assert fault.startswith("capture: 7 % of the rows are outliers")


def test_the_mask_of_the_set_has_the_last_word() -> None:
    made = _with_head2(measurement_set(), np.array([700, 900]), SPIKE_ARCSEC)
    assert made.capture is not None
    mask, trusted = np.zeros(ROWS, dtype=bool), np.zeros(ROWS, dtype=bool)
    mask[500], trusted[900] = True, True
    reported = replace(made, capture=replace(made.capture, mask=mask, trusted=trusted))
    reasons = {item.row - 2: item.reason for item in observations_of(reported).masked}
    assert reasons == {500: "mask", 700: "outlier"}
    kept = observations_of(reported, mask_outliers=False)
    assert [item.row - 2 for item in kept.masked] == [500]


def test_columns_follow_the_rows_that_are_left() -> None:
    made = measurement_set()
    assert made.capture is not None
    load = np.arange(ROWS, dtype=float)
    u = np.full(ROWS, 0.2)
    mask = np.zeros(ROWS, dtype=bool)
    mask[1_000] = True
    capture = replace(made.capture, mask=mask, u_arcsec=u, conditions={"load_nm": load})
    seen = observations_of(replace(made, capture=capture))
    assert seen.capture is not None
    assert seen.capture.conditions["load_nm"].tolist() == np.delete(load, 1_000).tolist()
    assert seen.capture.u_arcsec is not None
    assert seen.capture.u_arcsec.size == ROWS - 1
    assert [seen.sample_line(sample) for sample in (999, 1_000)] == [1_001, 1_003]
    part = seen.capture.part(slice(10, 20))
    assert part.conditions["load_nm"].tolist() == load[10:20].tolist()


def _swinging(capture: Capture) -> tuple[Capture, NDArray[np.float64]]:
    """Return the same rows at the times of a speed that varies by ±40 %, and the varying speed."""
    time, speed = capture.time_s.copy(), np.empty(capture.time_s.size)
    for run in np.unique(capture.run):
        rows = capture.run == run
        angle = np.abs(capture.head1_counts[rows] - capture.head1_counts[rows][0])
        turn = 2.0 * np.pi * angle / COUNTS_PER_REV
        usual = 2.0 * np.pi * TURNS / float(np.ptp(time[rows]))
        pace = usual * (1.0 + 0.4 * np.sin(turn / 3.0))
        middle = 0.5 * (pace[1:] + pace[:-1])
        time[rows] = time[rows][0] + np.concatenate([[0.0], np.cumsum(np.diff(turn) / middle)])
        speed[rows] = pace * np.sign(capture.head1_counts[rows][-1] - capture.head1_counts[rows][0])
    return replace(capture, time_s=time), speed


def test_a_speed_that_swings_is_no_fault_and_is_known_in_each_row() -> None:
    made = measurement_set()
    assert made.capture is not None
    capture, speed = _swinging(made.capture)
    seen = observations_of(replace(made, capture=capture))
    assert data_faults(seen) == []
    assert seen.capture is not None
    # The speed is averaged over 65 of the 1,200 rows per turn. Within these rows, a sine of 40 %
    # with a period of 3 turns varies by (0.34/3)²/24 of 40 %. At the ends of a run the nearest
    # window is up to 32 rows away: 0.17 rad/3.
    assert np.abs(seen.capture.speed_rad_s / speed - 1.0).max() < 0.04
    inner = np.ones(ROWS, dtype=bool)
    for run in range(4):
        inner[run * 3600 : run * 3600 + 40] = inner[(run + 1) * 3600 - 40 : (run + 1) * 3600] = (
            False
        )
    assert np.abs(seen.capture.speed_rad_s / speed - 1.0)[inner].max() < 0.003


def test_an_even_run_has_one_speed() -> None:
    seen = observations_of(measurement_set())
    assert seen.capture is not None
    for run in range(4):
        assert np.unique(seen.capture.speed_rad_s[seen.capture.run == run]).size == 1
    assert seen.capture.speed_rad_s[0] == pytest.approx(np.radians(30.0), rel=1e-3)


def test_missing_rows_with_their_time_stamps_are_no_fault() -> None:
    made = measurement_set()
    assert made.capture is not None
    left = np.ones(ROWS, dtype=bool)
    left[np.random.default_rng(4).choice(ROWS, 300, replace=False)] = False
    left[5_000:5_060] = False
    gone = replace(made, capture=made.capture.where(left))
    assert data_faults(observations_of(gone)) == []
    assert observations_of(gone).masked == ()


def test_the_first_row_after_a_step_of_stations_is_kept() -> None:
    """The readings of 24 stations, in passes up and down, rise by 2.5″ (noise 0.15″) within the
    third pass and stay there: the first row after the step agrees with every row after it."""
    random = np.random.default_rng(12)
    up = np.arange(24) * 15.0
    target = np.concatenate([up if half % 2 == 0 else up[::-1] for half in range(6)])
    half = np.repeat(np.arange(6), 24)
    for first in (53, 54, 55, 56, 64, 68):
        error = 5.0 * np.cos(np.radians(target)) + random.normal(0.0, 0.15, target.size)
        error[first:] += 2.5
        rows = Reference(target, error, cycle=half // 2, direction=1 - 2 * np.mod(half, 2))
        found, _ = reference_outliers(rows)
        assert np.flatnonzero(found).tolist() == []


def test_the_rows_of_lost_counts_in_a_log_at_the_same_angles_are_kept() -> None:
    """In five turns of 400 angles the readings rise three times by 79.1″ (noise 10″); no row is an
    outlier."""
    random = np.random.default_rng(13)
    rows = np.arange(2000)
    target = rows * 0.9
    error = 100.0 * np.cos(np.radians(target)) + random.normal(0.0, 10.0, rows.size)
    for first in (450, 1100, 1550):
        error[first:] += 79.1
    found, _ = reference_outliers(Reference(target, error))
    assert np.flatnonzero(found).tolist() == []
