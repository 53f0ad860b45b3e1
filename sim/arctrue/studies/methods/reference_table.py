"""Calibrates with a look-up table, measured with a reference instrument: polygon and
autocollimator, ten cycles."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.studies.methods.method import Method, fitted_harmonics, of_harmonics
from arctrue.studies.methods.world import TURN_RAD, Correction, Output, World

Float = NDArray[np.float64]


def station_errors(world: World) -> tuple[Float, Float]:
    """Return readings in radians and mean errors in arcseconds at the faces, ``(faces,)``."""
    reading, errors, _ = world.stations([0] * world.settings.cycles)
    return reading, np.asarray(errors.mean(axis=0))


def straight_lines(reading_rad: Float, error_arcsec: Float) -> Correction:
    """Return a correction that interpolates linearly between stations, as motion controllers do."""
    return lambda at: np.interp(at, reading_rad, error_arcsec, period=TURN_RAD)


def _table(world: World) -> Output:
    return Output.of_head1(straight_lines(*station_errors(world)))


def _harmonics(world: World) -> Output:
    reading, error = station_errors(world)
    orders = np.arange(1, (reading.size + 1) // 2)
    return of_harmonics(orders, fitted_harmonics(orders, reading, error))


NEEDS = "polygon of 24 faces with its certificate, autocollimator, free space on the table"
LOOK_UP_TABLE = Method(
    "look_up_table",
    "Look-up table from a reference",
    "ISO 230-1 [1]; read-only tables in the controller [17]",
    1,
    NEEDS,
    "orders from 12 on; linear interpolation between faces leaves up to 1.2″ of an order 1 of 144″",
    _table,
)
REFERENCE_HARMONICS = Method(
    "reference_harmonics",
    "Harmonics from a reference",
    "Zhou et al. [15]",
    1,
    NEEDS,
    "orders from 12 on, which the fit takes for lower orders",
    _harmonics,
)
