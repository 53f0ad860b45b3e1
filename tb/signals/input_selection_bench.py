"""Tests every setting of input_selection with every state of the pins."""

from __future__ import annotations

from itertools import product

import cocotb
from cocotb.triggers import Timer


@cocotb.test()
async def all_settings(dut) -> None:
    names = ("pin_a", "pin_b", "pin_z", "invert_a", "invert_b", "invert_z", "swap_ab")
    for values in product((0, 1), repeat=len(names)):
        for name, value in zip(names, values, strict=True):
            getattr(dut, name).value = value
        await Timer(1, "ns")
        a, b, z, invert_a, invert_b, invert_z, swaps = values
        expected = [a != invert_a, b != invert_b, z != invert_z]
        if swaps:
            expected[:2] = expected[1::-1]
        assert [int(pin.value) for pin in (dut.a, dut.b, dut.z)] == [int(e) for e in expected]
