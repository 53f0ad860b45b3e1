"""Tests that zero_witness compares each mark correctly with the counts of the other head."""

from __future__ import annotations

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import FallingEdge

CLOCKS = 30_000
BETWEEN_MARKS = 12


@cocotb.test()
@cocotb.parametrize(
    (("turn", "tolerance", "start"), [(40, 2, -20), (2**24, 0, 2**31 - 5), (9, 3, -(2**31))])
)
async def agrees_where_the_other_head_counted_a_turn(dut, turn, tolerance, start) -> None:
    """`agrees` is high exactly for marks that are one turn, within the tolerance, from the last
    trusted mark; other marks are at the same place, two turns away, or up to 2 counts beyond the
    tolerance."""
    random = np.random.default_rng(turn)
    marks = np.arange(20, CLOCKS - 10, BETWEEN_MARKS)
    turns = random.choice([-2, -1, -1, -1, 0, 1, 1, 1, 2], marks.size)
    away = turns * turn + random.integers(-tolerance - 2, tolerance + 3, marks.size)
    at_mark = start + np.cumsum(away)
    # Between the marks the position is random, because the entity uses it only at a mark.
    position = random.integers(-(2**31), 2**31, CLOCKS)
    position[marks - 1] = at_mark
    trusted = random.random(marks.size) < 0.7
    trusted[0] = True
    forgets = random.random(marks.size) < 0.05
    Clock(dut.clock, 10, unit="ns", impl="gpi").start()
    dut.counts_per_rev.value = turn
    dut.tolerance.value = tolerance
    for name in ("reset", "rearm", "index_strobe", "trusted", "other_position"):
        getattr(dut, name).value = 0
    dut.reset.value = 1
    await FallingEdge(dut.clock)
    dut.reset.value = 0
    said = {}
    of_mark = {int(clock): place for place, clock in enumerate(marks)}
    for clock in range(CLOCKS):
        dut.other_position.value = int(position[clock] + 2**31) % 2**32 - 2**31
        # The position of the other head at a mark is its position 2 clocks before the strobe.
        dut.index_strobe.value = int(clock - 1 in of_mark)
        place = of_mark.get(clock - 4, -1)
        dut.trusted.value = int(place >= 0 and trusted[place])
        place = of_mark.get(clock - 8, -1)
        dut.rearm.value = int(place >= 0 and forgets[place])
        await FallingEdge(dut.clock)
        if clock - 2 in of_mark:
            said[of_mark[clock - 2]] = int(dut.agrees.value)
    known: int | None = None
    expected = {}
    for place in range(marks.size):
        off = np.inf if known is None else abs(abs(int(at_mark[place]) - known) - turn)
        expected[place] = int(off <= tolerance)
        known = int(at_mark[place]) if trusted[place] else known
        known = None if forgets[place] else known
    wrong = [place for place in expected if said[place] != expected[place]]
    assert not wrong, f"mark {wrong[0]}: {said[wrong[0]]}, expected {expected[wrong[0]]}"
    assert 0.05 < np.mean(list(said.values())) < 0.8
