"""Defines effects that change the reading of head 1, but not the mean of four heads."""

from __future__ import annotations

from dataclasses import dataclass

from arctrue.table.cause import Cause
from arctrue.table.causes.ball_pass import BallPass
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.conditions import USUAL_TEMPERATURE_C


@dataclass(frozen=True)
class HeadsCase:
    """Effect that appears after the calibration, and the order per turn at which its size is
    measured."""

    title: str
    cause: Cause
    order: float
    celsius: float = USUAL_TEMPERATURE_C


HEADS_CASES = {
    "bearing_ball_pass": HeadsCase(
        "balls that move the axis by 0.25 µm", BallPass(4.37, 0.25e-6), 4.37
    ),
    "thermal_eccentricity": HeadsCase(
        "a hub that heat moves by 2 µm", ThermalCentre(0.4e-6 + 0j), 1.0, USUAL_TEMPERATURE_C + 5.0
    ),
}
"""Cases by the name of the effect."""
