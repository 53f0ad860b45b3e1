"""Tests which rows of a reference run were read in motion; the rows resemble those of a test
bench."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.measurement import Reference
from arctrue.workbench.observations.reference_speed import passes_of, reference_speed

FACES = np.arange(24) * 15.0


def _reference(
    passes: list[tuple[np.ndarray, np.ndarray]], cycles: bool = True, jitter_s: float = 0.0
) -> Reference:
    """Return a reference run of passes ten seconds apart; each pass gives (targets in degrees,
    times since the start of the pass)."""
    random = np.random.default_rng(3)
    times, start = [], 0.0
    for _, since in passes:
        times.append(start + since + random.uniform(0.0, jitter_s, since.size))
        start = times[-1][-1] + 10.0
    target = np.concatenate([item[0] for item in passes])
    cycle = np.repeat(np.arange(len(passes)), [item[0].size for item in passes])
    return Reference(
        target_deg=target,
        error_arcsec=np.zeros(target.size),
        time_s=np.concatenate(times),
        cycle=cycle if cycles else None,
    )


def _stops(targets: np.ndarray, station_s: float = 4.0) -> tuple[np.ndarray, np.ndarray]:
    return targets, np.arange(targets.size) * station_s


def _steady(targets: np.ndarray, deg_s: float) -> tuple[np.ndarray, np.ndarray]:
    return targets, np.abs(targets - targets[0]) / deg_s


@pytest.mark.parametrize("cycles", [True, False])
def test_stations_of_a_polygon_stand_still(cycles: bool) -> None:
    """The table stands still at the stations of a polygon: every pass takes four seconds per
    station, so that the times do not depend on a speed of the table."""
    assert reference_speed(_reference([_stops(FACES), _stops(FACES[::-1])] * 3, cycles)) is None


def test_one_near_pass_among_many_stations_is_on_the_move() -> None:
    near = np.arange(0.0, 360.0)
    speed = reference_speed(_reference([_stops(FACES)] * 20 + [_steady(near, 30.0)]))
    assert speed is not None
    assert np.all(speed[:480] == 0.0)
    np.testing.assert_allclose(speed[480:], np.radians(30.0))


def test_faces_passed_at_several_speeds_are_on_the_move() -> None:
    passes = [_steady(FACES, 30.0), _steady(FACES[::-1], 30.0), _steady(FACES, 90.0)]
    speed = reference_speed(_reference(passes))
    assert speed is not None
    np.testing.assert_allclose(np.degrees(speed), np.repeat([30.0, -30.0, 90.0], 24))


@pytest.mark.parametrize("decimals", [2, 3, 6])
@pytest.mark.parametrize("fast_deg_s", [30.0, 70.0, 130.0])
def test_rounded_times_of_stations_show_the_speeds(fast_deg_s: float, decimals: int) -> None:
    """Stations 4° apart are passed at 10°/s and faster, and their times are rounded: at 30°/s a
    step takes 0.1333 s, which two decimals give as 0.13 s or 0.14 s.

    The times of the first and the last row are wrong by half a step each, so that the mean speed
    over 89 steps is wrong by at most 0.01 s / 2.7 s = 0.4 %.
    """
    stations = np.arange(90) * 4.0
    passes = [_steady(stations, 10.0), _steady(stations[::-1], fast_deg_s)]
    made = _reference(passes)
    assert made.time_s is not None
    speed = reference_speed(replace(made, time_s=np.round(made.time_s, decimals)))
    assert speed is not None
    np.testing.assert_allclose(np.degrees(speed), np.repeat([10.0, -fast_deg_s], 90), rtol=4e-3)


def test_a_hurried_hand_is_no_speed_in_whole_seconds() -> None:
    """Stops of 2.5 or 4 seconds with variations of up to a second show no speed, although times in
    whole seconds hide the variations."""
    random = np.random.default_rng(8)
    for _ in range(50):
        passes = [
            (FACES, np.concatenate([[0.0], np.cumsum(stop_s + random.uniform(-0.5, 0.5, 23))]))
            for stop_s in (4.0, 2.5, 4.0)
        ]
        made = _reference(passes)
        assert made.time_s is not None
        assert reference_speed(replace(made, time_s=np.round(made.time_s))) is None


def test_a_hurried_hand_is_no_speed() -> None:
    """An operator who stops for 2.5 or 4 seconds at each station, with variations of up to a
    second, shows no speed: the times do not follow the distances."""
    passes = [_stops(FACES), _stops(FACES, 2.5), _stops(FACES)]
    assert reference_speed(_reference(passes, jitter_s=1.0)) is None


def test_a_ramp_that_a_clock_sampled_is_on_the_move() -> None:
    """The table moves at the rows of a ramp that a clock sampled: the speed rises to 40°/s and
    falls again within a minute, with ten rows per second, up to 4° apart."""
    time = np.arange(0.0, 60.0, 0.1)
    wanted = np.where(time < 30.0, time, 60.0 - time) * 40.0 / 30.0
    angle = np.cumsum(wanted) * 0.1
    speed = reference_speed(_reference([(angle, time)]))
    assert speed is not None
    # The slope over 65 rows, 32 on each side, is the exact speed unless the rows include the top or
    # an end of the ramp.
    away = np.abs(np.degrees(speed) - wanted)
    inner = (np.abs(time - 30.0) > 3.3) & (time > 3.3) & (time < 56.7)
    assert away[inner].max() < 0.1
    assert away.max() < 40.0 / 30.0 * 3.3


def test_stations_at_unequal_distances_stand_still() -> None:
    """The table stands still at stations at unequal distances: stars from east to west take a
    minute each, while the distances between the stars vary."""
    stars = np.sort(np.random.default_rng(5).uniform(0.0, 360.0, 60))
    assert reference_speed(_reference([(stars, np.arange(60) * 60.0)])) is None


def test_fast_passes_of_a_log_are_on_the_move() -> None:
    """The table moves in the fast passes of a log: a clock of 50 Hz samples 19°/s every 0.4° and
    56°/s every 1.1°."""

    def sampled(deg_s: float) -> tuple[np.ndarray, np.ndarray]:
        since = np.arange(400) * 0.02
        return deg_s * since, since

    speeds = [19.0, -19.0, 56.0, -56.0]
    speed = reference_speed(_reference([sampled(one) for one in speeds]))
    assert speed is not None
    np.testing.assert_allclose(np.degrees(speed), np.repeat(speeds, 400), rtol=1e-9)


@pytest.mark.parametrize(("rate_hz", "moves"), [(20.0, True), (4.0, False)])
def test_rows_that_follow_too_fast_for_stops_are_on_the_move(rate_hz: float, moves: bool) -> None:
    """No servo stops 20 times a second at places 1.2° apart; it may stop four times a second."""
    since = np.arange(300) / rate_hz
    up = 1.2 * np.arange(300)
    speed = reference_speed(_reference([(up, since), (up[::-1], since)]))
    assert (speed is not None) == moves
    if speed is not None:
        np.testing.assert_allclose(np.degrees(speed), np.repeat([24.0, -24.0], 300), rtol=1e-9)


def test_two_readings_at_each_station_are_no_motion() -> None:
    """Two readings 0.1 s apart, and 4 s to the next station: the table stops there."""
    stations = np.repeat(FACES, 2)[:-1]
    since = (np.arange(stations.size) // 2) * 4.0 + (np.arange(stations.size) % 2) * 0.1
    passes = [(FACES[:1], np.array([0.0])), (stations[1:], since[1:])]
    assert reference_speed(_reference(passes)) is None


def test_stations_next_to_a_log_of_other_times_stand_still() -> None:
    """The table stands still at stations although the set also contains a log: a clock of 0.5 s
    sampled the pass in motion, and the stops last 4 s."""
    log = np.arange(100) * 0.5
    speed = reference_speed(_reference([_stops(FACES), (log, log), _stops(FACES[::-1])]))
    assert speed is not None
    assert np.all(speed[:24] == 0.0)
    assert np.all(speed[-24:] == 0.0)


FACES_AND_END = np.arange(25) * 15.0


@pytest.mark.parametrize("dwell_rows", [1, 3])
def test_a_pass_ends_at_an_end_station_that_is_read_again(dwell_rows: int) -> None:
    """A pass ends where the table turns, even if the end station is read again before the table
    turns back: 25 rows upwards, and then the rows from the second reading of the end station."""
    up, down = FACES_AND_END, FACES_AND_END[::-1]
    target = np.concatenate([up, np.full(dwell_rows - 1, up[-1]), down])
    found = passes_of(Reference(target_deg=target, error_arcsec=np.zeros(target.size)))
    assert found == [slice(0, 25), slice(25, target.size)]


def test_speeds_are_known_although_the_end_station_is_read_twice() -> None:
    """Both passes over the faces have their speeds, although no column separates them."""
    passes = [_steady(FACES_AND_END, 10.0), _steady(FACES_AND_END[::-1], 30.0)]
    speed = reference_speed(_reference(passes, cycles=False))
    assert speed is not None
    np.testing.assert_allclose(np.degrees(speed), np.repeat([10.0, -30.0], 25))


@pytest.mark.parametrize("again", ["first", "last", "both"])
def test_a_return_to_the_first_station_begins_a_pass_although_a_station_is_read_twice(
    again: str,
) -> None:
    """Two upward passes are two passes, although their first or last station is read twice: the
    step back to the first station is the only one in the other sense."""
    one = np.concatenate(
        [
            FACES[: 1 if again in ("first", "both") else 0],
            FACES,
            FACES[-1:] if again != "first" else [],
        ]
    )
    target = np.concatenate([one, one])
    found = passes_of(Reference(target_deg=target, error_arcsec=np.zeros(target.size)))
    assert found == [slice(0, one.size), slice(one.size, target.size)]


def _passes(target: np.ndarray, labels: np.ndarray | None) -> list[slice]:
    return passes_of(Reference(target, np.zeros(target.size), cycle=labels, direction=labels))


@pytest.mark.parametrize("labelled", [True, False])
@pytest.mark.parametrize("first_deg", [0.0, 15.0, 180.0])
def test_passes_within_one_turn_are_whole_wherever_they_start(
    first_deg: float, labelled: bool
) -> None:
    """Each pass has 24 stations, also if it goes downwards from 0° to 345°, or from 345° to 0°."""
    up = np.mod(first_deg + FACES, 360.0)
    down = np.mod(first_deg - FACES, 360.0)
    target = np.concatenate([up, down, up, down])
    labels = np.repeat([1, -1, 1, -1], 24) if labelled else None
    assert _passes(target, labels) == [slice(24 * k, 24 * (k + 1)) for k in range(4)]


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_turns_in_one_sense_within_one_turn_are_passes(sense: float) -> None:
    target = np.tile(np.mod(sense * FACES, 360.0), 5)
    assert _passes(target, None) == [slice(24 * k, 24 * (k + 1)) for k in range(5)]


def test_a_pass_downwards_from_zero_has_its_speed() -> None:
    """Passes at 10°/s and −30°/s start at 0° and have targets within one turn."""
    slow, fast = _steady(FACES, 10.0), _steady(-FACES, 30.0)
    speed = reference_speed(_reference([slow, (np.mod(fast[0], 360.0), fast[1])]))
    assert speed is not None
    np.testing.assert_allclose(np.degrees(speed), np.repeat([10.0, -30.0], 24))
