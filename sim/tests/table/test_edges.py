"""Tests of count edges against dense sampling, and of the wires A, B and Z against the paper."""

from pathlib import Path

import numpy as np
import pytest

from arctrue.table import (
    DiscEccentricity,
    GraduationHarmonics,
    Motion,
    PinEvents,
    RotaryTable,
    TableState,
    TooFastError,
    angle_of_reading,
    clocked_pins,
    count_edges,
    decode_quadrature,
    pin_states,
    two_heads,
)
from arctrue.table.crossings import solve_brackets

ARCSEC = np.deg2rad(1 / 3600)
EFFECTS = (
    DiscEccentricity(300e-6, 1.0),
    GraduationHarmonics((2, 5), (60 * ARCSEC, 30 * ARCSEC), (0.3, 2.0)),
)
REVERSING = Motion((0.0, 0.2, 1.2, 2.4, 3.0), (0.0, 4.0, 4.0, -3.0, 0.0), -0.9, 0.002, 7)


def table_of(**settings: object) -> RotaryTable:
    return RotaryTable(two_heads(), EFFECTS, counts_per_rev=4096, **settings)  # type: ignore[arg-type]


@pytest.mark.parametrize("rounding", ["floor", "nearest"])
@pytest.mark.parametrize("head", [0, 1])
def test_edges_are_where_a_dense_scan_finds_them(rounding: str, head: int) -> None:
    table = table_of(rounding=rounding)
    edges = count_edges(table, head, REVERSING)
    time_s = np.linspace(0, REVERSING.duration_s, 2_000_001)
    counts = table.counts(head, REVERSING.state(time_s))
    changes = np.flatnonzero(np.diff(counts))
    assert edges.first_count == counts[0]
    np.testing.assert_array_equal(edges.count, counts[changes + 1])
    # Each edge lies between the two scan points that show the change.
    assert np.all(edges.time_s >= time_s[changes] - 1e-12)
    assert np.all(edges.time_s <= time_s[changes + 1] + 1e-12)
    assert np.all(np.abs(np.diff(edges.count)) <= 1)
    assert (edges.count.max() - edges.count.min()) > 4096 * 0.6


def test_reading_at_an_edge_is_the_whole_count() -> None:
    table = table_of()
    edges = count_edges(table, 1, REVERSING)
    reading = table.reading_rad(1, REVERSING.state(edges.time_s)) / table.count_rad
    np.testing.assert_allclose(reading, np.round(reading), rtol=0, atol=2e-7)


def test_noise_moves_edges_by_its_size_and_never_past_each_other() -> None:
    quiet = table_of()
    noisy = table_of(noise_rad=0.05 * quiet.count_rad)
    motion = Motion.steady(2.0, 3.5, start_rad=-0.7)
    clean = count_edges(quiet, 0, motion)
    edges = count_edges(noisy, 0, motion, np.random.default_rng(5))
    np.testing.assert_array_equal(clean.count, edges.count)
    assert np.all(np.diff(edges.time_s) >= 0)
    moved = (edges.true_angle_rad - clean.true_angle_rad) / quiet.count_rad
    # A standard deviation from 4,500 draws has a relative standard error of 1 %; the test allows
    # five of these errors.
    assert moved.std() == pytest.approx(0.05, rel=0.05)
    assert abs(moved.mean()) < 0.05 * 5 / np.sqrt(moved.size)


def test_angle_of_reading_inverts_the_reading() -> None:
    table = table_of()
    reading = np.linspace(-5000.0, 9000.0, 777)
    for head in (0, 1):
        angle = angle_of_reading(table, head, reading)
        again = table.reading_rad(head, TableState.at_rest(angle)) / table.count_rad
        np.testing.assert_allclose(again, reading, rtol=0, atol=2e-7)


def test_bracket_without_crossing_is_an_error() -> None:
    with pytest.raises(ArithmeticError, match=r"no crossing of 3\.0"):
        solve_brackets(
            lambda x: x, np.array([0.0, 0.0]), np.array([1.0, 2.0]), np.array([0.5, 3.0]),
            tolerance=1e-9,
        )  # fmt: skip


def test_solver_takes_a_curve_that_defeats_the_secant() -> None:
    roots = np.array([0.01, 0.3, 0.999])
    found = solve_brackets(lambda x: x**9, np.zeros(3), np.ones(3), roots**9, tolerance=1e-22)
    np.testing.assert_allclose(found, roots, rtol=1e-3)


def test_wires_follow_figure_4() -> None:
    up = pin_states(np.arange(8), 4096)
    assert [(int(level) & 1, int(level) >> 1 & 1) for level in up[:4]] == [
        (0, 0), (1, 0), (1, 1), (0, 1),
    ]  # fmt: skip
    assert (up >> 2).tolist() == [1, 0, 0, 0, 0, 0, 0, 0]
    wide = pin_states(np.arange(-4, 8), 8, index_width_counts=3)
    assert (wide >> 2).tolist() == [0, 0, 0, 0, 1, 1, 1, 0, 0, 0, 0, 0]


def test_played_pins_decode_to_the_counts_of_both_heads() -> None:
    table = table_of()
    heads = [count_edges(table, head, REVERSING) for head in (0, 1)]
    clock_hz = 50_000.0
    events = clocked_pins(heads, table.counts_per_rev, clock_hz)
    assert np.all(np.diff(events.clock) > 0)
    for number, edges in enumerate(heads):
        shift = 3 * number
        step, illegal = decode_quadrature(
            events.first_levels >> shift & 7, events.levels >> shift & 7
        )
        assert illegal.size == 0
        counts = edges.first_count + np.cumsum(step)
        clock = np.arange(int(REVERSING.duration_s * clock_hz))
        shown = np.concatenate([[edges.first_count], counts])[
            np.searchsorted(events.clock, clock, side="right")
        ]
        expected = table.counts(number, REVERSING.state(clock / clock_hz))
        # If an edge coincides with a clock, the tolerance of the solver decides on which side of
        # the clock the edge falls.
        assert np.count_nonzero(shown != expected) <= 1


def test_two_edges_on_one_clock_are_refused() -> None:
    edges = count_edges(table_of(), 0, Motion.steady(4.0, 1.0))
    with pytest.raises(TooFastError, match="head 1: two count edges on one clock"):
        clocked_pins([edges], 4096, 2000.0)


def test_decoder_of_the_output_reports_an_illegal_step() -> None:
    step, illegal = decode_quadrature(0, np.array([1, 3, 2, 3, 0, 2], dtype=np.uint8))
    assert step.tolist() == [1, 1, 1, -1, 0, -1]
    assert illegal.tolist() == [4]


def test_pin_events_survive_the_file(tmp_path: Path) -> None:
    events = PinEvents(5, np.array([3, 4, 90]), np.array([1, 63, 0], dtype=np.uint8))
    file = tmp_path / "pins.txt"
    events.write(file)
    assert file.read_text() == "0 5\n3 1\n1 63\n86 0\n"
    again = PinEvents.read(file)
    assert again.first_levels == 5
    np.testing.assert_array_equal(again.clock, events.clock)
    np.testing.assert_array_equal(again.levels, events.levels)
    with pytest.raises(ValueError, match="no pin events"):
        PinEvents.read(tmp_path / "missing.txt")
