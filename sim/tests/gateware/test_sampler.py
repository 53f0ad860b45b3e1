"""Tests that the captures of the sampler's model follow the definition of a capture."""

import numpy as np
import pytest
from sim.tests.gateware.sampler_scenarios import SCENARIOS, Scenario, stimuli

from arctrue.gateware.sampler import (
    FLAG_NAMES,
    FULL_BEFORE_TURN,
    OVERRUN,
    SampledBank,
    SamplerInputs,
    SamplerTrace,
    sampler,
)


def played(scenario: Scenario, seed: int) -> tuple[dict[str, np.ndarray], SamplerTrace]:
    columns = stimuli(scenario)
    rate = 2 / (1 + sum(scenario.hold))
    random = np.random.default_rng(seed)
    columns["release_bank"] = random.random(len(columns["reset"])) < rate
    return columns, sampler(SamplerInputs(**columns), scenario.depth)


def turned(columns: dict[str, np.ndarray], clocks: np.ndarray) -> np.ndarray:
    """Return the distance of head 1 from its position in the first of ``clocks``, in counts, even
    across the wrap."""
    counts = columns["turn_position1"][clocks]
    return (counts - counts[0] + 2**31) % 2**32 - 2**31


def check_capture(
    scenario: Scenario, columns: dict[str, np.ndarray], trace: SamplerTrace, capture: SampledBank
) -> None:
    clocks = capture.sample_clocks
    inside = slice(clocks[0], clocks[-1] + 1)
    # The values of both heads come from the clock of the sample, and no trigger between the first
    # and the last sample is missing.
    assert (capture.samples[:, 0] == columns["turn_position1"][clocks]).all()
    assert (capture.samples[:, 1] == columns["turn_position2"][clocks]).all()
    assert clocks.tolist() == (clocks[0] + np.flatnonzero(trace.trigger[1:][inside])).tolist()
    assert capture.start_time == columns["timestamp"][clocks[0]]
    # The capture ends with the first sample that is a turn away from the first one, or with the
    # last word of the bank.
    away = np.abs(turned(columns, clocks)) >= scenario.counts_per_rev
    assert not away[:-1].any()
    assert away[-1] or len(clocks) == scenario.depth
    assert len(clocks) <= scenario.depth
    assert bool(capture.flags & FULL_BEFORE_TURN) == (not away[-1])
    # During the capture sampling was enabled and both heads had seen their index; the header
    # contains every flag.
    assert columns["enable"][inside].all()
    assert (columns["flags"][inside] & 0b11 == 0b11).all()
    assert capture.flags & 0xFF == np.bitwise_or.reduce(columns["flags"][inside])


@pytest.mark.parametrize("name", SCENARIOS)
@pytest.mark.parametrize("seed", range(3))
def test_captures_are_whole_and_owned(name: str, seed: int) -> None:
    scenario = SCENARIOS[name]
    columns, trace = played(scenario, seed)
    assert trace.captures
    for capture in trace.captures:
        check_capture(scenario, columns, trace, capture)
        assert trace.bank_ready[capture.clock]
        assert not trace.bank_ready[capture.clock - 1]
        assert trace.ready_bank[capture.clock] == capture.bank
    # The banks alternate, and the header reports an overrun exactly if a turn was dropped in
    # between.
    for earlier, later in zip(trace.captures, trace.captures[1:], strict=False):
        if later.sequence:
            assert later.sequence == earlier.sequence + 1
            assert later.bank == 1 - earlier.bank
            assert later.sample_clocks[0] > earlier.sample_clocks[-1]
            between = slice(earlier.sample_clocks[-1] + 2, later.sample_clocks[-1] + 2)
            assert bool(later.flags & OVERRUN) == bool(trace.capture_overrun[between].any())


def test_next_turn_starts_with_the_next_sample() -> None:
    columns = stimuli(SCENARIOS["up"])
    trace = sampler(SamplerInputs(**columns, release_bank=True), depth=16)
    clocks = np.concatenate([capture.sample_clocks for capture in trace.captures])
    assert len(trace.captures) > 20
    assert (np.diff(clocks) == 10).all()
    assert not trace.capture_overrun.any()


def test_release_is_in_time_up_to_the_clock_after_the_closing_sample() -> None:
    columns = stimuli(SCENARIOS["up"])
    free = sampler(SamplerInputs(**columns, release_bank=True), depth=16)
    closing = int(free.captures[1].sample_clocks[-1])
    for late, overruns in ((1, 0), (2, 1)):
        release = np.zeros(len(columns["reset"]), bool)
        release[closing + late] = True
        trace = sampler(SamplerInputs(**columns, release_bank=release), depth=16)
        assert trace.overrun_count[closing + 10] == overruns


def test_a_jump_in_the_clock_after_the_first_sample_closes_no_turn() -> None:
    # No decoder makes such a jump. The entity checks the distance only from the second clock after
    # the first sample on.
    position = np.where(np.arange(20) < 3, 0, 100)
    trace = sampler(SamplerInputs(position, position, counts_per_rev=50, sample_period=1), depth=16)
    assert trace.captures[0].sample_clocks.tolist() == [0, 1, 2, 3]
    position = np.where(np.arange(20) < 1, 0, 100)
    trace = sampler(SamplerInputs(position, position, counts_per_rev=50, sample_period=1), depth=16)
    assert trace.captures[0].sample_clocks.tolist() == [0, 1, 2]


def test_unread_bank_stays_as_it_is() -> None:
    columns = stimuli(SCENARIOS["up"])
    trace = sampler(SamplerInputs(**columns), depth=16)
    assert len(trace.captures) == 1
    assert trace.bank_ready[trace.captures[0].clock :].all()
    assert trace.overrun_count[-1] == trace.capture_overrun.sum() > 20


def test_twelve_thousand_a_turn_fit_a_bank() -> None:
    # As at 30 degrees per second and 1 kHz, samples are 2**24 / 12,000 counts apart; here a sample
    # comes in every clock.
    position = np.arange(13_000) * 2**24 // 12_000
    trace = sampler(SamplerInputs(position, position + 5, counts_per_rev=2**24, sample_period=1))
    assert len(trace.captures) == 1
    assert len(trace.captures[0].samples) == 12_001
    assert trace.captures[0].flags == 0b11


def test_flag_names_are_the_header_bits() -> None:
    assert len(FLAG_NAMES) == 10
    assert (OVERRUN, FULL_BEFORE_TURN) == (1 << 8, 1 << 9)
