"""Tests the check of a capture: every reason for which the C code refuses a capture has an example,
and the faults of the samples are compared with the reference in Python."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import COUNTS, Disc, capture_of, turn_angles
from sim.tests.firmware.calibrator import (
    BOTH_INDICES_SEEN,
    capture_in_c,
    header_flag,
    verify,
)
from sim.tests.firmware.library import firmware

from arctrue.calibration import CaptureRefusedError, whole_turns

Counts = Any
SAMPLES = 1200
STEP = COUNTS // SAMPLES


def good(samples: int = SAMPLES, extra: int = 1) -> Counts:
    theta = turn_angles(samples, 2)[: samples + extra]
    return Disc().heads(theta, 0.1, np.random.default_rng(1))


def jump(counts: Counts) -> None:
    counts[0, 700:] += 5 * STEP


def lost_turn(counts: Counts) -> None:
    counts[1, 300:] += COUNTS


def reversal(counts: Counts) -> None:
    counts[0, 400:] -= round(1.5 * STEP)


def stop(counts: Counts) -> None:
    counts[:, :900] = counts[:, :1]


def opposite(counts: Counts) -> None:
    counts[1] = -counts[1]


def slow_step(counts: Counts) -> None:
    counts[1, 100:] -= round(0.3 * STEP)


def short(counts: Counts) -> None:
    counts[:, 1:] = (counts[:, 1:] - counts[:, :1]) * 95 // 100 + counts[:, :1]


SAMPLE_FAULTS: dict[str, tuple[Callable[[Counts], None], str, str]] = {
    "jump": (jump, "jump", "jump"),
    "lost turn": (lost_turn, "jump", "jump"),
    "reversal": (reversal, "reversal", "reversal"),
    "standing": (stop, "stands_still", "short_of_a_turn"),
    "opposite": (opposite, "inconsistent_heads", "inconsistent_heads"),
    "slow step": (slow_step, "wrong_step", "wrong_step"),
    "short": (short, "short_of_a_turn", "short_of_a_turn"),
}


def reference_verdict(counts: Counts, most_order: int = 32) -> tuple[str, int | None]:
    try:
        whole_turns(capture_of([counts], period_s=0.01), COUNTS, None, most_order)
    except CaptureRefusedError as refusal:
        return refusal.reason, refusal.sample
    return "none", None


@pytest.mark.parametrize("case", SAMPLE_FAULTS)
def test_faults_of_the_samples(case: str) -> None:
    spoil, reason, in_reference = SAMPLE_FAULTS[case]
    counts = good()
    spoil(counts)
    found, _, fault = verify(capture_in_c(counts))
    assert found == reason
    expected, sample = reference_verdict(counts)
    assert expected == in_reference
    if fault.sample:
        assert fault.sample == sample


HEADER_FAULTS = {
    "index_error1": "index_error",
    "index_error2": "index_error",
    "illegal1": "illegal_transition",
    "illegal2": "illegal_transition",
    "overspeed1": "edge_spacing",
    "overspeed2": "edge_spacing",
    "full_before_turn": "bank_full",
}


@pytest.mark.parametrize("flag", HEADER_FAULTS)
def test_faults_that_the_header_tells(flag: str) -> None:
    flags = BOTH_INDICES_SEEN | header_flag(flag)
    assert verify(capture_in_c(good(), flags=flags))[0] == HEADER_FAULTS[flag]


@pytest.mark.parametrize("flags", [0, 1, 2])
def test_an_index_that_was_not_seen(flags: int) -> None:
    assert verify(capture_in_c(good(), flags=flags))[0] == "index_not_seen"


def test_a_dropped_turn_before_is_no_fault() -> None:
    flags = BOTH_INDICES_SEEN | header_flag("overrun")
    assert verify(capture_in_c(good(), flags=flags))[0] == "none"


def test_an_empty_bank() -> None:
    assert verify(capture_in_c(good(), samples=0))[0] == "empty"
    assert verify(capture_in_c(good(), samples=1))[0] == "short_of_a_turn"


def test_more_than_a_turn() -> None:
    """The firmware refuses a bank with more counts than a turn. Because the sampler closes a bank
    after a turn, such a bank shows that the core has another number of counts per turn."""
    counts = good()
    assert verify(capture_in_c(counts, counts_per_rev=COUNTS // 2))[0] == "more_than_a_turn"


def test_too_few_samples_for_the_orders() -> None:
    counts = good(60)
    assert verify(capture_in_c(counts, period_clocks=10**6), 32)[0] == "over_speed"
    assert reference_verdict(counts)[0] == "over_speed"
    assert verify(capture_in_c(counts, period_clocks=10**6), 28)[0] == "none"
    assert reference_verdict(counts, 28)[0] == "none"


def test_more_than_an_edge_a_clock() -> None:
    counts = good()
    assert verify(capture_in_c(counts, period_clocks=STEP // 2))[0] == "over_speed"
    assert verify(capture_in_c(counts, period_clocks=2 * STEP))[0] == "none"
    assert verify(capture_in_c(counts, period_clocks=0))[0] == "none", "equal angles: no times"


def test_the_closing_sample_is_not_used() -> None:
    _, turn, _ = verify(capture_in_c(good()))
    assert turn.samples == SAMPLES
    assert whole_turns(capture_of([good()]), COUNTS)[0].samples == SAMPLES


def test_every_reason_has_a_name() -> None:
    ffi, library = firmware()
    names = [ffi.string(library.refusal_name(i)).decode() for i in range(library.REFUSALS)]
    assert len(set(names)) == library.REFUSALS
    assert ffi.string(library.refusal_name(library.REFUSALS)).decode() == "unknown"


@given(
    steps=st.lists(st.integers(-40, 60), min_size=1, max_size=60),
    offset=st.integers(-(2**31), 2**31 - 1),
)
@settings(max_examples=200, deadline=None)
def test_any_steps_get_the_reference_verdict(steps: list[int], offset: int) -> None:
    """For random walks the C code gives the verdict of the reference, which shows that the
    bisection in C finds the medians that sorting in Python finds."""
    head = np.concatenate(([0], np.cumsum(steps))).astype(np.int64)
    counts = np.stack((head, head + 33))
    expected, sample = "none", None
    turn = 360
    try:
        whole_turns(capture_of([counts]), turn, None, 1)
    except CaptureRefusedError as refusal:
        expected, sample = refusal.reason, refusal.sample
    found, _, fault = verify(capture_in_c(counts + offset, counts_per_rev=turn, period_clocks=0), 1)
    if found == "more_than_a_turn":
        assert expected == "none"
        return
    if expected == "short_of_a_turn":
        assert found in ("short_of_a_turn", "stands_still")
        return
    assert found == expected
    if found in ("jump", "reversal", "wrong_step"):
        assert fault.sample == sample


@given(st.binary(min_size=16, max_size=4000), st.integers(0, 1023), st.integers(4, 2**24))
@settings(max_examples=200, deadline=None)
def test_any_memory_gets_a_verdict(noise: bytes, flags: int, turn: int) -> None:
    words = np.frombuffer(noise[: len(noise) // 8 * 8], dtype="<i4").reshape(-1, 2)
    held = capture_in_c(words.T, flags=flags | BOTH_INDICES_SEEN, counts_per_rev=turn)
    assert verify(held)[0] != "unknown"
