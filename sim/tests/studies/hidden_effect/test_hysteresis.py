"""Tests that the diagnosis names hysteresis, that the export writes it to a lane (the correction of
one order) whose amplitude follows the direction, and that this lane removes it from the output."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.studies.hidden_effect.small import run_small

from arctrue.instrument import EdgeTrack, InstrumentError
from arctrue.studies.hidden_effect.reference import counts_standing
from arctrue.studies.hidden_effect.result import HiddenResult

REVERSAL_ARCSEC = 2 * 64.0
"""Reversal error in arcseconds: ±1″ with 2²⁴ counts per turn, and 64 times as much with 2¹⁸
counts."""
COUNT_ARCSEC = 1_296_000 / (1 << 18)


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> HiddenResult:
    return run_small("hysteresis", tmp_path_factory.mktemp("hysteresis"))


@pytest.mark.large
def test_it_is_named_with_its_size(result: HiddenResult) -> None:
    assert result.diagnosed.effect == "hysteresis"
    error = result.diagnosed.model.effects[-1].parameters["reversal_error"]
    # The mean of each direction comes from 24 whole counts, so that the difference errs by less
    # than half a count.
    assert error.value == pytest.approx(REVERSAL_ARCSEC, abs=0.5 * COUNT_ARCSEC)


@pytest.mark.large
def test_it_becomes_a_lane_that_follows_the_direction(result: HiddenResult) -> None:
    extension = result.export.coefficients.extension
    assert extension is not None
    assert [name for _, name in extension.modulators] == ["direction"]
    assert not any("hysteresis" in text for text in result.export.left_out)


@pytest.mark.large
def test_the_output_loses_it_and_without_the_lane_keeps_it(result: HiddenResult) -> None:
    """The output shows the whole reversal error at new stations without the lane, and at most 6″
    with the lane (a count is 4.9″)."""
    assert result.reversal_arcsec is not None
    without, left = (result.reversal_arcsec[key] for key in ("paper", "corrected"))
    assert without == pytest.approx(REVERSAL_ARCSEC, abs=0.5 * COUNT_ARCSEC)
    assert abs(left) <= 6.0


def track(position: list[int], *, dropped: int = 0) -> EdgeTrack:
    number = len(position)
    none = np.zeros(0)
    return EdgeTrack(
        counts_per_rev=100,
        clock=np.arange(number, dtype=np.int64) * 10,
        position=np.array(position, dtype=np.int64),
        true_angle_rad=np.zeros(number),
        bin_edges=np.zeros(0, dtype=np.int64),
        bin_mean_counts=none,
        bin_lowest_counts=none,
        bin_highest_counts=none,
        edges=number,
        dropped=dropped,
    )


def test_levels_become_counts() -> None:
    # The edges cross the levels 1, 2, 3 upwards, then 3 and 2 downwards, then 2 and 3 upwards
    # again.
    seen = counts_standing(track([1, 2, 3, 3, 2, 2, 3]), np.arange(7) * 10.0 + 5)
    assert seen.tolist() == [1, 2, 3, 2, 1, 2, 3]
    # The edges cross the same level upwards and downwards.
    seen = counts_standing(track([4, 4, 4, 4, 3]), np.arange(5) * 10.0 + 5)
    assert seen.tolist() == [4, 3, 4, 3, 2]


def test_missing_edges_are_refused() -> None:
    with pytest.raises(InstrumentError, match="every edge"):
        counts_standing(track([1, 2], dropped=1), np.array([15.0]))
    with pytest.raises(InstrumentError, match="every edge"):
        counts_standing(track([1, 2]), np.array([-1.0]))
