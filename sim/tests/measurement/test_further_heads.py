"""Tests how sets of three and four heads are read, written, joined and refused."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from arctrue.measurement import (
    Capture,
    JoinError,
    MeasurementError,
    MeasurementSet,
    Table,
    joined,
    read_measurement_set,
    write_measurement_set,
)

COUNTS = 1 << 24
PLACES_DEG = (0.0, 33.0, 162.5, 300.5)


def of_heads(
    places_deg: tuple[float, ...], *, wrapped: bool = False, late_s: float = 0.0
) -> MeasurementSet:
    """Return a set whose heads stand at these places and count 1.25 turns at constant speed."""
    time_s = np.arange(15_000) * 1e-3
    angle_deg = 30.0 * time_s + 20.0
    counts = [
        np.round((angle_deg + place) / 360.0 * COUNTS).astype(np.int64) for place in places_deg
    ]
    if wrapped:
        counts = [one % COUNTS for one in counts]
    further = dict(zip(("head3_counts", "head4_counts"), counts[2:], strict=False))
    return MeasurementSet(
        Table(counts_per_rev=COUNTS, head_places_deg=places_deg),
        Capture(np.zeros(time_s.size, int), time_s + late_s, counts[0], counts[1], **further),
    )


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_a_set_reads_as_it_was_written(tmp_path: Path, heads: int) -> None:
    written = of_heads(PLACES_DEG[:heads])
    write_measurement_set(tmp_path, written)
    assert "head_separation_deg" not in (tmp_path / "measurement.toml").read_text("utf-8")
    read = read_measurement_set(tmp_path)
    assert read.warnings == ()
    assert read.table == written.table
    assert read.table.head_separation_deg == 33.0
    assert read.capture is not None
    assert len(read.capture.heads) == heads
    for one, other in zip(read.capture.heads, written.capture.heads, strict=True):
        np.testing.assert_array_equal(one, other)


def test_a_separation_is_the_place_of_the_second_of_two_heads() -> None:
    assert Table(head_separation_deg=33.0).places_deg == (0.0, 33.0)
    assert Table().places_deg is None


def test_every_head_counts_on_past_the_turn(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, of_heads(PLACES_DEG, wrapped=True))
    read = read_measurement_set(tmp_path)
    assert read.capture is not None
    first = read.capture.head1_counts
    for head, place in zip(read.capture.heads, PLACES_DEG, strict=True):
        assert np.max(np.abs(head - first - place / 360.0 * COUNTS)) <= 1.0


@pytest.mark.parametrize(
    ("places", "said"),
    [
        ((1.0, 33.0), "expected 0 for head 1"),
        ((0.0, 33.0, 393.0 - 360.0), "a place of its own"),
    ],
)
def test_places_that_no_table_has_are_refused(places: tuple[float, ...], said: str) -> None:
    with pytest.raises(ValueError, match=said):
        Table(head_places_deg=places)


def test_a_separation_that_contradicts_the_places_is_refused(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, of_heads(PLACES_DEG))
    toml = tmp_path / "measurement.toml"
    text = toml.read_text("utf-8").replace("[table]", "[table]\nhead_separation_deg = 34.0")
    toml.write_text(text, "utf-8")
    with pytest.raises(MeasurementError, match="leave out head_separation_deg"):
        read_measurement_set(tmp_path)


def test_more_heads_than_places_are_refused(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, of_heads(PLACES_DEG))
    toml = tmp_path / "measurement.toml"
    toml.write_text(toml.read_text("utf-8").replace(", 300.5]", "]"), "utf-8")
    with pytest.raises(MeasurementError, match="a place for each of the 4 heads"):
        read_measurement_set(tmp_path)


def test_a_fourth_head_without_a_third_is_refused(tmp_path: Path) -> None:
    write_measurement_set(tmp_path, of_heads(PLACES_DEG[:3]))
    capture = tmp_path / "capture.csv"
    capture.write_text(capture.read_text("utf-8").replace("head3_counts", "head4_counts", 1))
    with pytest.raises(MeasurementError, match="head3_counts"):
        read_measurement_set(tmp_path)


def test_join_keeps_every_head_and_refuses_another_number() -> None:
    four = of_heads(PLACES_DEG)
    assert four.capture is not None
    later = replace(four, capture=replace(four.capture, head2_counts=four.capture.head2_counts + 1))
    whole, _ = joined([four, later], times="after")
    assert whole.capture is not None
    assert [head.size for head in whole.capture.heads] == [30_000] * 4
    assert whole.table == four.table
    with pytest.raises(JoinError, match="of another table"):
        joined([four, of_heads(PLACES_DEG[:3], late_s=100.0)])
    near = of_heads((0.0, 33.1, 162.6, 300.4), late_s=100.0)
    assert joined([four, near])[0].table == four.table
