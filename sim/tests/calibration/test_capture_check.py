"""Tests that the check refuses every unusable capture, and that the exception has the right reason
and sample."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import CaptureRefusedError, whole_turns
from arctrue.measurement import Capture

from .synthetic import COUNTS, Disc, capture_of, turn_angles

HEADS = Disc().heads(turn_angles(12_000))


def refusal(heads: np.ndarray | Capture, most_order: int = 32, runs=None) -> CaptureRefusedError:
    capture = heads if isinstance(heads, Capture) else capture_of([heads])
    with pytest.raises(CaptureRefusedError) as caught:
        whole_turns(capture, COUNTS, runs, most_order)
    return caught.value


def test_good_turn_is_taken_whole() -> None:
    (turn,) = whole_turns(capture_of([HEADS]), COUNTS, None, 32)
    assert (turn.turns, turn.samples) == (1, 12_000)


def test_closing_sample_and_rest_are_left_out() -> None:
    heads = Disc().heads(turn_angles(12_000, 3)[:25_000])
    (turn,) = whole_turns(capture_of([heads]), COUNTS, None, 32)
    assert (turn.turns, turn.samples) == (2, 24_000)


@pytest.mark.parametrize("kept", [2, 6_000, 11_990])
def test_short_of_a_turn(kept: int) -> None:
    found = refusal(HEADS[:, :kept])
    assert (found.reason, found.run, found.sample) == ("short_of_a_turn", 0, kept - 1)
    assert "of a turn" in str(found)


def test_reversal() -> None:
    heads = np.concatenate((HEADS[:, :8_000], HEADS[:, 7_998:3_000:-1]), axis=1)
    found = refusal(heads)
    assert (found.reason, found.sample) == ("reversal", 8_000)
    back = HEADS[0, 7_998] - HEADS[0, 7_999]
    assert f"a reversal: head 1 steps by {back} counts" in str(found)


def test_a_stop_before_a_reversal_is_a_wrong_step() -> None:
    """The table stands still for one sample before it turns back: the first fault is the step of 0
    counts."""
    heads = np.concatenate((HEADS[:, :8_000], HEADS[:, 7_999:3_000:-1]), axis=1)
    found = refusal(heads)
    assert (found.reason, found.sample) == ("wrong_step", 8_000)
    assert "a wrong step: head 1 steps by 0 counts" in str(found)


@pytest.mark.parametrize("head", [0, 1])
def test_jump_of_a_revolution(head: int) -> None:
    heads = HEADS.copy()
    heads[head, 5_000:] += COUNTS
    found = refusal(heads)
    assert (found.reason, found.sample) == ("jump", 5_000)
    assert f"head {head + 1}" in str(found)
    assert "1 whole turn is missing" in str(found)


def test_jump_by_lost_samples() -> None:
    found = refusal(np.delete(HEADS, slice(5_000, 5_003), axis=1))
    assert (found.reason, found.sample) == ("jump", 5_000)


@pytest.mark.parametrize("counts", [200, -200])
def test_wrong_step(counts: int) -> None:
    heads = HEADS.copy()
    heads[1, 700:] += counts  # 14 % of a step of 1398 counts
    found = refusal(heads)
    assert (found.reason, found.sample) == ("wrong_step", 700)


def test_ten_percent_is_allowed() -> None:
    heads = HEADS.copy()
    heads[:, 700:] += 130
    assert whole_turns(capture_of([heads]), COUNTS, None, 32)


def test_over_speed_of_the_decoder() -> None:
    found = refusal(replace(capture_of([HEADS]), clock_hz=1e6))
    assert (found.reason, found.sample) == ("over_speed", 1)
    assert "1 MHz" in str(found)


def test_over_speed_of_the_sampling() -> None:
    found = refusal(Disc().heads(turn_angles(60)), most_order=32)
    assert found.reason == "over_speed"
    assert "60.0 samples" in str(found)


def test_standstill_empty_and_not_a_number() -> None:
    assert refusal(np.zeros((2, 500), dtype=np.int64)).reason == "short_of_a_turn"
    assert refusal(np.zeros((2, 0), dtype=np.int64)).reason == "empty"
    capture = capture_of([HEADS])
    capture.time_s[77] = np.nan
    found = refusal(capture)
    assert (found.reason, found.sample) == ("nan", 77)


def test_heads_that_count_against_each_other() -> None:
    assert refusal(np.stack((HEADS[0], -HEADS[1]))).reason == "inconsistent_heads"


def test_runs_at_the_lowest_speed_are_chosen() -> None:
    slow = Disc().heads(turn_angles(3_000))
    back = Disc().heads(turn_angles(3_000, direction=-1))
    # A run with the same steps in a third of the time has three times the speed.
    capture = capture_of([slow, slow, back], [1e-3, 1e-3 / 3, 1e-3])
    assert [turn.run for turn in whole_turns(capture, COUNTS)] == [0, 2]
    assert [turn.run for turn in whole_turns(capture, COUNTS, [1])] == [1]
    with pytest.raises(ValueError, match="run 9 is not in the capture, which has runs 0, 1, 2"):
        whole_turns(capture, COUNTS, [9])


def test_only_chosen_runs_are_judged() -> None:
    capture = capture_of([HEADS, HEADS[:, :99]])
    assert refusal(capture).run == 1
    assert whole_turns(capture, COUNTS, [0])


def test_coarse_counts_round_by_one() -> None:
    disc = Disc(counts_per_rev=4096)
    heads = disc.heads(turn_angles(1_000))
    (turn,) = whole_turns(capture_of([heads]), 4096, None, 8)
    assert turn.turns == 1


def masked(capture: Capture, *samples: int) -> Capture:
    mask = np.zeros(capture.run.size, dtype=bool)
    mask[list(samples)] = True
    return replace(capture, mask=mask)


def test_a_masked_jump_is_not_judged() -> None:
    """300,000 counts in 1 ms are three times the 100,000 clocks of 100 MHz."""
    heads = HEADS.copy()
    heads[:, 500] += 300_000
    capture = capture_of([heads])
    assert refusal(capture).sample == 500
    (turn,) = whole_turns(masked(capture, 500), COUNTS, None, 32)
    assert (turn.samples, turn.masked) == (11_999, 1)


def test_the_time_between_unmasked_neighbours_is_judged() -> None:
    capture = capture_of([HEADS])
    capture.time_s[501:] -= capture.time_s[501] - capture.time_s[499]
    found = refusal(masked(capture, 500))
    assert (found.reason, found.sample) == ("over_speed", 501)
    steps = HEADS[0, 501] - HEADS[0, 499]
    assert f"{steps} counts in 0.000000 s" in str(found)


def test_a_masked_time_that_is_not_a_number_is_not_judged() -> None:
    capture = capture_of([HEADS, HEADS])
    capture.time_s[77] = np.nan
    turns = whole_turns(masked(capture, 77), COUNTS)
    assert [turn.run for turn in turns] == [0, 1]
    capture.time_s[79] = np.nan
    found = refusal(masked(capture, 77), runs=[0])
    assert (found.reason, found.sample) == ("nan", 79)
