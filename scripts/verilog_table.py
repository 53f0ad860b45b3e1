"""Writes a table of constants as Verilog."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray


def verilog_table(
    name: str, inputs: int, outputs: int, values: Sequence[int] | NDArray[np.int64]
) -> str:
    """A Verilog function of ``inputs`` bits; its values have ``outputs`` bits, two's complement.

    From the end of ``values`` on it is 0.
    """
    mask = (1 << outputs) - 1
    cases = "\n".join(
        f"            {inputs}'d{index}: {name} = {outputs}'h{int(value) & mask:x};"
        for index, value in enumerate(values)
    )
    return f"""
    function [{outputs - 1}:0] {name};
        input [{inputs - 1}:0] index;
        case (index)
{cases}
            default: {name} = {outputs}'h0;
        endcase
    endfunction
"""
