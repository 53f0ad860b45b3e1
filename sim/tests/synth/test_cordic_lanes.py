"""The lanes beside ours: constants and arithmetic against float64, without synthesis."""

from __future__ import annotations

import math
import shutil
from pathlib import Path

import numpy as np
import pytest
from scripts import cordic_ii_lane, lane_measurement, table_lanes
from scripts.compare_cordic import CORES
from scripts.cordic_ii_lane import (
    COARSE_BITS,
    CORDIC_SHIFTS,
    FINE_BITS,
    FRIEND_BITS,
    FRIENDS,
    NANO_BITS,
    NANO_SHIFTS,
    REDUNDANT,
    REDUNDANT_BITS,
    UNITS_A_RADIAN,
    Z_BITS,
)
from scripts.lane_measurement import SWEEP_BITS
from scripts.verilog_table import verilog_table

HALF_OF_LAST_BIT = 2.0**-17


def _top(z: np.ndarray, bits: int, kept: int) -> np.ndarray:
    """Index of a table by the highest bits of a signed number."""
    return (z >> (bits - kept)) & ((1 << kept) - 1)


def _units(angle_rad: float) -> int:
    return round(angle_rad * UNITS_A_RADIAN)


def test_friend_angles_are_equally_long_and_the_redundant_ones_nearly() -> None:
    assert abs(24 + 7j) == abs(20 + 15j) == 25.0
    assert np.degrees(FRIENDS) == pytest.approx([0.0, 16.2602, 36.8699], abs=1e-4)
    assert math.degrees(REDUNDANT) == pytest.approx(7.1250, abs=1e-4)
    assert abs(abs(128 + 16j) / 129.0 - 1.0) < 3.1e-5


def test_the_angles_of_cordic_ii_add_up_to_the_phase() -> None:
    # Every angle of z, as the Verilog takes it off; each rest has to fit its register.
    z = np.arange(-(2 ** (Z_BITS - 1)), 2 ** (Z_BITS - 1))
    asked_rad = (z + 0.5) / UNITS_A_RADIAN
    turned_rad = np.zeros(z.size)

    choice = cordic_ii_lane.friend_choices()[_top(z, Z_BITS, FRIEND_BITS)]
    angles = np.array([cordic_ii_lane.friend_angle(k) for k in range(-2, 3)])
    turned_rad += angles[choice + 2]
    z = z - np.round(angles * UNITS_A_RADIAN).astype(int)[choice + 2]
    bits = Z_BITS - 2
    assert np.abs(z + 0.5).max() < 2 ** (bits - 1)
    assert np.degrees(np.abs(z + 0.5).max() / UNITS_A_RADIAN) < 10.5

    choice = cordic_ii_lane.redundant_choices()[_top(z, bits, REDUNDANT_BITS)]
    turned_rad += choice * REDUNDANT
    z = z - choice * _units(REDUNDANT)
    bits -= 1
    assert np.abs(z + 0.5).max() < 2 ** (bits - 1)
    assert np.degrees(np.abs(z + 0.5).max() / UNITS_A_RADIAN) < 3.61

    for shift in CORDIC_SHIFTS:
        side = np.where(z < 0, -1, 1)
        turned_rad += side * math.atan(2.0**-shift)
        z = z - side * _units(math.atan(2.0**-shift))
        bits -= 1
        assert np.abs(z + 0.5).max() < 2 ** (bits - 1)
    assert bits == NANO_BITS

    coarse = cordic_ii_lane.nano_choices(
        COARSE_BITS, 2.0 ** (NANO_BITS - COARSE_BITS), NANO_SHIFTS[0]
    )[_top(z, NANO_BITS, COARSE_BITS)]
    side = np.where(z < 0, -1, 1)
    # The Verilog turns by the size of k to the side of z.
    assert ((coarse == 0) | (np.sign(coarse) == side)).all()
    turned_rad += np.arctan(coarse * 2.0 ** -NANO_SHIFTS[0])
    index = np.abs(coarse) | np.where(side < 0, 16, 0)
    z = z - cordic_ii_lane.coarse_units()[index]
    assert np.abs(z + 0.5).max() < 2 ** (FINE_BITS - 1)
    assert np.degrees(np.abs(z + 0.5).max() / UNITS_A_RADIAN) < 0.0315

    fine = cordic_ii_lane.nano_choices(FINE_BITS, 1.0, NANO_SHIFTS[1])[
        _top(z, FINE_BITS, FINE_BITS)
    ]
    assert ((fine == 0) | (np.sign(fine) == np.where(z < 0, -1, 1))).all()
    turned_rad += np.arctan(fine * 2.0 ** -NANO_SHIFTS[1])

    left_rad = np.abs(asked_rad - turned_rad)
    # Half of the last step, and the roundings of six angles to whole units of z.
    assert 2.0**-15 < left_rad.max() < 2.0**-15 + 6 * 0.5 / UNITS_A_RADIAN


@pytest.mark.parametrize("offset_bits", [table_lanes.OFFSET_BITS, table_lanes.ROWS_OFFSET_BITS])
def test_table_and_slope_give_the_cosine(offset_bits: int) -> None:
    folded = np.arange(2**table_lanes.FOLDED_BITS, dtype=np.int64)
    address = folded >> table_lanes.OFFSET_BITS
    offset = (folded & (2**table_lanes.OFFSET_BITS - 1)) >> (table_lanes.OFFSET_BITS - offset_bits)
    unit_turn = 2.0 ** (table_lanes.OFFSET_BITS - offset_bits - table_lanes.PHASE_FRACTION)
    slope = table_lanes.table_slopes()[address] / 2.0**table_lanes.SLOPE_FRACTION
    value = table_lanes.table_values(offset_bits)[address] / 2.0**table_lanes.VALUE_FRACTION
    result = value - slope * offset * unit_turn - HALF_OF_LAST_BIT
    error = np.abs(result - np.cos(2.0 * np.pi * folded / 2.0**table_lanes.PHASE_FRACTION))
    # Half of z**2/2 with z = 2**-10 turn; the slope's last half bit over 2**-10 turn; that of the
    # value; half a unit of the offset at the steepest slope.
    bound = (2.0 * math.pi * 2.0**-10) ** 2 / 4.0 + 2.0**-19 + 2.0**-21 + math.pi * unit_turn
    assert 0.5 * bound < error.max() < bound


def test_a_table_in_verilog_has_two_s_complement() -> None:
    text = verilog_table("side", 2, 3, [0, 1, -1])
    assert "function [2:0] side;" in text
    assert "input [1:0] index;" in text
    assert "2'd1: side = 3'h1;" in text
    assert "2'd2: side = 3'h7;" in text
    assert "2'd3" not in text


@pytest.mark.skipif(not shutil.which("verilator"), reason="needs verilator")
def test_the_verilog_of_cordic_ii_gives_the_cosine(tmp_path: Path) -> None:
    core = CORES["cordic_ii"]
    source = tmp_path / f"{core.top}.v"
    source.write_text(core.make(tmp_path, []), encoding="utf-8")
    latency, error, _ = lane_measurement.latency_and_errors(
        core, lane_measurement._sweep(core, source)
    )
    assert (latency, SWEEP_BITS) == (13, 20)
    # 3.6e-5 rad left over and half of the nano-rotation's gain, at right angles; half a last bit;
    # five roundings of x by half a unit of 2**-18.
    assert error < math.hypot(3.6e-5, 2.0**-16) + HALF_OF_LAST_BIT + 5 * 2.0**-19
