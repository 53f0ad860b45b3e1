"""Compares error_compensation with its model in cocotb tests."""

from __future__ import annotations

import os
from typing import Any

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge
from numpy.typing import NDArray

from arctrue.gateware.correction_ramp import HOLD
from arctrue.gateware.error_compensation import correction_limit, error_compensation
from arctrue.generated.number_formats import (
    COMPENSATION_LATENCY,
    MEAN_TERM_FRACTION,
    PAIR_FRACTION,
    PAIR_WIDTH,
)

LANES = int(os.environ.get("LANES", "32"))
PAIRS = (LANES + 1) // 2
FOLD = int(os.environ.get("FOLD", "1"))
MEAN = os.environ.get("MEAN", "false") == "true"
CLOCKS = 1500
# PAIR_MAX is the sum of two terms with amplitudes at the end of s13.11 and a cosine of 1 + 2⁻¹³.
# The cosine of the gateware exceeds 1 by at most an eighth of 2⁻¹³.
PAIR_MAX = 2 * (8192 + 1) << PAIR_FRACTION
OFFSET_MAX = 2**24 - 1


async def start(dut: Any, counts_per_rev: int, ramp_rate: int) -> None:
    dut.reset.value = 1
    for name in (
        "pair_sums",
        "offset",
        "angle",
        "position",
        "apply",
        "swap_marker",
        "zero_moved",
        "put_back",
        "referenced",
        "mean_term",
        "jumped",
        "jump",
    ):
        getattr(dut, name).value = 0
    dut.counts_per_rev.value = counts_per_rev
    dut.ramp_rate.value = ramp_rate
    dut.ramp_acceleration.value = 0
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(4):
        await RisingEdge(dut.clock)
    dut.reset.value = 0


def flat(pair_sums: NDArray[np.int64]) -> int:
    return sum(
        (word % 2**PAIR_WIDTH) << (PAIR_WIDTH * pair)
        for pair, word in enumerate(pair_sums.tolist())
    )


async def compare(
    dut: Any,
    pair_sums: NDArray[np.int64],
    offset: NDArray[np.int64],
    angle: NDArray[np.int64],
    position: NDArray[np.int64],
    apply: NDArray[np.bool_],
    swap_marker: NDArray[np.bool_],
    counts_per_rev: int,
    ramp_rate: int,
) -> Any:
    """Run VHDL and model with the same inputs and compare their outputs; return the model's
    outputs."""
    await start(dut, counts_per_rev, ramp_rate)
    seen = []
    clocks = angle.size
    for clock in range(clocks + COMPENSATION_LATENCY):
        now = min(clock, clocks - 1)
        dut.pair_sums.value = flat(pair_sums[now])
        dut.offset.value = int(offset[now])
        dut.angle.value = int(angle[now])
        dut.position.value = int(position[now])
        dut.apply.value = int(apply[now])
        dut.swap_marker.value = int(swap_marker[now])
        await RisingEdge(dut.clock)
        seen.append(
            (
                dut.corrected_angle.value.to_unsigned(),
                dut.corrected_position.value.to_signed(),
                dut.correction.value.to_signed(),
                int(dut.correction_limited.value),
                int(dut.ramp_busy.value),
            )
        )
    model = error_compensation(
        pair_sums, offset, angle, position, apply, swap_marker, counts_per_rev, ramp_rate
    )
    expected = list(zip(*(output.tolist() for output in model[:5]), strict=True))
    for clock in range(clocks):
        found = seen[clock + COMPENSATION_LATENCY]
        assert found == expected[clock], f"clock {clock}: {found}, expected {expected[clock]}"
    assert model.corrected_angle.min() >= 0
    assert model.corrected_angle.max() < counts_per_rev
    return model


@cocotb.test()
@cocotb.parametrize(counts_per_rev=[4, 5, 1000, 65536, 12_345_678, 2**24])
async def random_input(dut: Any, counts_per_rev: int) -> None:
    """Outputs equal the model's for random pair sums; in short turns some corrections are
    clipped."""
    rng = np.random.default_rng(counts_per_rev)
    largest = min(PAIR_MAX, (2 * counts_per_rev << PAIR_FRACTION) // max(1, PAIRS // 2))
    offset_max = min(OFFSET_MAX, counts_per_rev << 9)
    model = await compare(
        dut,
        rng.integers(-largest, largest + 1, (CLOCKS, PAIRS)),
        rng.integers(-offset_max, offset_max + 1, CLOCKS),
        rng.integers(0, counts_per_rev, CLOCKS),
        rng.integers(-(2**31), 2**31, CLOCKS),
        np.cumsum(rng.random(CLOCKS) < 0.01) % 2 == 0,
        rng.random(CLOCKS) < 0.02,
        counts_per_rev,
        int(rng.integers(1, 2**32)),
    )
    assert model.correction.any()
    assert not model.correction_limited.all()
    if correction_limit(counts_per_rev) < 1000:
        assert model.correction_limited.any()


@cocotb.test()
@cocotb.parametrize(sign=[1, -1])
async def extremes(dut: Any, sign: int) -> None:
    """Outputs equal the model's for terms at the ends of their formats and angles at both ends of
    the turn; the position wraps."""
    counts_per_rev = 2**24
    model = await compare(
        dut,
        np.full((40, PAIRS), sign * PAIR_MAX, dtype=np.int64),
        np.full(40, sign * OFFSET_MAX, dtype=np.int64),
        np.where(np.arange(40) % 2 == 0, 0, counts_per_rev - 1),
        np.where(np.arange(40) % 3 == 0, 2**31 - 1, -(2**31)),
        np.arange(40) > 2,
        np.arange(40) % 8 == 5,
        counts_per_rev,
        2**32 - 1,
    )
    assert np.all(np.sign(model.correction[-5:]) == sign)


@cocotb.test()
async def every_fraction_rounds_once(dut: Any) -> None:
    """Angle and position are rounded in the same direction for corrections around each rounding
    boundary."""
    near = np.array([-2, -1, 0, 1, 2], dtype=np.int64)
    half = 1 << (PAIR_FRACTION - 1)
    total = np.concatenate([near + part * half for part in range(-7, 8)])
    pair_sums = np.zeros((total.size, PAIRS), dtype=np.int64)
    pair_sums[:, -1] = total
    zeros = np.zeros(total.size, dtype=np.int64)
    # `apply` rises while the correction is 0, so that the ramp has nothing to remove.
    before = np.zeros(HOLD, dtype=np.int64)
    model = await compare(
        dut,
        np.concatenate([np.zeros((HOLD, PAIRS), dtype=np.int64), pair_sums]),
        np.concatenate([before, zeros]),
        np.concatenate([before, zeros + 3]),
        np.concatenate([before, zeros - 5]),
        np.ones(total.size + HOLD, dtype=np.bool_),
        np.zeros(total.size + HOLD, dtype=np.bool_),
        1000,
        0,
    )
    exact = total / (1 << PAIR_FRACTION)
    assert np.all(np.abs(-5 - model.corrected_position[HOLD:] - exact) <= 0.5)
    assert np.all((model.corrected_position[HOLD:] + 8 - model.corrected_angle[HOLD:]) % 1000 == 0)


@cocotb.test()
@cocotb.parametrize(fold=[FOLD])
async def folded_sums(dut: Any, fold: int) -> None:
    """If the pair sums of an angle arrive in FOLD clocks, the outputs equal those of a model that
    gets their sum, with the angle repeated for FOLD clocks.

    `zero_moved` may toggle in any clock; the zero of an angle moves if there was at least one
    toggle since the previous angle.
    """
    angles = 300
    counts_per_rev = 12_345_678
    rng = np.random.default_rng(fold)
    pair_sums = rng.integers(-PAIR_MAX // 8, PAIR_MAX // 8, (angles, fold, PAIRS))
    offset = rng.integers(-OFFSET_MAX, OFFSET_MAX, angles)
    angle = rng.integers(0, counts_per_rev, angles)
    position = rng.integers(-(2**31), 2**31, angles)
    apply = np.cumsum(rng.random(angles) < 0.03) % 2 == 0
    marker = rng.random(angles) < 0.1
    toggles = rng.random((angles, fold)) < 0.25 / fold
    level = np.cumsum(toggles) % 2
    moved = np.cumsum(toggles.any(axis=1)) % 2 == 1
    assert fold == 1 or (toggles.sum(axis=1) == 2).any(), "no angle with two toggles"
    put_back = np.cumsum(rng.integers(-(2**14), 2**14, angles))
    referenced = rng.random(angles) < 0.5
    ramp_rate = 2**31 + 4321
    await start(dut, counts_per_rev, ramp_rate)
    latency = COMPENSATION_LATENCY + fold - 1
    seen = []
    for clock in range(fold * angles + latency):
        now, slot = divmod(min(clock, fold * angles - 1), fold)
        last = slot == fold - 1 and clock < fold * angles
        dut.pair_sums.value = flat(pair_sums[now, slot])
        dut.first_sums.value = int(slot == 0 and clock < fold * angles)
        dut.last_sums.value = int(last)
        dut.zero_moved.value = int(level[min(clock, level.size - 1)])
        # The entity reads these inputs only together with the last pair sums of an angle.
        dut.offset.value = int(offset[now]) if last else -1
        dut.angle.value = int(angle[now]) if last else 0
        dut.position.value = int(position[now]) if last else 0
        dut.apply.value = int(apply[now]) if last else slot % 2
        dut.swap_marker.value = int(marker[now]) if last else 1
        dut.put_back.value = int(put_back[now]) % 2**16 if last else slot
        dut.referenced.value = int(referenced[now]) if last else slot % 2
        await RisingEdge(dut.clock)
        seen.append(
            (
                dut.corrected_angle.value.to_unsigned(),
                dut.corrected_position.value.to_signed(),
                dut.correction.value.to_signed(),
                int(dut.ramp_busy.value),
                int(dut.swap_done.value),
                int(dut.corrected_referenced.value),
            )
        )
    held = np.repeat(np.arange(angles), fold)
    first = np.arange(fold * angles) % fold == 0
    model = error_compensation(
        pair_sums.sum(axis=1)[held],
        offset[held],
        angle[held],
        position[held],
        apply[held],
        marker[held] & first,
        counts_per_rev,
        ramp_rate,
        zero_moved=moved[held],
        put_back=put_back[held],
    )
    columns = (*model[:3], model.ramp_busy, marker[held] & first, referenced[held])
    expected = list(zip(*(column.astype(np.int64).tolist() for column in columns), strict=True))
    for clock, found in enumerate(seen[latency:]):
        assert found == expected[clock], f"clock {clock}: {found}, expected {expected[clock]}"


@cocotb.test(skip=not MEAN)
async def mean_joins_before_the_rounding(dut: Any) -> None:
    """The mean's term is added to the correction before the rounding, as in the model; terms are
    random or at the ends of their format, and the carrier changes at swaps, even during a ramp.

    The jump of the reading at a change of the carrier does not appear in the corrected position.
    """
    rng = np.random.default_rng(LANES)
    counts_per_rev = 2**24
    clocks = 3000
    quarter = 1 << (PAIR_FRACTION - 2)
    pair_sums = np.full((clocks, PAIRS), quarter) + rng.integers(0, 2, (clocks, PAIRS))
    term_max = 3 * 2 * 2**16 << MEAN_TERM_FRACTION
    term = rng.integers(-(2**26), 2**26, clocks)
    term[:600] = 0  # a constant term, so that one ramp ends
    term[600:1200] = rng.integers(-term_max, term_max + 1, 600)
    term[1200:1204] = -term_max, term_max, term_max, -term_max
    swap = (rng.random(clocks) < 0.01) | (np.arange(clocks) == 100)
    changes = swap & ((rng.random(clocks) < 0.7) | (np.arange(clocks) == 100))
    jump = np.where(changes, rng.integers(-(2**15) + 1, 2**15, clocks), 0)
    position = 2**20 + np.cumsum(jump)
    angle = position % counts_per_rev
    ramp_rate = 2**32 - 1
    await start(dut, counts_per_rev, ramp_rate)
    seen = []
    for clock in range(clocks + COMPENSATION_LATENCY):
        now = min(clock, clocks - 1)
        dut.pair_sums.value = flat(pair_sums[now])
        dut.offset.value = -7
        dut.angle.value = int(angle[now])
        dut.position.value = int(position[now])
        dut.apply.value = 1
        dut.swap_marker.value = int(swap[now])
        dut.mean_term.value = int(term[now])
        dut.jumped.value = int(changes[now])
        dut.jump.value = int(jump[now])
        await RisingEdge(dut.clock)
        seen.append(
            (
                dut.corrected_angle.value.to_unsigned(),
                dut.corrected_position.value.to_signed(),
                dut.correction.value.to_signed(),
            )
        )
    model = error_compensation(
        pair_sums,
        -7,
        angle,
        position,
        np.ones(clocks, dtype=np.bool_),
        swap,
        counts_per_rev,
        ramp_rate,
        mean_term=term,
        jump=jump,
    )
    expected = list(zip(*(output.tolist() for output in model[:3]), strict=True))
    for clock, found in enumerate(seen[COMPENSATION_LATENCY:]):
        assert found == expected[clock], f"clock {clock}: {found}, expected {expected[clock]}"
    # Until the mean's term changes, only the ramp moves the output, by less than 2^-3 count per
    # clock plus the rounding, although the reading jumps by more than 1000 counts.
    steps = np.diff([row[1] for row in seen[COMPENSATION_LATENCY : COMPENSATION_LATENCY + 590]])
    assert np.abs(jump[:590]).max() > 1000
    assert np.abs(steps[5:]).max() <= 1


@cocotb.test()
async def latency_is_four_clocks(dut: Any) -> None:
    """At the ports, the outputs follow angle, position and pair sums by four clocks."""
    await start(dut, 2**24, 2**24)
    dut.apply.value = 1
    for _ in range(10):
        await RisingEdge(dut.clock)
    for name, value, output, expected in (
        ("angle", 1234, "corrected_angle", 1234),
        ("position", 77, "corrected_position", 77),
        ("pair_sums", 100 << PAIR_FRACTION, "correction", 100 << 11),
    ):
        getattr(dut, name).value = value
        clocks = 0
        await RisingEdge(dut.clock)
        while getattr(dut, output).value.to_signed() != expected:
            assert clocks < 20, name
            clocks += 1
            await RisingEdge(dut.clock)
        assert clocks == COMPENSATION_LATENCY, f"{name}: {clocks} clocks"
