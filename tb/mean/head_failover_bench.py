"""Compares the decisions and refusals of head_failover with those of its model, clock by clock.

The bench simulates prepared_sets and the banks: like prepared_sets, it ends a load with a swap if
``may_activate`` is high, and refuses the swap otherwise.
"""

from __future__ import annotations

import os
import random
from collections import Counter
from typing import Any

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from arctrue.gateware.head_failover import FailoverInputs, HeadFailover
from arctrue.generated.number_formats import OWN_WORDS_SET

HEADS = int(os.environ.get("HEADS", "4"))
INTERVAL_BITS = int(os.environ.get("INTERVAL_BITS", "5"))
ALL = (1 << HEADS) - 1
COMMAND, FAILOVER, PARITY_WEIGHT1, PARITY_LIMIT = 33, 35, 40, 46
WEIGHT_ONE = 1 << 16
"""Weight 1 in the format s1.16."""
RETURN_AFTER = 3
INPUTS = (
    *("read_enable", "write_enable", "address", "write_data", "take_snapshot", "clear"),
    *("steps", "steps_up", "illegals", "illegal_counts", "overspeeds", "overspeed_counts"),
    *("swallowed", "index_errors", "index_error_counts", "indices_seen", "used", "idle_used"),
    *("idle_carrier_used", "differences", "is_settled", "swap_comes", "busy", "loaded", "refused"),
)


async def start(dut: Any, return_after: int) -> None:
    for name in INPUTS:
        getattr(dut, name).value = 0
    dut.is_settled.value = 1
    dut.reset.value = 1
    cocotb.start_soon(Clock(dut.clock, 10, unit="ns", impl="gpi").start())
    for _ in range(4):
        await RisingEdge(dut.clock)
    dut.reset.value = 0
    dut.write_enable.value, dut.address.value = 1, FAILOVER
    dut.write_data.value = 1 | 1 << 4 | return_after << 16
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0


class Banks:
    """Simulates which heads the idle and the active bank use, and the loading of prepared sets; the
    bench calls ``clock`` once per clock."""

    def __init__(self, choose: random.Random) -> None:
        self.choose = choose
        self.used, self.idle = ALL, ALL
        self.carrier_used = True
        self.loading = 0
        """Number of clocks until a prepared set is written and its swap is requested; 0 if no set
        is loading."""
        self.waits = False
        """Whether a swap has been allowed and has not yet taken place."""
        self.of_set = False
        self.number = 0
        self.quiet = 0
        """Number of clocks since the idle bank changed. A swap is requested more than 3 clocks
        after this change, because the request needs a bus access."""

    def words_of(self, number: int) -> int:
        """Return the heads that a set uses; one set in ten wrongly uses the missing head too."""
        words = ALL & ~(1 << number >> 1)
        return ALL if self.choose.random() < 0.1 else words

    def clock(self, load: bool, number: int, may_activate: bool) -> FailoverInputs:
        busy = self.loading > 0 or (self.waits and self.of_set)
        asked = refused = comes = loaded = False
        if load:
            self.loading, self.number = self.choose.randrange(8, 20), number
        elif self.loading > 1:
            self.loading -= 1
            if self.loading == 5:
                self.idle, self.quiet = self.words_of(self.number), 0
                self.carrier_used = self.choose.random() < 0.9
        elif self.loading == 1:
            self.loading, self.of_set, asked = 0, True, True
        elif not busy and not self.waits and self.quiet > 3 and self.choose.random() < 0.04:
            self.of_set, asked = False, True
        elif not busy and not self.waits and self.choose.random() < 0.02:
            self.idle, self.quiet = self.choose.choice([ALL, self.choose.randrange(1, ALL)]), 0
            self.carrier_used = self.choose.random() < 0.9
        else:
            self.quiet += 1
        if asked:
            refused, self.waits = not may_activate, may_activate
        if self.waits and self.choose.random() < 0.4:
            comes, loaded, self.waits = True, self.of_set, False
        inputs = FailoverInputs(
            used=self.used,
            idle_used=self.idle,
            idle_carrier_used=self.carrier_used,
            swap_comes=comes,
            busy=busy,
            loaded=loaded,
            refused=refused,
        )
        if comes:
            self.used, self.quiet = self.idle, 0
        return inputs


@cocotb.test()
async def decisions_equal_the_model(dut: Any) -> None:
    """The decisions equal the model's for random faults, swaps, sets and requests; active words
    never use a head that is left out."""
    choose = random.Random(HEADS)
    happened: Counter[str] = Counter()
    for return_after in (0, RETURN_AFTER):
        await start(dut, return_after)
        # The entity has now run four clocks of reset and one clock in which the register was
        # written.
        model = HeadFailover(HEADS, return_after, INTERVAL_BITS)
        await RisingEdge(dut.clock)
        model.number = dut.number.value.to_unsigned()
        banks = Banks(choose)
        seen, illegals = ALL, 0
        for clock in range(12_000):
            illegals = 0 if choose.random() < 0.5 else illegals
            if choose.random() < 0.01:
                illegals = 1 << choose.randrange(HEADS)
            seen &= ~model.rearm_heads
            if choose.random() < 0.01:
                seen = ALL
            shown = banks.clock(model.load, model.number, model.may_activate)
            command = choose.random() < (0.5 if shown.loaded else 0.02)
            wanted = choose.randrange(8) if choose.random() < 0.3 else None
            back = choose.randrange(ALL + 1) if choose.random() < 0.5 else 0
            clear = choose.random() < 0.02
            dut.illegals.value = illegals
            dut.indices_seen.value = seen
            dut.clear.value = int(clear)
            dut.write_enable.value, dut.address.value = int(command), COMMAND
            dut.write_data.value = back << 8 | (0 if wanted is None else 1 << 7 | wanted << 4)
            for name in ("used", "idle_used", "idle_carrier_used", "swap_comes", "busy"):
                getattr(dut, name).value = int(getattr(shown, name))
            dut.loaded.value, dut.refused.value = int(shown.loaded), int(shown.refused)
            await RisingEdge(dut.clock)
            # The values read here are those before this edge: they belong to the clock that ends
            # with it.
            found = (
                *(int(dut.load.value), dut.number.value.to_unsigned()),
                *(dut.left_out.value.to_unsigned(), int(dut.changed.value)),
                *(int(dut.may_activate.value), dut.rearm_heads.value.to_unsigned()),
                *(int(dut.swap_refused.value), dut.set_in_force.value.to_unsigned()),
            )
            expected = (
                *(int(model.load), model.number, model.left_out, int(model.changed)),
                *(int(model.may_activate), model.rearm_heads),
                *(int(model.swap_refused), model.set_in_force),
            )
            if clock > 3:
                assert found == expected, f"clock {clock}: {found}, expected {expected}"
            happened["left out"] += bool(model.load and model.number and wanted is None)
            happened["refused"] += shown.refused
            happened["own words, a head out"] += bool(
                model.set_in_force == OWN_WORDS_SET and model.left_out
            )
            before = model.left_out
            model.clock(
                FailoverInputs(
                    **{
                        **vars(shown),
                        "failed": dut.failed.value.to_unsigned(),
                        "causes": dut.causes.value.to_unsigned(),
                        "indices_seen": seen,
                        "clear": clear,
                        "take_set": wanted if command else None,
                        "come_back": back if command else 0,
                    }
                )
            )
            assert not model.left_out & banks.used, "active words use a head that is left out"
            happened["back"] += before != 0 and model.left_out == 0
            happened["back to own words"] += bool(
                before and not model.left_out and not shown.loaded
            )
    assert min(happened.values()) > 10, happened
    assert len(happened) == 5


@cocotb.test()
async def a_refused_set_is_loaded_once(dut: Any) -> None:
    """A head whose set the core refuses may fail again and again; its set is loaded once, and once
    more after the processor has written the register `failover`. Sets of other heads are loaded."""
    await start(dut, 0)
    dut.used.value = dut.indices_seen.value = ALL
    loads: list[int] = []
    illegals = 0
    for clock in range(1200):
        busy = clock % 100 in range(20, 40)
        if clock % 100 in (10, 60):
            illegals ^= 1 << (2 if clock == 510 else 1)
        dut.illegals.value = illegals
        dut.busy.value, dut.refused.value = int(busy), int(clock % 100 == 39)
        dut.write_enable.value = int(clock == 900)
        dut.address.value, dut.write_data.value = FAILOVER, 1 | 1 << 4
        await RisingEdge(dut.clock)
        if dut.load.value == 1:
            loads.append(dut.number.value.to_unsigned())
    assert loads == [2, 3, 2]


async def write(dut: Any, address: int, word: int) -> None:
    dut.write_enable.value, dut.address.value, dut.write_data.value = 1, address, word
    await RisingEdge(dut.clock)
    dut.write_enable.value = 0


@cocotb.test()
@cocotb.parametrize(moves=["index", "words"])
async def the_parity_ignores_readings_before_a_jump(dut: Any, moves: str) -> None:
    """Differences that end with a head's first index, or with a swap of the words, do not set the
    flag of the parity; the same differences later do, if the words use all heads.

    The bench changes `is_settled` and the differences as head_mean does: the differences are new 6
    clocks after the jump, and `is_settled` rises 9 clocks after it. The jump comes in each of the 8
    clocks in which parity_sum may take the differences.
    """
    off = 1000 << 4
    for first in range(8):
        await start(dut, 0)
        await write(dut, PARITY_WEIGHT1, WEIGHT_ONE)
        await write(dut, PARITY_LIMIT, 10)
        dut.used.value = ALL
        missing = moves == "index"
        dut.indices_seen.value = ALL & ~1 if missing else ALL
        dut.is_settled.value = int(missing)
        dut.differences.value = off
        for _ in range(40 + first):
            await RisingEdge(dut.clock)
        for clock in range(60):
            dut.indices_seen.value = ALL
            if clock in (0, 9):
                dut.is_settled.value = int(clock == 9)
            if clock == 6:
                dut.differences.value = 0
            await RisingEdge(dut.clock)
        assert dut.parity_beyond.value == 0, f"jump in clock {first} of 8"
        dut.used.value = ALL & ~1
        dut.differences.value = off
        for expected in (0, 1):
            for _ in range(60):
                await RisingEdge(dut.clock)
            assert dut.parity_beyond.value == expected
            dut.used.value = ALL
