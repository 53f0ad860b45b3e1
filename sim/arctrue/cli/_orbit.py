"""Computes and prints the axis' orbit and its figures, for ``arctrue compare`` of a set with three
or four heads."""

from __future__ import annotations

from typing import Any

from arctrue.base.figures import figure
from arctrue.calibration.axis_orbit import AxisOrbit, orbit_of_set
from arctrue.calibration.capture_check import CaptureRefusedError
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import Console, tell_warning
from arctrue.measurement import MeasurementSet
from arctrue.metrology.iso230_7 import ErrorMotion, error_motion


def orbit_of(measurement: MeasurementSet) -> AxisOrbit | None:
    """Return the axis orbit of the first run that the calibration uses.

    The result is None for two heads. It is also None, after a warning, for a set that does not
    determine the orbit.
    """
    try:
        return orbit_of_set(measurement)
    except (CaptureRefusedError, ValueError) as error:
        tell_warning(f"no orbit of the axis: {error}")
        return None


def _figures(orbit: AxisOrbit) -> dict[str, ErrorMotion]:
    return {
        "x": error_motion(orbit.angle_rad, orbit.x_arcsec),
        "y": error_motion(orbit.angle_rad, orbit.y_arcsec),
    }


def orbit_data(orbit: AxisOrbit) -> dict[str, Any]:
    """Return the figures in both directions as JSON values, in arcseconds at the disc's radius;
    null for figures that three heads do not determine."""
    return {
        direction: {
            "total_arcsec": item.total if orbit.has_synchronous else None,
            "synchronous_arcsec": item.synchronous if orbit.has_synchronous else None,
            "asynchronous_arcsec": item.asynchronous,
            "u_sample_arcsec": u,
        }
        for (direction, item), u in zip(_figures(orbit).items(), orbit.u_arcsec, strict=True)
    }


def print_orbit(console: Console, orbit: AxisOrbit) -> None:
    """Print the error motion according to ISO 230-7 in two fixed sensitive directions."""
    shown = table(
        "Error motion of the axis (ISO 230-7), ″ at the disc's radius",
        words("direction"),
        *map(number, ("total", "synchronous", "asynchronous", "u of a\nsample")),
    )
    for (direction, item), u in zip(_figures(orbit).items(), orbit.u_arcsec, strict=True):
        known = (item.total, item.synchronous) if orbit.has_synchronous else (None, None)
        values = (*known, item.asynchronous, u)
        shown.add_row(direction, *(figure(value, 3) for value in values))
    console.print(shown)
    if not orbit.has_synchronous:
        console.print(
            "Three heads do not separate a motion of the axis that repeats in each turn from the "
            "disc's own error; only the asynchronous value, which contains the noise of the "
            "readings, is known.",
            soft_wrap=True,
        )
        return
    console.print(
        "The total and the asynchronous values contain the noise of the readings. If the axis "
        "moves on a circle once per turn in the direction of the table, no value contains this "
        "motion, because the heads cannot distinguish it from an eccentric disc.",
        soft_wrap=True,
    )
