"""Checks that the words of a coefficient file agree with its values in arcseconds and degrees."""

from __future__ import annotations

import math
from fractions import Fraction

from arctrue.base.typed_content import ContentError
from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.gateware.coefficient_file_keys import ExtendedLaneKeys, LaneKeys, ThermalLaneKeys
from arctrue.gateware.lane_words import AMPLITUDE_LSB_COUNTS, phase_step
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS
from arctrue.generated.number_formats import PHASE_STEP_WIDTH, PHASE_WIDTH

# Permitted difference between a value in arcseconds, degrees or counts and its word, in units of
# the word: half a unit for the rounding of a typed value, and a small margin for the number of
# written digits.
_AGREEMENT = 0.51


def agree(
    place: str, value: float, word_key: str, word: int, unit: float, turn: float = math.inf
) -> None:
    """Raise ContentError if ``value`` differs from ``word`` · ``unit`` by more than _AGREEMENT ·
    ``unit``, apart from a multiple of ``turn``."""
    difference = value - word * unit
    if math.isfinite(turn):
        difference = math.remainder(difference, turn)
    if abs(difference) > _AGREEMENT * unit:
        raise ContentError(
            f"{place}: found {value}, but {word_key} = {word} is {word * unit:.9g}; "
            "change both or neither"
        )


def check_words(place: str, lane: LaneKeys, counts_per_rev: int) -> None:
    """Raise ContentError if the words of a lane contradict its values in arcseconds and degrees."""
    if isinstance(lane, ExtendedLaneKeys):
        _check_real_order(place, lane, counts_per_rev)
    else:
        needed = phase_step(lane.order, counts_per_rev)
        if lane.phase_step != needed:
            raise ContentError(
                f"{place}.phase_step: found {lane.phase_step}, but order {lane.order} at "
                f"{counts_per_rev} counts a turn needs {needed}; change both or neither"
            )
    unit = AMPLITUDE_LSB_COUNTS * ARCSEC_PER_TURN / counts_per_rev
    agree(f"{place}.amplitude_arcsec", lane.amplitude_arcsec, "amplitude", lane.amplitude, unit)
    step_deg = 360.0 / 2**PHASE_WIDTH
    agree(f"{place}.phase_deg", lane.phase_deg, "phase_offset", lane.phase_offset, step_deg, 360.0)


def _check_real_order(place: str, lane: ExtendedLaneKeys, counts_per_rev: int) -> None:
    """Raise ContentError if the phase step or the turn step contradicts the order.

    A step may differ by _AGREEMENT units and by the effect of rounding the order to 53 bits.
    """
    turn = 1 << PHASE_STEP_WIDTH
    order = Fraction(lane.order)
    slack = Fraction(_AGREEMENT) + order * Fraction(turn, 2**52)
    for key, step, needed in (
        ("phase_step", lane.phase_step, order * turn / counts_per_rev),
        ("turn_step", lane.turn_step, order % 1 * turn),
    ):
        away = (step - needed) % turn
        if min(away, turn - away) > slack:
            raise ContentError(
                f"{place}.{key}: found {step}, but order {lane.order} at {counts_per_rev} counts "
                f"a turn needs {round(needed) % turn}; change both or neither"
            )


def check_slope(place: str, lane: ThermalLaneKeys, counts_per_rev: int) -> None:
    """Raise ContentError if the words of a slope contradict its values in arcseconds."""
    assert lane.slope is not None
    said = (*(lane.slope_arcsec_per_k or ()), *(lane.slope_arcsec_per_k2 or ()))
    unit = SLOPE_LSB_COUNTS * ARCSEC_PER_TURN / counts_per_rev
    for value, word in zip(said, lane.slope, strict=True):
        if abs(value - word * unit) > _AGREEMENT * unit + 1e-8 * abs(value):
            raise ContentError(
                f"{place}.slope: found {word}, which is {word * unit:.9g}, but the value is "
                f"{value}; change both or neither"
            )
