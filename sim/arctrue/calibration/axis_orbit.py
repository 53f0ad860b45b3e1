"""Calculates the position of the axis at every sample of a capture of three or four heads.

A head at the angle p from head 1 reads θ + (x sin p + y cos p)/r + the disc's error under this head
(docs/architecture.md, "Head geometry"). Once the disc's error is subtracted, the simultaneous
readings give θ, x and y by least squares.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.heads_calibration import MeanSettings, calibrate_mean
from arctrue.calibration.mean_banks import HeadsOnDisc
from arctrue.measurement import MeasurementSet

Float = NDArray[np.float64]
LEAST_HEADS = 3
SEPARATING_HEADS = 4
"""Smallest number of heads that separate the disc's error from a motion of the axis that repeats in
each turn: both have the same period, and three heads leave no equation for the disc."""


@dataclass(frozen=True)
class AxisOrbit:
    """Displacement of the axis at each sample, divided by the disc's radius.

    ``angle_rad``: angle of the table, not wrapped. ``x_arcsec`` and ``y_arcsec`` (n,):
    displacement minus its mean. The forward circle of the axis at order 1 is not included: no
    capture distinguishes it from an eccentric disc. ``u_arcsec``: standard uncertainty of x and y
    from the noise of a reading.
    """

    angle_rad: Float
    x_arcsec: Float
    y_arcsec: Float
    u_arcsec: tuple[float, float]
    has_synchronous: bool = True
    """Whether the orbit contains the motion that repeats in each turn. With three heads, the
    calibration of the disc has absorbed an unknown part of this motion."""


def orbit_of_set(measurement: MeasurementSet) -> AxisOrbit | None:
    """Calibrate the set and return the axis orbit of the first run that the calibration used (the
    runs at the lowest speed); None for two heads, or without a capture or counts per turn.

    Raises CaptureRefusedError or ValueError for a set that does not determine the orbit.
    """
    capture, scale = measurement.capture, measurement.table
    if capture is None or scale.counts_per_rev is None or len(capture.heads) < LEAST_HEADS:
        return None
    found = calibrate_mean(measurement, MeanSettings())
    estimate = found.estimate
    return axis_orbit(
        found.turns[0], estimate.on_disc(), scale.counts_per_rev, estimate.noise_arcsec
    )


def axis_orbit(
    turns: WholeTurns, disc: HeadsOnDisc, counts_per_rev: int, noise_arcsec: float
) -> AxisOrbit:
    """Solve for θ, x and y at every sample of one run; ``disc`` is calibrated from this or another
    capture.

    Raises ValueError for fewer than three heads, which do not determine θ, x and y, and if
    ``turns`` and ``disc`` have different numbers of heads.
    """
    if disc.heads < LEAST_HEADS or len(turns.heads) != disc.heads:
        raise ValueError(
            f"the axis' orbit needs {LEAST_HEADS} heads or more, each calibrated; found "
            f"{len(turns.heads)} in the capture and {disc.heads} in the calibration"
        )
    places = disc.places_rad
    unit = 2.0 * np.pi / counts_per_rev
    rows = []
    for head, counts in enumerate(turns.heads):
        reading = counts * unit - disc.offsets_rad[head]
        error = disc.under_head(head, reading + places[head]) * RAD_PER_ARCSEC
        rows.append(reading - error)
    # The readings of two heads may differ by whole turns.
    readings = np.array(rows)
    whole = np.rint((readings - readings[0]).mean(axis=1) / (2.0 * np.pi))
    readings -= 2.0 * np.pi * whole[:, np.newaxis]
    shares = np.stack([np.ones(places.size), np.sin(places), np.cos(places)], axis=1)
    inverse = np.linalg.pinv(shares)
    angle, x, y = inverse @ readings
    x, y = ((values - values.mean()) / RAD_PER_ARCSEC for values in (x, y))
    u_x, u_y = np.sqrt((inverse[1:] ** 2).sum(axis=1)) * noise_arcsec
    return AxisOrbit(angle, x, y, (float(u_x), float(u_y)), disc.heads >= SEPARATING_HEADS)
