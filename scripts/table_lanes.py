"""Writes lanes that take the cosine from a table and one product, as Verilog.

They are for scripts/compare_cordic.py and not a part of the core. The first quadrant is cut into
128 intervals; a table in LUTs gives a tangent to the cosine in the middle of each, by its value
where the interval begins and its slope: cos(a + z) = cos a - z sin a. The term z**2/2, which is
left out, is at most 1.9e-5, because z is at most 2**-10 turn; half of that is taken off the table.

- ``table_product_lane``: the product in a DSP;
- ``table_rows_lane``: the product in rows of adders.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from scripts.verilog_table import verilog_table

Integers = NDArray[np.int64]

PHASE_FRACTION: Final = 24
FOLDED_BITS: Final = PHASE_FRACTION - 2
ADDRESS_BITS: Final = 7
OFFSET_BITS: Final = FOLDED_BITS - ADDRESS_BITS
VALUE_FRACTION: Final = 20
SLOPE_FRACTION: Final = 8
ROWS: Final = 5
"""Base-4 digits of the offset that the rows multiply."""
ROWS_OFFSET_BITS: Final = 2 * ROWS
HALF_OF_LAST_BIT: Final = 2.0**-17
"""Of a cosine s1.16."""


def table_middles() -> NDArray[np.float64]:
    """Angle in the middle of each interval of the table, in rad of the first quadrant."""
    index = np.arange(1 << ADDRESS_BITS)
    middles: NDArray[np.float64] = (index + 0.5) * (math.pi / 2) / (1 << ADDRESS_BITS)
    return middles


def table_slopes() -> Integers:
    """2 pi sin a, u3.8 a turn."""
    slopes: Integers = np.round(
        2.0 * math.pi * np.sin(table_middles()) * 2.0**SLOPE_FRACTION
    ).astype(np.int64)
    return slopes


def table_values(offset_bits: int) -> Integers:
    """The tangents to the cosine where their intervals begin, and the half that rounds, s1.20.

    ``offset_bits``: bits of the offset in the interval that are multiplied; the others count as
    their mean, half a unit of the last. Half of the largest z**2/2 is taken off.
    """
    middles = table_middles()
    reach_turn = 2.0 ** (OFFSET_BITS - 1 - PHASE_FRACTION)
    scale = 1.0 - (2.0 * math.pi * reach_turn) ** 2 / 4.0
    first_turn = 2.0 ** (OFFSET_BITS - offset_bits - 1 - PHASE_FRACTION)
    slope = table_slopes() / 2.0**SLOPE_FRACTION
    begins = scale * np.cos(middles) + slope * (reach_turn - first_turn)
    values: Integers = np.round((begins + HALF_OF_LAST_BIT) * 2.0**VALUE_FRACTION).astype(np.int64)
    return values


def table_product_lane() -> str:
    """Verilog of a table in LUTs and one product in a DSP, 5 clocks."""
    slope_bits = SLOPE_FRACTION + 4
    product_fraction = SLOPE_FRACTION + PHASE_FRACTION
    values = table_values(OFFSET_BITS)
    return f"""
module table_product_lane (input clock, input [23:0] phase, output reg signed [17:0] cosine = 0);
{verilog_table("value_of", ADDRESS_BITS, VALUE_FRACTION + 2, values)}
{verilog_table("slope_of", ADDRESS_BITS, slope_bits, -table_slopes())}
    reg [4:1] negative = 0;
    reg [{FOLDED_BITS - 1}:0] folded = 0;
    reg signed [{VALUE_FRACTION + 1}:0] value2 = 0, value3 = 0;
    reg signed [{slope_bits - 1}:0] slope = 0;
    reg signed [{OFFSET_BITS}:0] offset = 0;
    reg signed [{slope_bits + OFFSET_BITS}:0] product = 0;
    reg signed [{product_fraction + 1}:0] sum = 0;
    wire signed [17:0] rounded = sum[{product_fraction + 1}:{product_fraction - 16}];

    always @(posedge clock) begin
        negative <= {{negative[3:1], phase[23] ^ phase[22]}};
        folded <= phase[{FOLDED_BITS - 1}:0] ^ {{{FOLDED_BITS}{{phase[22]}}}};
        value2 <= value_of(folded[{FOLDED_BITS - 1}:{OFFSET_BITS}]);
        slope <= slope_of(folded[{FOLDED_BITS - 1}:{OFFSET_BITS}]);
        offset <= {{1'b0, folded[{OFFSET_BITS - 1}:0]}};
        product <= slope * offset;
        value3 <= value2;
        sum <= (value3 <<< {product_fraction - VALUE_FRACTION}) + product;
        cosine <= (rounded ^ {{18{{negative[4]}}}}) + {{17'd0, negative[4]}};
    end
endmodule
"""


def _row(index: int) -> str:
    """One base-4 digit of the offset: adds 0, 1, 2 or 3 slopes to a quarter of the row before."""
    before = f"(row{index - 1} >> 2)" if index else "0"
    return f"""
        row{index} <= {before} + (digits{index}[1:0] == 0 ? 0 : digits{index}[1:0] == 1 ?
            slope{index} : digits{index}[1:0] == 2 ? slope{index} << 1 : triple{index});
        digits{index + 1} <= digits{index} >> 2;
        slope{index + 1} <= slope{index};
        triple{index + 1} <= triple{index};
        address{index + 1} <= address{index};"""


def _row_registers(index: int) -> str:
    slope_bits = SLOPE_FRACTION + 3
    return f"""
    reg [{slope_bits + 2}:0] row{index} = 0;
    reg [{ROWS_OFFSET_BITS - 1}:0] digits{index} = 0;
    reg [{slope_bits - 1}:0] slope{index} = 0;
    reg [{slope_bits + 1}:0] triple{index} = 0;
    reg [{ADDRESS_BITS - 1}:0] address{index} = 0;"""


def table_rows_lane() -> str:
    """Verilog of the table and the product in rows of adders, a base-4 digit each, 10 clocks."""
    slope_bits = SLOPE_FRACTION + 3
    # Each row but the last drops two bits.
    product_fraction = SLOPE_FRACTION + PHASE_FRACTION - OFFSET_BITS + ROWS_OFFSET_BITS
    zeros = VALUE_FRACTION - (product_fraction - 2 * (ROWS - 1))
    clocks = ROWS + 4
    last = ROWS - 1
    return f"""
module table_rows_lane (input clock, input [23:0] phase, output reg signed [17:0] cosine = 0);
{verilog_table("value_of", ADDRESS_BITS, VALUE_FRACTION + 2, table_values(ROWS_OFFSET_BITS))}
{verilog_table("slope_of", ADDRESS_BITS, slope_bits, table_slopes())}
    reg [{clocks}:1] negative = 0;
    reg [{FOLDED_BITS - 1}:0] folded = 0;
    reg [{slope_bits - 1}:0] slope = 0;
    reg [{ROWS_OFFSET_BITS - 1}:0] offset = 0;
    reg [{ADDRESS_BITS - 1}:0] address = 0;
    reg signed [{VALUE_FRACTION + 1}:0] value = 0, sum = 0;
{"".join(_row_registers(index) for index in range(ROWS + 1))}
    wire signed [17:0] rounded = sum[{VALUE_FRACTION + 1}:{VALUE_FRACTION - 16}];

    always @(posedge clock) begin
        negative <= {{negative[{clocks - 1}:1], phase[23] ^ phase[22]}};
        folded <= phase[{FOLDED_BITS - 1}:0] ^ {{{FOLDED_BITS}{{phase[22]}}}};
        slope <= slope_of(folded[{FOLDED_BITS - 1}:{OFFSET_BITS}]);
        offset <= folded[{OFFSET_BITS - 1}:{OFFSET_BITS - ROWS_OFFSET_BITS}];
        address <= folded[{FOLDED_BITS - 1}:{OFFSET_BITS}];
        triple0 <= slope + (slope << 1);
        slope0 <= slope;
        digits0 <= offset;
        address0 <= address;
{"".join(_row(index) for index in range(ROWS))}
        value <= value_of(address{last});
        sum <= value - $signed({{1'b0, row{last}, {zeros}'d0}});
        cosine <= (rounded ^ {{18{{negative[{clocks - 1}]}}}})
            + {{17'd0, negative[{clocks - 1}]}};
    end
endmodule
"""
