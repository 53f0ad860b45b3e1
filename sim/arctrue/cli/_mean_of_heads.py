"""Prints the calibration of the mean of all heads, for ``arctrue calibrate --angle mean``."""

from __future__ import annotations

from typing import Any

import numpy as np

from arctrue.base.figures import figure
from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.calibration.heads_calibration import MeanCalibration
from arctrue.calibration.heads_gain import MotionOrders
from arctrue.cli._orders import listed_orders
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import Console
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.mean_set import WEIGHT_ONE, MeanSet


def motion_orders(text: str | None) -> MotionOrders | None:
    """Parse ``every``, ``none`` or a list of orders such as ``1-8`` or ``2,3,9``. Raises
    ValueError."""
    if text is None or text == "every":
        return text  # type: ignore[return-value]
    if text == "none":
        return ()
    try:
        return listed_orders(text)
    except ValueError:
        raise ValueError(
            f"--motion {text}: expected every, none, or orders such as 1-8 (first ≤ last) or 2,3,9"
        ) from None


def print_mean(console: Console, found: MeanCalibration) -> None:
    """Print the heads (place, radius, weight), the motion of the axis, and the disc's orders."""
    estimate = found.estimate
    console.print(
        f"{len(estimate.places_rad)} heads: {estimate.samples:,} samples, "
        f"{estimate.noise_arcsec:.3f}″ noise of one reading",
        soft_wrap=True,
    )
    sets = [_mean_of(found.coefficients), *(_mean_of(one) for one in _without(found.coefficients))]
    heads = table(
        "Heads",
        *map(number, ("head", "place °", "u ″", "radius\nratio − 1", "u", "offset\ncounts")),
        *(number("weight" if not one.missing else f"without\n{one.missing}") for one in sets),
    )
    for head in range(estimate.places_rad.size):
        heads.add_row(
            str(head + 1),
            f"{np.degrees(estimate.places_rad[head]):.6f}",
            figure(estimate.u_places_arcsec[head], 2),
            f"{estimate.radius_ratios[head] - 1.0:+.1e}",
            f"{estimate.u_radius_ratios[head]:.0e}",
            f"{sets[0].offsets[head] / 16.0:.2f}",
            *(f"{one.weights[head] / WEIGHT_ONE:.4f}" for one in sets),
        )
    console.print(heads)
    if estimate.axis_motion:
        motion = table(
            "Motion of the axis, ″ at the disc's radius",
            number("order"), words("circle"), number("amplitude"), number("u"),
        )  # fmt: skip
        for circle in estimate.axis_motion:
            motion.add_row(
                str(circle.order),
                "forward" if circle.sense > 0 else "backward",
                figure(abs(circle.value_arcsec), 4),
                figure(circle.u_arcsec, 4),
            )
        console.print(motion)
    orders = table(
        "Orders of the disc, and their amplitudes in the mean of the heads",
        *map(number, ("order", "disc ″", "noise\ngain", "mean ″", "u ″")), words(),
    )  # fmt: skip
    for row in figures(found)["orders"]:
        orders.add_row(
            str(row["order"]),
            figure(row["amplitude_arcsec"], 4),
            "∞" if row["noise_gain"] is None else figure(row["noise_gain"], 2),
            figure(row["mean_arcsec"], 4),
            figure(row["u_mean_arcsec"], 4),
            "applied" if row["applied"] else "not significant",
        )
    console.print(orders)


def figures(found: MeanCalibration) -> dict[str, Any]:
    """Return the figures of the calibration for the file of ``--json``."""
    estimate = found.estimate
    weights = np.array(_mean_of(found.coefficients).weights) / WEIGHT_ONE
    mean, u_mean = estimate.mean_orders(weights)
    amplitude = np.hypot(*np.split(estimate.values, 2))
    gain = estimate.noise_gain
    return {
        "output": "mean",
        "places_deg": np.degrees(estimate.places_rad).tolist(),
        "u_places_arcsec": estimate.u_places_arcsec.tolist(),
        "radius_ratios": estimate.radius_ratios.tolist(),
        "u_radius_ratios": estimate.u_radius_ratios.tolist(),
        "offsets_arcsec": (estimate.offsets_rad * ARCSEC_PER_RAD).tolist(),
        "noise_arcsec": estimate.noise_arcsec,
        "weights": weights.tolist(),
        "axis_motion": [
            {
                "order": circle.order,
                "sense": circle.sense,
                "value_arcsec": [circle.value_arcsec.real, circle.value_arcsec.imag],
                "u_arcsec": circle.u_arcsec,
            }
            for circle in estimate.axis_motion
        ],
        "orders": [
            {
                "order": order,
                "amplitude_arcsec": float(amplitude[i]),
                "noise_gain": float(gain[i]) if np.isfinite(gain[i]) else None,
                "mean_arcsec": float(abs(mean[i])),
                "u_mean_arcsec": float(u_mean[i]),
                "applied": bool(found.applied[i]),
            }
            for i, order in enumerate(estimate.orders.tolist())
        ],
        "warnings": list(found.warnings),
        "refused": list(found.objections),
    }


def _mean_of(coefficients: Coefficients) -> MeanSet:
    assert coefficients.extension is not None
    assert coefficients.extension.mean is not None
    return coefficients.extension.mean


def _without(coefficients: Coefficients) -> tuple[Coefficients, ...]:
    return () if coefficients.extension is None else coefficients.extension.without
