"""Tests of the scores of a turn, and of the effect of a wrong reference; the true errors are
known."""

from __future__ import annotations

import dataclasses
import json

import numpy as np
import pytest

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.instrument import EdgeTrack, InstrumentError
from arctrue.instrument.turn_score import BINS, TurnScore, score_turn, score_turns
from arctrue.studies.scenario.course import Leg
from arctrue.studies.scenario.scenario import Scale, Scenario, ScenarioCause, TableErrors
from arctrue.studies.scenario.seen import seen_by_reference
from arctrue.table import RotaryTable, TableState, two_heads
from arctrue.table.cause import Cause
from arctrue.table.causes.autocollimator_scale import AutocollimatorScale
from arctrue.table.causes.polygon_mounting import PolygonMounting
from arctrue.table.causes.reading_latency import ReadingLatency
from arctrue.table.causes.sampling_skew import SamplingSkew
from arctrue.table.causes.shaft_wind_up import ShaftWindUp

COUNTS = 1 << 18
COUNT_ARCSEC = 1_296_000 / COUNTS
SPEED_RAD_S = 0.5


def _track(lost_counts: int) -> tuple[EdgeTrack, np.ndarray]:
    """Return the track of three turns with 30″ of order 2, and its travel in turns; counts are lost
    in the middle of turn 2."""
    position = np.arange(3 * COUNTS)
    reading = position * (2 * np.pi / COUNTS)
    angle = reading - 30 * RAD_PER_ARCSEC * np.cos(2 * reading + 0.4)
    empty = np.zeros(0)
    whole = np.zeros(0, dtype=np.int64)
    track = EdgeTrack(
        counts_per_rev=COUNTS,
        clock=position,
        position=position - lost_counts * (position >= 3 * COUNTS // 2),
        true_angle_rad=angle,
        bin_edges=whole,
        bin_mean_counts=empty,
        bin_lowest_counts=empty,
        bin_highest_counts=empty,
        edges=position.size,
        dropped=0,
    )
    return track, angle / (2 * np.pi)


def test_amplitude_range_and_rms_of_a_wave() -> None:
    track, travel = _track(0)
    turns = score_turns(track, travel, 4)
    assert turns[3] is None
    for turn in turns[:3]:
        assert turn is not None
        assert turn.amplitude_arcsec[1] == pytest.approx(30.0, abs=0.01)
        assert np.delete(turn.amplitude_arcsec, 1).max() < 0.01
        assert turn.rms_arcsec == pytest.approx(30 / np.sqrt(2), abs=0.01)
        assert (turn.lowest_arcsec, turn.highest_arcsec) == pytest.approx((-30, 30), abs=0.01)
        assert turn.mean_arcsec == pytest.approx(0.0, abs=0.01)


def test_score_of_edges_at_uneven_places_is_that_of_their_cosines() -> None:
    angle = np.random.default_rng(4).uniform(0, 2 * np.pi, 400_000)
    waves = 1.5 * np.cos(2 * angle + 1) + 0.25 * np.cos(64 * angle - 2)
    score = TurnScore.of_edges(angle, 3.0 + waves, 1.0)
    expected = np.zeros(64)
    expected[[1, 63]] = 1.5, 0.25
    # In a part of half a degree, the mean place of about 550 edges differs from the centre by 0.012
    # of the part, 1.1e-4 rad. This difference changes the mean error of a part by up to 0.25 · 64 ·
    # 1.1e-4 = 1.7e-3 (order 64); the 720 differences largely cancel in an amplitude.
    np.testing.assert_allclose(score.amplitude_arcsec, expected, atol=1e-3)
    assert score.mean_arcsec == pytest.approx(2.0, abs=5e-3)
    # The RMS is taken about the mean of the parts, which differs by 0.0023 from the mean of the
    # edges.
    assert score.edges_rms_arcsec == pytest.approx(np.std(waves), rel=1e-5)
    assert score.every_edge_arcsec == pytest.approx((waves.min(), waves.max()), abs=5e-3)
    assert score.edges_reach_arcsec == pytest.approx(np.abs(waves).max(), abs=5e-3)
    assert score.edges == angle.size
    assert score.largest_order == 2


def test_score_of_even_readings_is_that_of_edges_at_the_same_angles() -> None:
    angle = (np.arange(7200) + 0.5) * (2 * np.pi / 7200)
    waves = 1.5 * np.cos(2 * angle + 1) + 0.25 * np.cos(64 * angle - 2)
    more = waves + 0.125 * np.cos(120 * angle + 1)
    score = TurnScore.of_even_readings(3.0 + more, 128)
    expected = np.zeros(128)
    expected[[1, 63, 119]] = 1.5, 0.25, 0.125
    np.testing.assert_allclose(score.amplitude_arcsec, expected, atol=1e-12)
    assert score.edges_rms_arcsec == pytest.approx(np.sqrt(0.5 * np.sum(expected**2)), rel=1e-12)
    assert score.every_edge_arcsec == pytest.approx((more.min(), more.max()), abs=1e-12)
    as_edges = TurnScore.of_edges(angle, 3.0 + more)
    for name in ("error_arcsec", "lowest_edge_arcsec", "highest_edge_arcsec"):
        np.testing.assert_allclose(getattr(score, name), getattr(as_edges, name), atol=1e-9)


@pytest.mark.parametrize("bins", [720, 7200])
def test_score_of_recorded_parts_is_that_of_their_edges(bins: int) -> None:
    track, _ = _track(0)
    angle = track.true_angle_rad[:COUNTS]
    counts = track.position[:COUNTS] - angle * (COUNTS / (2 * np.pi))
    place = np.floor(np.mod(angle, 2 * np.pi) * (bins / (2 * np.pi))).astype(np.int64)
    edges = np.bincount(place, minlength=bins)
    order = np.argsort(place, kind="stable")
    begins = np.concatenate([[0], np.cumsum(edges)[:-1]])
    recorded = dataclasses.replace(
        track,
        position=track.position[:COUNTS],
        true_angle_rad=angle,
        bin_edges=edges,
        bin_mean_counts=np.add.reduceat(counts[order], begins) / edges,
        bin_lowest_counts=np.minimum.reduceat(counts[order], begins),
        bin_highest_counts=np.maximum.reduceat(counts[order], begins),
        edges=COUNTS,
    )
    found, expected = score_turn(recorded), TurnScore.of_edges(angle, counts * COUNT_ARCSEC)
    for name in ("error_arcsec", "lowest_edge_arcsec", "highest_edge_arcsec"):
        np.testing.assert_allclose(getattr(found, name), getattr(expected, name), atol=1e-6)
    # Averaging over half a degree attenuates an order more than averaging over a twentieth of a
    # degree; the score corrects this.
    np.testing.assert_allclose(found.amplitude_arcsec, expected.amplitude_arcsec, atol=2e-3)
    assert found.edges_rms_arcsec == pytest.approx(expected.edges_rms_arcsec, rel=1e-6)
    assert found.as_json().keys() == expected.as_json().keys()
    unfinished = dataclasses.replace(recorded, bin_edges=edges * (np.arange(bins) > 0))
    with pytest.raises(InstrumentError, match="does not hold a whole turn"):
        score_turn(unfinished)


def test_lost_counts_stay_in_the_mean() -> None:
    track, travel = _track(7)
    first, second, third = score_turns(track, travel, 3)
    assert first is not None
    assert second is not None
    assert third is not None
    assert second.mean_arcsec == pytest.approx(-3.5 * COUNT_ARCSEC, rel=0.01)
    assert third.mean_arcsec == pytest.approx(-7 * COUNT_ARCSEC, rel=0.01)
    assert third.rms_arcsec == pytest.approx(first.rms_arcsec, abs=0.01)


def test_a_part_of_a_turn_has_no_orders() -> None:
    track, travel = _track(0)
    half = dataclasses.replace(
        track,
        clock=track.clock[: COUNTS // 2],
        position=track.position[: COUNTS // 2],
        true_angle_rad=track.true_angle_rad[: COUNTS // 2],
    )
    (turn,) = score_turns(half, travel[: COUNTS // 2], 1)
    assert turn is not None
    assert np.isnan(turn.amplitude_arcsec).all()
    assert np.isfinite(turn.rms_arcsec)
    # RFC 8259: JSON has no NaN; an unknown value is null.
    written = json.loads(json.dumps(turn.as_json() | turn.curve_as_json(), allow_nan=False))
    assert written["amplitude_arcsec"] == [None] * 64
    known = [value for value in written["error_arcsec"] if value is not None]
    assert known == turn.error_arcsec[np.isfinite(turn.error_arcsec)].tolist()
    assert len(known) < len(written["error_arcsec"]) == BINS


def _scenario(*causes: Cause) -> Scenario:
    named = tuple(ScenarioCause("", cause, reference_only=True) for cause in causes)
    legs = (Leg(turns=2, speed_rad_s=SPEED_RAD_S),)
    return Scenario("", "", Scale(), TableErrors(), legs, causes=named)


def _wave(amplitude_arcsec: float, order: int) -> TurnScore:
    angle = (np.arange(BINS) + 0.5) * (2 * np.pi / BINS)
    return TurnScore.of_means(amplitude_arcsec * np.cos(order * angle), 0.0, 0.0)


def test_a_gain_of_the_autocollimator() -> None:
    scenario = _scenario(AutocollimatorScale(0.05))
    seen = seen_by_reference(scenario, scenario.course(), 1, _wave(10.0, 1))
    assert seen is not None
    # 24 faces sample a whole wave: they show its RMS, enlarged by 5 %.
    assert seen.rms_arcsec == pytest.approx(1.05 * 10 / np.sqrt(2), rel=1e-6)
    assert np.isfinite(seen.error_arcsec).sum() == 24


@pytest.mark.parametrize(
    ("offset_m", "tilt_arcsec", "amplitude_arcsec"),
    [
        # The value follows from equation (14) of the paper. An encoder of 30 mm radius with the
        # same offset from its axis would have an error of 2.06″.
        (0.3e-6, 0.0, 8 * 0.3e-6 * 0.03e-6 / 10e-3**2 * 206_265),
        (0.0, 60.0, 60.0 * np.sin(np.deg2rad(2.0))),
    ],
)
def test_a_polygon_off_the_axis_and_one_that_leans(
    offset_m: float, tilt_arcsec: float, amplitude_arcsec: float
) -> None:
    tilt_rad = np.deg2rad(tilt_arcsec / 3600)
    roll_rad = 0.0 if offset_m else np.deg2rad(2.0)
    scenario = _scenario(PolygonMounting(offset_m, 0.03e-6, 10e-3, tilt_rad, roll_rad, 0.0))
    seen = seen_by_reference(scenario, scenario.course(), 1, _wave(0.0, 1))
    assert seen is not None
    assert seen.rms_arcsec == pytest.approx(amplitude_arcsec / np.sqrt(2), rel=1e-4)


def test_without_an_effect_of_the_reference_nothing_is_shown() -> None:
    scenario = _scenario()
    assert seen_by_reference(scenario, scenario.course(), 1, _wave(1.0, 1)) is None


@pytest.mark.parametrize(
    ("cause", "head", "expected_rad"),
    [
        (ReadingLatency(40e-6), 0, -40e-6 * SPEED_RAD_S),
        (ReadingLatency(40e-6), 1, -40e-6 * SPEED_RAD_S),
        (SamplingSkew(40e-6), 0, 0.0),
        (SamplingSkew(40e-6), 1, 40e-6 * SPEED_RAD_S),
    ],
)
def test_a_late_signal_shows_where_the_table_was(
    cause: Cause, head: int, expected_rad: float
) -> None:
    angle = np.linspace(0.0, 6.0, 20)
    moving = TableState(angle * 0, angle, np.full_like(angle, SPEED_RAD_S))
    late = RotaryTable(heads=two_heads(), causes=(cause,), counts_per_rev=COUNTS)
    plain = RotaryTable(heads=two_heads(), counts_per_rev=COUNTS)
    off = late.reading_rad(head, moving) - plain.reading_rad(head, moving)
    assert off == pytest.approx(expected_rad, abs=1e-12)


def test_a_shaft_that_winds_up_turns_both_heads() -> None:
    scenario = _scenario()
    table = RotaryTable(heads=two_heads(), causes=(ShaftWindUp(1e-5),), counts_per_rev=COUNTS)
    course = scenario.course()
    state = course.state(np.array([course.time_at_turn(1.0)]))
    plain = RotaryTable(heads=two_heads(), counts_per_rev=COUNTS)
    for head in (0, 1):
        off = table.reading_rad(head, state) - plain.reading_rad(head, state)
        assert off == pytest.approx(1e-5, abs=1e-12)
