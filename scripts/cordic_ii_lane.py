"""Writes the rotations of CORDIC II for one cosine as Verilog, for scripts/compare_cordic.py alone.

CORDIC II is M. Garrido, P. Källström, M. Kumm, O. Gustafsson, IEEE TCAS-II 63, 2016, 186. It is
rebuilt here from its angles and is not a part of the core. Like cordic_rotation it is made for a
vector of constant size and for the cosine alone: a table holds the vector after the first
rotations, z is only as wide as the angle that can be left, and the last rotations do not change y.

| rotation | angles | left over, at most |
|---|---|---:|
| trivial: fold into a quadrant, less an eighth of a turn | 45 degrees | 45 degrees |
| friend angles 25, 24 + 7j, 20 + 15j | 0, 16.26, 36.87 degrees | 10.5 |
| uniformly scaled redundant CORDIC 129, 128 + 16j | 0, 7.13 degrees | 3.61 |
| CORDIC 32 + j, 64 + j, 128 + j | 1.79, 0.90, 0.45 degrees | 0.47 |
| nano-rotations 1024 + jk, k = 0 to 8 | k times 0.056 degrees | 0.031 |
| nano-rotations 16384 + jk, k = 0 to 8 | k times 0.0035 degrees | 3.6e-5 rad |

The last row is not the publication's; it is built like the row before. The publication's seven
rotations leave 0.03 degrees, which is 5e-4 rad; a cosine of 18 bits needs a tenth of that.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Final

import numpy as np
from numpy.typing import NDArray

from scripts.verilog_table import verilog_table

Integers = NDArray[np.int64]

# Fraction bits of x and y; z is in 2**-21 turn, as in cordic_rotation.
FRACTION: Final = 18
Z_FRACTION: Final = 21
UNITS_A_RADIAN: Final = 2.0**Z_FRACTION / (2.0 * math.pi)
FRIENDS: Final = (0.0, math.atan2(7, 24), math.atan2(15, 20))
"""Friend angles in rad: 25, 24 + 7j and 20 + 15j are equally long."""
REDUNDANT: Final = math.atan2(16, 128)
"""Angle of uniformly scaled redundant CORDIC in rad: 129 and 128 + 16j are equally long within
3.1e-5."""
CORDIC_SHIFTS: Final = (5, 6, 7)
NANO_SHIFTS: Final = (10, 14)
"""A nano-rotation multiplies by 2**shift + jk, k = -8 to 8."""
LARGEST_NANO: Final = 8

# Bits of z: at the start, before the nano-rotations, before the last of them.
Z_BITS: Final = 19
NANO_BITS: Final = 13
FINE_BITS: Final = 9
# Bits of z that decide about an angle.
FRIEND_BITS: Final = 6
REDUNDANT_BITS: Final = 8
COARSE_BITS: Final = 9
# Where the friend angle changes: few bits of z tell it, and the next rotation reaches the rest.
FRIEND_LIMITS: Final = (6 / 32 * math.pi / 4, 19 / 32 * math.pi / 4)


def _signed(index: Integers, bits: int) -> Integers:
    return np.where(index >> (bits - 1) != 0, index - (1 << bits), index)


def _middles(bits: int) -> NDArray[np.float64]:
    """The middles of the intervals that signed numbers of so many bits stand for, -1 to 1."""
    index = np.arange(1 << bits, dtype=np.int64)
    middles: NDArray[np.float64] = (_signed(index, bits) + 0.5) / (1 << (bits - 1))
    return middles


def friend_choices() -> Integers:
    """Which friend angle, -2 to 2, is taken, by the highest 6 bits of z (an eighth of a turn)."""
    at = _middles(FRIEND_BITS) * math.pi / 4
    size = np.sum([np.abs(at) > limit for limit in FRIEND_LIMITS], axis=0)
    choices: Integers = (np.sign(at) * size).astype(np.int64)
    return choices


def redundant_choices() -> Integers:
    """Which angle, -1 to 1, is taken, by the highest 8 bits of z (a 32nd of a turn)."""
    at = _middles(REDUNDANT_BITS) * math.pi / 16
    choices: Integers = np.where(np.abs(at) > REDUNDANT / 2, np.sign(at), 0).astype(np.int64)
    return choices


def nano_choices(bits: int, unit: float, shift: int) -> Integers:
    """Which k, -8 to 8, is taken, by a signed z of so many bits, the last worth ``unit`` units."""
    z = (_signed(np.arange(1 << bits, dtype=np.int64), bits) + 0.5) * unit
    k = np.round(z / (math.atan(2.0**-shift) * UNITS_A_RADIAN))
    choices: Integers = np.clip(k, -LARGEST_NANO, LARGEST_NANO).astype(np.int64)
    return choices


def coarse_units() -> Integers:
    """Angle of the first nano-rotation in units of z; index: its size, to the right 16 more."""
    size = np.minimum(np.arange(32) & 15, LARGEST_NANO)
    units = np.round(size * math.atan(2.0 ** -NANO_SHIFTS[0]) * UNITS_A_RADIAN).astype(np.int64)
    angles: Integers = np.where(np.arange(32) < 16, units, -units)
    return angles


def friend_angle(choice: int) -> float:
    """Angle of a choice of ``friend_choices`` in rad."""
    return math.copysign(FRIENDS[abs(choice)], choice)


def start_radius() -> float:
    """One over the gain of the rotations by adders; of the first nano-rotation its middle gain."""
    gain = math.prod(math.sqrt(1.0 + 4.0**-shift) for shift in CORDIC_SHIFTS[1:])
    gain *= 0.5 * (1.0 + math.sqrt(1.0 + (LARGEST_NANO / 2.0 ** NANO_SHIFTS[0]) ** 2))
    return 1.0 / gain


def _units(angle_rad: float) -> int:
    return round(angle_rad * UNITS_A_RADIAN)


def _start_table(component: Callable[[float], float]) -> Integers:
    """x or y after the first CORDIC rotation; index: to the right, redundant, friend choice."""
    table = np.zeros(64, dtype=np.int64)
    for friend in range(-2, 3):
        for redundant in range(-1, 2):
            for right in range(2):
                angle = math.pi / 4 + friend_angle(friend) + redundant * REDUNDANT
                angle += (1 - 2 * right) * math.atan(2.0 ** -CORDIC_SHIFTS[0])
                place = right << 5 | (redundant & 3) << 3 | friend & 7
                table[place] = round(start_radius() * component(angle) * 2.0**FRACTION)
    return table


def cordic_ii_lane() -> str:
    """Verilog of the rotations of CORDIC II for one cosine, 13 clocks."""
    coarse_unit = 1 << (NANO_BITS - COARSE_BITS)
    friends = friend_choices()
    coarse = nano_choices(COARSE_BITS, coarse_unit, NANO_SHIFTS[0])
    tables = (
        verilog_table("friend_of", FRIEND_BITS, 3, friends),
        verilog_table(
            "friend_units", FRIEND_BITS, Z_BITS, [_units(friend_angle(c)) for c in friends]
        ),
        verilog_table("redundant_of", REDUNDANT_BITS, 2, redundant_choices()),
        verilog_table("coarse_of", COARSE_BITS, 4, np.abs(coarse)),
        verilog_table("coarse_units", 5, FINE_BITS, coarse_units()),
        verilog_table(
            "fine_of", FINE_BITS, 4, np.abs(nano_choices(FINE_BITS, 1.0, NANO_SHIFTS[1]))
        ),
        verilog_table("start_x", 6, FRACTION + 2, _start_table(math.cos)),
        verilog_table("start_y", 6, FRACTION + 2, _start_table(math.sin)),
    )
    steps = [_units(math.atan(2.0**-shift)) for shift in CORDIC_SHIFTS]
    return f"""
module cordic_ii_lane (input clock, input [23:0] phase, output reg signed [17:0] cosine = 0);
{"".join(tables)}
    // k times y of two terms, and a +/- b rounded, with b in half units.
    function signed [17:0] multiple;
        input signed [13:0] y;
        input [3:0] k;
        reg signed [17:0] first, second;
        begin
            case (k)
                4'd0: first = 0;
                4'd1: first = y;
                4'd2, 4'd3: first = y <<< 1;
                4'd4, 4'd5, 4'd6: first = y <<< 2;
                default: first = y <<< 3;
            endcase
            case (k)
                4'd3, 4'd5: second = y;
                4'd6: second = y <<< 1;
                4'd7: second = ~y;
                default: second = 0;
            endcase
            multiple = first + second;
        end
    endfunction

    function signed [19:0] add_or_subtract;
        input signed [19:0] a;
        input signed [20:0] b;
        input subtract;
        reg signed [20:0] difference;
        begin
            difference = {{a, 1'b0}} - (b ^ {{21{{~subtract}}}});
            add_or_subtract = difference[20:1];
        end
    endfunction

    reg [12:1] negative = 0;
    reg signed [18:0] z1 = 0;
    reg signed [16:0] z2 = 0, z3 = 0;
    reg signed [15:0] z4 = 0;
    reg signed [14:0] z5 = 0;
    reg signed [13:0] z6 = 0;
    reg signed [12:0] z7 = 0, z8 = 0;
    reg signed [8:0] z9 = 0;
    reg [2:0] friend2 = 0, friend3 = 0, friend4 = 0, friend5 = 0;
    reg [1:0] redundant3 = 0, redundant4 = 0, redundant5 = 0;
    reg right5 = 0, right6 = 0, right7 = 0, right8 = 0, right9 = 0, right10 = 0, right11 = 0;
    reg [3:0] coarse8 = 0, fine10 = 0;
    reg signed [19:0] x6 = 0, y6 = 0, x7 = 0, y7 = 0, x8 = 0, y8 = 0;
    reg signed [19:0] x9 = 0, x10 = 0, x11 = 0, x12 = 0;
    reg signed [13:0] y9 = 0, y10 = 0;
    reg signed [17:0] part9 = 0, part11 = 0;
    wire signed [19:0] signed_bits = x12 ^ {{20{{negative[12]}}}};

    always @(posedge clock) begin
        // Trivial rotations: fold into the first quadrant and take an eighth of a turn off.
        negative <= {{negative[11:1], phase[23] ^ phase[22]}};
        z1 <= (phase[21:3] ^ {{19{{phase[22]}}}}) ^ 19'h40000;
        friend2 <= friend_of(z1[18:13]);
        z2 <= z1 - $signed(friend_units(z1[18:13]));
        redundant3 <= redundant_of(z2[16:9]);
        z3 <= z2;
        friend3 <= friend2;
        z4 <= redundant3[1] ? z3 + {_units(REDUNDANT)} :
            redundant3[0] ? z3 - {_units(REDUNDANT)} : z3;
        friend4 <= friend3;
        redundant4 <= redundant3;
        right5 <= z4[15];
        z5 <= z4[15] ? z4 + {steps[0]} : z4 - {steps[0]};
        friend5 <= friend4;
        redundant5 <= redundant4;
        x6 <= start_x({{right5, redundant5, friend5}});
        y6 <= start_y({{right5, redundant5, friend5}});
        right6 <= z5[14];
        z6 <= z5[14] ? z5 + {steps[1]} : z5 - {steps[1]};
        x7 <= add_or_subtract(x6, y6 >>> {CORDIC_SHIFTS[1] - 1}, ~right6);
        y7 <= add_or_subtract(y6, x6 >>> {CORDIC_SHIFTS[1] - 1}, right6);
        right7 <= z6[13];
        z7 <= z6[13] ? z6 + {steps[2]} : z6 - {steps[2]};
        x8 <= add_or_subtract(x7, y7 >>> {CORDIC_SHIFTS[2] - 1}, ~right7);
        y8 <= add_or_subtract(y7, x7 >>> {CORDIC_SHIFTS[2] - 1}, right7);
        right8 <= z7[12];
        coarse8 <= coarse_of(z7[12:{NANO_BITS - COARSE_BITS}]);
        z8 <= z7;
        // The nano-rotations leave y as it is.
        part9 <= multiple(y8[19:6], coarse8);
        right9 <= right8;
        z9 <= z8 - $signed(coarse_units({{right8, coarse8}}));
        x9 <= x8;
        y9 <= y8[19:6];
        x10 <= add_or_subtract(x9, part9 >>> 3, ~right9);
        right10 <= z9[8];
        fine10 <= fine_of(z9);
        y10 <= y9;
        part11 <= multiple(y10 >>> 4, fine10);
        right11 <= right10;
        x11 <= x10;
        x12 <= add_or_subtract(x11, part11 >>> 3, ~right11);
        cosine <= (signed_bits >>> 2) + signed_bits[1];
    end
endmodule
"""
