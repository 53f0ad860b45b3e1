"""Makes a model for a set with only a reference run, with the orders that its stations, or the arc
of its rows, can separate."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.inference.visits_of_places import visits_of_rows
from arctrue.workbench.model.model import Model, ModelEffect, default_model
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations import Observations, ReferenceRows

MOST_ORDER = 20
"""Highest order of the model; it equals the highest order of the default model."""
LEAST_ORDER = 2
"""Smallest allowed value of the highest order: a correction needs eccentricity and ovality."""


def model_of_stations(rows: ReferenceRows, most_order: int = MOST_ORDER) -> Model:
    """Make a model of harmonics 1 to N of the turn; half a wave of order N is longer than each gap.

    A gap is the distance of two neighbouring stations. At evenly spaced stations, two orders are
    aliases if their sum is the number of stations. Orders above N could take any value between the
    stations. ``most_order``: upper limit of N. Raises ValueError if a gap makes N less than
    LEAST_ORDER.
    """
    gap = _largest_gap_deg(rows.target_rad)
    most = min(math.ceil(180.0 / gap - 1e-6) - 1, MOST_ORDER)
    if most < LEAST_ORDER:
        raise ValueError(
            f"the reference run has no target over {gap:.1f}° of the turn, and the set has no "
            f"capture: expected targets less than {180.0 / LEAST_ORDER:g}° apart all "
            "around; measure the missing part of the turn, or give a model with --model"
        )
    return Model(
        [ModelEffect("graduation_harmonics", {"orders": list(range(1, min(most, most_order) + 1))})]
    )


def require_whole_turn(observations: Observations) -> None:
    """Raise ValueError if the rows of a set leave a gap in the turn of half a wave of order
    MOST_ORDER or more. This order, the highest of the default model, could take any value in the
    gap.
    """
    rows = [
        part.angle_rad
        for part in (observations.capture, observations.every_reference_row)
        if part is not None
    ]
    gap = _largest_gap_deg(np.concatenate(rows))
    if gap >= 180.0 / MOST_ORDER:
        raise ValueError(
            f"the set has no row over {gap:.1f}° of the turn: expected rows less than "
            f"{180.0 / MOST_ORDER:g}° apart all around; capture a whole turn, or take the capture "
            "out of the set, or give a model with --model"
        )


SHORT_ARC_DEG = 270.0
"""An arc shorter than three quarters of a turn is short: the default model there keeps only the
orders that the arc determines. On a longer arc, each order from 1 on completes most of a wave."""
HALF_TURN_DEG = 180.0
"""On a shorter arc the model has no order: the eccentricity, which every table has, is then a slow
curve, and the orders above it could describe any curve on this arc."""
MOST_INFLATED = 10.0
"""Largest standard uncertainty of a coefficient on a short arc, as a multiple of that over whole
turns with as many rows. Orders that cancel each other have far larger multiples: for 20 orders on
240°, more than 10⁸, and their coefficients follow any slow error."""
LEAST_REPEATED = 0.9
"""Smallest share of the rows at places that at least two passes visited, if the passes share a
curve of the angle. With a smaller share, a part of the arc was passed only once, and the curve
would contain a drift there."""
MOST_ROWS = 4000
"""Largest number of rows with which the orders that the arc determines are found; 200 for each wave
of order 20 in a turn."""
DISC = "graduation_harmonics"


def on_its_arc(model: Model, observations: Observations) -> Model:
    """Return the model with only those default orders that a short arc determines.

    This concerns a set without capture whose reference covers less than SHORT_ARC_DEG, and an
    effect ``graduation_harmonics`` with neither orders nor coefficients of its own. Over a short
    arc the orders are slow curves: least squares makes them so large that they cancel each other,
    and any slow error disappears in them. If no order remains, the model has only the constant.
    """
    rows = observations.every_reference_row
    if observations.capture is not None or rows is None:
        return model
    if not any(_is_default(entry) for entry in model.effects):
        return model
    arc_deg = 360.0 - _largest_gap_deg(rows.target_rad)
    if arc_deg >= SHORT_ARC_DEG:
        return model
    curves = _curves_of_the_passes(observations, rows)
    kept = _determined_orders(rows) if curves is None and arc_deg >= HALF_TURN_DEG else []
    disc = [ModelEffect(DISC, curves or {"orders": kept})] if curves or kept else []
    parts = [disc if _is_default(entry) else [entry] for entry in model.effects]
    return replace(model, effects=[entry for part in parts for entry in part])


def _curves_of_the_passes(
    observations: Observations, every: ReferenceRows
) -> dict[str, object] | None:
    """Return the settings of ``graduation_harmonics`` for passes that visit the same places of an
    arc; None if the passes do not."""
    rows = observations.reference
    visits = None if rows is None else visits_of_rows(rows)
    if visits is None or float(np.mean(visits.of_row >= 0)) < LEAST_REPEATED:
        return None
    angles = np.unique(np.round(np.degrees(every.target_rad) % 360.0, 6))
    gaps = np.diff(np.append(angles, angles[0] + 360.0))
    widest = int(np.argmax(gaps))
    start, length = float(angles[(widest + 1) % angles.size]), 360.0 - float(gaps[widest])
    gap = float(np.delete(gaps, widest).max())
    # Half a wave of the highest order is longer than each gap between the stations.
    most = min(math.ceil(180.0 / gap - 1e-6) - 1, MOST_ORDER)
    if most < LEAST_ORDER:
        return None
    return {"orders": list(range(1, most + 1)), "arc_deg": [round(start, 6), round(length, 6)]}


def _is_default(entry: ModelEffect) -> bool:
    return entry.name == DISC and not entry.settings and not entry.coefficients


TURN_RAD_SHARE = 0.9
"""Targets look like one turn in radians if they cover at least this share of 6.28°. Ten stations of
a turn cover nine tenths, because the last station does not repeat the first."""
WHOLE_TURN_RAD = 2.0 * np.pi + 0.005
"""Largest arc, in degrees, that looks like one turn in radians: 2π, written with two decimals."""


def warnings_of_the_arc(model: Model, observations: Observations) -> list[str]:
    """Return the warning that :func:`on_its_arc` omits orders of this model; an empty list if it
    keeps all."""
    rows, after = observations.every_reference_row, on_its_arc(model, observations)
    if model == after or rows is None:
        return []
    disc = next((e.settings for e in after.effects if e.name == DISC), {})
    orders = disc.get("orders")
    arc_deg = float(np.degrees(np.ptp(rows.target_rad)))
    in_radians = ""
    if TURN_RAD_SHARE * 2.0 * np.pi <= arc_deg <= WHOLE_TURN_RAD:
        in_radians = "; one turn is 6.28 radians, and target_deg must be in degrees"
    said = str(orders).strip("[]")
    covered = f"the reference covers {360.0 - _largest_gap_deg(rows.target_rad):.3g}° of the turn"
    if "arc_deg" in disc:
        return [
            f"{covered}: in place of the orders of the disc the model contains a smooth curve of "
            "the angle, equal in all passes: an error of the disc or of the reference's scale is "
            f"part of it; --model chooses orders{in_radians}"
        ]
    kept = "no order of the disc" if orders is None else f"only the orders {said} of the disc"
    return [
        f"{covered}: the model contains {kept}, because other orders look like a slow drift there; "
        f"--model chooses orders{in_radians}"
    ]


def warnings_of_a_kept_arc(model: Model, observations: Observations) -> list[str]:
    """Return the warning of the default model if a stored model has exactly those orders of the
    default model that :func:`on_its_arc` keeps."""
    usual = default_model()
    kept = [entry.settings for entry in on_its_arc(usual, observations).effects]
    if [entry.settings for entry in model.effects if entry.name == DISC] != kept:
        return []
    return warnings_of_the_arc(usual, observations)


def _determined_orders(rows: ReferenceRows) -> list[int]:
    """Return the orders that the rows determine, from the lowest on."""
    angle_rad = rows.angle_rad[:: math.ceil(rows.angle_rad.size / MOST_ROWS)]
    kept: list[int] = []
    for order in range(1, MOST_ORDER + 1):
        columns = harmonic_columns(angle_rad, [*kept, order])
        columns -= columns.mean(axis=0)
        # The inverse of this matrix is the identity over whole turns.
        normal = 2.0 / angle_rad.size * (columns.T @ columns)
        values, vectors = np.linalg.eigh(normal)
        variances = (vectors**2 / np.maximum(values, 1e-12)).sum(axis=1)
        if variances.max() <= MOST_INFLATED**2:
            kept.append(order)
    return kept


def _largest_gap_deg(angle_rad: NDArray[np.float64]) -> float:
    angles = np.unique(np.round(np.degrees(angle_rad) % 360.0, 6))
    return float(np.diff(np.append(angles, angles[0] + 360.0)).max())
