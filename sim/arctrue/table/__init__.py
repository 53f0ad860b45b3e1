"""Simulates the rotary table as a physical object that gives the signals that real heads would
give.

The simulation is independent of the calibration: it computes points, rays and lines, not Fourier
series.
"""

from arctrue.table.cause import Cause
from arctrue.table.causes.disc_eccentricity import DiscEccentricity
from arctrue.table.causes.graduation_harmonics import GraduationHarmonics
from arctrue.table.edges import CountEdges, angle_of_reading, count_edges
from arctrue.table.head import Head
from arctrue.table.motion import Motion
from arctrue.table.pins import PinEvents, TooFastError, clocked_pins, decode_quadrature, pin_states
from arctrue.table.rotary_table import (
    DISC_RADIUS_M,
    HEAD_PLACES_DEG,
    HEAD_SEPARATION_RAD,
    RotaryTable,
    heads_at,
    two_heads,
)
from arctrue.table.state import TableState

__all__ = [
    "DISC_RADIUS_M",
    "HEAD_PLACES_DEG",
    "HEAD_SEPARATION_RAD",
    "Cause",
    "CountEdges",
    "DiscEccentricity",
    "GraduationHarmonics",
    "Head",
    "Motion",
    "PinEvents",
    "RotaryTable",
    "TableState",
    "TooFastError",
    "angle_of_reading",
    "clocked_pins",
    "count_edges",
    "decode_quadrature",
    "heads_at",
    "pin_states",
    "two_heads",
]
