"""Calibrates with two to four heads: by their weighted mean, or by least squares for disc, places
of the heads and motion of the axis.

``places_deg`` of a method are distances from head 1 to the other heads: a head at the distance p
stands at the stator angle −p. The samples of all turns at one angle are added, because the
simulated motion repeats these angles.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.head_weights import mean_weights
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_estimate import HeadsEstimate
from arctrue.calibration.heads_gain import MotionOrders
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.calibration.mean_banks import HeadsOnDisc, mean_error_arcsec
from arctrue.studies.methods.method import Method
from arctrue.studies.methods.world import MOUNTING_ARCSEC, Output, World
from arctrue.table import DISC_RADIUS_M

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOTION_ORDERS = tuple(range(1, 9))
"""Orders of a bearing's motion in the fit; order 1 means the backward circle only."""


def averaged_turn(world: World, places_deg: Sequence[float]) -> tuple[WholeTurns, int]:
    """Add the samples of all turns at equal angles; return the sums as one turn, and their number
    of counts per turn."""
    places = -np.radians(np.asarray(places_deg, dtype=np.float64))
    given = world.settings
    total: Integer | None = None
    for turn, counts in enumerate(world.turns(places.tolist())):
        own = counts - turn * given.counts_per_rev
        total = own if total is None else total + own
    assert total is not None
    fine = given.counts_per_rev * given.turns
    step = fine / given.samples_a_turn
    return WholeTurns(0, 1, total[0], total[1], step, 0, tuple(total[2:])), fine


def estimated(world: World, places_deg: Sequence[float], motion: MotionOrders) -> HeadsEstimate:
    """Estimate the disc's error by least squares; the heads' places are known to ± 50″, and the
    settings state the uncertainty of their index marks."""
    part, fine = averaged_turn(world, places_deg)
    radius = world.settings.radius_tolerance_m / DISC_RADIUS_M / float(np.sqrt(3.0))
    return heads_least_squares(
        [part],
        fine,
        np.radians(places_deg).tolist(),
        HeadsSettings(
            orders=world.settings.orders,
            motion=motion,
            u_place_arcsec=MOUNTING_ARCSEC / float(np.sqrt(3.0)),
            u_index_arcsec=max(world.settings.index_detection_arcsec / float(np.sqrt(3.0)), 0.1),
            u_radius=radius,
        ),
    )


def _stator(places_deg: Sequence[float]) -> tuple[float, ...]:
    return tuple((-np.radians(np.asarray(places_deg, dtype=np.float64))).tolist())


def _head1(world: World, places_deg: Sequence[float], motion: MotionOrders) -> Output:
    found = estimated(world, places_deg, motion)
    return Output.of_head1(
        lambda reading: found.state.of_head(0, 0, np.exp(1j * reading), reading).expected
    )


def _mean(places_deg: Sequence[float], weights: Float, offsets_rad: Float) -> Output:
    """Return the weighted mean of the readings after subtraction of each head's offset."""

    def angle(reading: Float) -> Float:
        own = reading - offsets_rad[:, None]
        apart = np.angle(np.exp(1j * (own - own[0])))
        return np.asarray(own[0] + weights @ apart)

    return Output(_stator(places_deg), angle)


def _uncalibrated(world: World, places_deg: Sequence[float]) -> Output:
    part, fine = averaged_turn(world, places_deg)
    offsets = np.array([float(np.mean(head - part.heads[0])) for head in part.heads])
    weights = mean_weights(np.radians(places_deg))
    return _mean(places_deg, weights, offsets * (2.0 * np.pi / fine))


def _calibrated(world: World, places_deg: Sequence[float], motion: MotionOrders) -> Output:
    found = estimated(world, places_deg, motion)
    disc: HeadsOnDisc = found.on_disc()
    weights = mean_weights(disc.places_rad, disc.radius_ratios)
    mean = _mean(places_deg, weights, disc.offsets_rad)

    def angle(reading: Float) -> Float:
        return np.asarray(
            mean.angle(reading) - mean_error_arcsec(disc, weights, 0, reading[0]) * RAD_PER_ARCSEC
        )

    return Output(mean.places_rad, angle)


def least_squares_of(
    name: str, places_deg: Sequence[float], motion: MotionOrders, *, title: str = ""
) -> Method:
    """Return the method that corrects head 1 by the error that all heads at ``places_deg``
    determine."""
    heads = len(places_deg)
    return Method(
        name,
        title or f"{heads} heads, least squares" + (", with the axis' motion" if motion else ""),
        "Geckeler et al. [9]; Zhao et al. [14]" if motion else "Geckeler et al. [8, 9]",
        heads,
        f"heads at {_named(places_deg)}",
        "attributes motion above order 8 to the disc; does not correct motion that does not repeat "
        "every turn"
        if motion
        else "attributes all axis motion to the disc",
        lambda world: _head1(world, places_deg, motion),
    )


def mean_of(name: str, places_deg: Sequence[float], source: str) -> Method:
    """Return the method of a weighted mean of the heads; only the counters' offsets are
    calibrated."""
    heads = len(places_deg)
    return Method(
        name,
        f"Mean of {heads} heads, uncalibrated",
        source,
        heads,
        f"heads at {_named(places_deg)}",
        "the part of the disc error that is equal at all heads, and the order 1 caused by unequal "
        "head radii",
        lambda world: _uncalibrated(world, places_deg),
        "mean",
    )


def calibrated_mean_of(name: str, places_deg: Sequence[float], motion: MotionOrders) -> Method:
    """Return the method of a weighted mean, minus the error of the disc that the mean contains."""
    heads = len(places_deg)
    known = "motion unknown at every order" if motion == "every" else "motion at orders 1 to 8"
    return Method(
        name,
        f"Mean of {heads} heads, calibrated, {known if motion else 'axis assumed at rest'}",
        "this project",
        heads,
        f"heads at {_named(places_deg)}",
        "the order 1 caused by unequal head radii"
        + ("" if motion else "; attributes all axis motion to the disc"),
        lambda world: _calibrated(world, places_deg, motion),
        "mean",
    )


def _named(places_deg: Sequence[float]) -> str:
    return ", ".join(f"{place:g}°" for place in places_deg)
