"""Calibrates a set of three or four heads in four steps: verify, fit, choose orders, quantise."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration import acceptance
from arctrue.calibration.capture_check import WholeTurns, whole_turns
from arctrue.calibration.head_separation import U_DETECTION_DEFAULT_ARCSEC
from arctrue.calibration.heads_data import U_PLACE_DEFAULT_ARCSEC, U_RADIUS_DEFAULT, HeadsSettings
from arctrue.calibration.heads_estimate import HeadsEstimate
from arctrue.calibration.heads_gain import MotionOrders
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.calibration.mean_banks import mean_banks
from arctrue.calibration.selection import significance_factor
from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import LANES_DEFAULT
from arctrue.measurement.measurement_set import MeasurementSet


@dataclass(frozen=True)
class MeanSettings:
    """Settings of the calibration of the mean.

    ``motion``: None means that motion is unknown at every order with four heads, and absent
    otherwise; ``runs``: None means the runs at the lowest speed; ``u_radius``: standard uncertainty
    of the ratio of a head's radius to the disc's.
    """

    runs: Sequence[int] | None = None
    most_order: int = 32
    lanes: int = LANES_DEFAULT
    motion: MotionOrders | None = None
    u_place_arcsec: float = U_PLACE_DEFAULT_ARCSEC
    u_radius: float = U_RADIUS_DEFAULT


@dataclass(frozen=True)
class MeanCalibration:
    """The estimate, and the gateware's words for the mean of all heads and the means without one
    head."""

    estimate: HeadsEstimate
    coefficients: Coefficients
    turns: tuple[WholeTurns, ...]
    applied: NDArray[np.bool_]
    """True for the estimate's orders whose amplitude is significant, (N,)."""
    objections: tuple[str, ...]
    warnings: tuple[str, ...] = field(default=())


def calibrate_mean(
    measurement: MeasurementSet, settings: MeanSettings | None = None
) -> MeanCalibration:
    """Calibrate the weighted mean of all heads of a capture.

    Raises CaptureRefusedError for a capture that cannot be used, and SingularHeadsError for
    unknowns that the heads do not determine. Raises ValueError for a set without a capture, counts
    per turn or head places, and for places that have no mean.
    """
    settings = settings or MeanSettings()
    capture, table = measurement.capture, measurement.table
    if capture is None:
        raise ValueError("the set has no capture: there is nothing to calibrate from")
    if table.counts_per_rev is None or table.places_deg is None:
        raise ValueError("a capture needs table.counts_per_rev and table.head_places_deg")
    heads = len(table.places_deg)
    motion: MotionOrders = ("every" if heads == 4 else ()) if settings.motion is None else (
        settings.motion
    )  # fmt: skip
    turns = whole_turns(capture, table.counts_per_rev, settings.runs, settings.most_order)
    detection = table.index_detection_arcsec
    estimate = heads_least_squares(
        turns,
        table.counts_per_rev,
        np.radians(table.places_deg).tolist(),
        HeadsSettings(
            np.arange(1, settings.most_order + 1),
            motion,
            settings.u_place_arcsec,
            U_DETECTION_DEFAULT_ARCSEC if detection is None else detection,
            settings.u_radius,
        ),
    )
    number = estimate.orders.size
    variance = np.diag(estimate.disc_covariance).reshape(2, -1).mean(axis=0)
    amplitude = np.hypot(*np.split(estimate.values, 2))
    applied = amplitude > significance_factor(number) * np.sqrt(variance)
    disc = estimate.on_disc()
    kept = replace(disc, values=np.where(np.tile(applied, 2), disc.values, 0.0))
    coefficients, refused = mean_banks(kept, table.counts_per_rev, lanes=settings.lanes)
    warnings = [f"no set for a missing head: {one}" for one in refused] if heads == 4 else []
    hidden = estimate.unseen_orders
    if hidden.size:
        listed = ", ".join(map(str, hidden[:6].tolist())) + (", …" if hidden.size > 6 else "")
        warnings.append(f"these heads do not determine order {listed} if the axis may move there")
    return MeanCalibration(
        estimate,
        coefficients,
        tuple(turns),
        applied,
        tuple(acceptance.of_limits(coefficients)),
        tuple(warnings),
    )
