"""Runs all methods on the same table, and evaluates a third and a fourth head."""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.progress import ReportStep
from arctrue.calibration.head_weights import WeightsRefusedError, mean_weights
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_gain import MotionOrders, order_gain
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.methods.equal_division import equal_division
from arctrue.studies.methods.free_spin import FREE_SPIN
from arctrue.studies.methods.heads_least_squares import (
    MOTION_ORDERS,
    averaged_turn,
    calibrated_mean_of,
    least_squares_of,
    mean_of,
)
from arctrue.studies.methods.method import Method
from arctrue.studies.methods.polygon_closure import POLYGON_CLOSURE
from arctrue.studies.methods.reference_table import LOOK_UP_TABLE, REFERENCE_HARMONICS
from arctrue.studies.methods.two_heads_dft import (
    MEASURED_DFT,
    PAPER_DFT,
    TWO_HEADS_LEAST_SQUARES,
)
from arctrue.studies.methods.world import BLIND_ORDER, WEAK_ORDER, MethodsSettings, World
from arctrue.table import HEAD_PLACES_DEG

JUDGED_ORDERS = np.arange(1, 129)
TWO_DEG = HEAD_PLACES_DEG[2]
THREE_DEG = HEAD_PLACES_DEG[3]
FOUR_DEG = HEAD_PLACES_DEG[4]
SPARE_DEG = (0.0, 64.3, 177.0, 257.9)
"""Places of four heads at which any three heads suffice if the fourth fails; result of ``arctrue
alpha --heads 4``."""
AT_REST_MOTION_M = 0.0
PAIRED = "encoder makers' paired heads"


@dataclass(frozen=True)
class Places:
    """Places of a set of heads, with the noise gains of the orders."""

    title: str
    places_deg: tuple[float, ...]
    motion: MotionOrders
    gain: NDArray[np.float64]
    """Noise gain of each order, ``(orders,)``."""
    mean_noise: float
    """Noise of one reading of the weighted mean, in units of the noise of one head; inf if no
    usable mean exists."""


def places() -> tuple[Places, ...]:
    """Return sets of two to four heads; each set states at which orders the motion of the axis is
    unknown."""
    sets: tuple[tuple[str, tuple[float, ...], MotionOrders], ...] = (
        ("2 heads, axis at rest", TWO_DEG, ()),
        ("3 heads, axis at rest", THREE_DEG, ()),
        ("4 heads, axis at rest", FOUR_DEG, ()),
        ("4 heads, motion unknown at orders 1 to 8", FOUR_DEG, MOTION_ORDERS),
        ("4 heads, motion unknown at every order", FOUR_DEG, "every"),
        ("4 heads of which one may fail, motion unknown at every order", SPARE_DEG, "every"),
    )
    return tuple(
        Places(title, at, motion, order_gain(np.radians(at), JUDGED_ORDERS, motion), _noise(at))
        for title, at, motion in sets
    )


def _noise(places_deg: tuple[float, ...]) -> float:
    try:
        return float(np.linalg.norm(mean_weights(np.radians(places_deg))))
    except WeightsRefusedError:
        return float("inf")


def methods() -> tuple[Method, ...]:
    """Return all methods; the methods that compute the angle from one head come first."""
    return (
        LOOK_UP_TABLE,
        REFERENCE_HARMONICS,
        POLYGON_CLOSURE,
        FREE_SPIN,
        equal_division(4),
        equal_division(12),
        PAPER_DFT,
        MEASURED_DFT,
        TWO_HEADS_LEAST_SQUARES,
        least_squares_of("three_heads_least_squares", THREE_DEG, ()),
        least_squares_of("four_heads_least_squares", FOUR_DEG, MOTION_ORDERS),
        mean_of("mean_of_two", (0.0, 180.0), PAIRED),
        mean_of("mean_of_three", (0.0, 120.0, 240.0), PAIRED),
        mean_of("mean_of_four", SPARE_DEG, PAIRED),
        calibrated_mean_of("mean_of_three_calibrated", THREE_DEG, ()),
        calibrated_mean_of("mean_of_four_calibrated", SPARE_DEG, "every"),
    )


def compare_methods(
    settings: MethodsSettings, report_step: ReportStep | None = None
) -> dict[str, Any]:
    """Run all methods with a moving and with a resting axis; return the results as plain values.

    The results of the moving axis are evaluated again after the ball pass of the bearing and a
    shift of the hub were added. Raises ValueError for a time of measurement that is too short for a
    method.
    """
    sets = places()
    found: dict[str, Any] = {
        "schema": 1,
        "settings": dataclasses.asdict(settings)
        | {"turns": settings.turns, "cycles": settings.cycles},
        "places": [_placed(one) for one in sets],
        "methods": [],
    }
    moving = World(settings)
    still = World(dataclasses.replace(settings, radial_motion_m=AT_REST_MOTION_M))
    found["uncorrected"] = _scored(moving.score(None)) | {
        "rms_later_arcsec": moving.score(None, later=True).edges_rms_arcsec
    }
    found["own_places"] = _own_places(settings)
    for method in methods():
        if report_step is not None:
            report_step(method.title)
        output = method.run(moving)
        score, later = moving.score(output), moving.score(output, later=True)
        at_rest = still.score(method.run(still))
        found["methods"].append(
            {
                "name": method.name,
                "title": method.title,
                "source": method.source,
                "heads": method.heads,
                "output": method.output,
                "needs": method.needs,
                "cannot_see": method.cannot_see,
                **_scored(score),
                "rms_without_motion_arcsec": at_rest.edges_rms_arcsec,
                "rms_later_arcsec": later.edges_rms_arcsec,
                "amplitude_without_motion_arcsec": at_rest.amplitude_arcsec.tolist(),
            }
        )
    return found


def _own_places(settings: MethodsSettings) -> list[dict[str, Any]]:
    """Return the uncertainty with which four heads determine their own places in one turn while the
    axis does not move."""
    one_turn = dataclasses.replace(
        settings,
        minutes=6.0 / settings.speed_deg_s,
        radial_motion_m=AT_REST_MOTION_M,
        radius_tolerance_m=0.0,
    )
    part, fine = averaged_turn(World(one_turn), FOUR_DEG)
    cases: tuple[tuple[str, MotionOrders], ...] = (
        ("the fit assumes no motion", ()),
        ("the fit allows motion at order 1", (1,)),
        ("the fit allows motion at orders 1 to 8", MOTION_ORDERS),
    )
    found = []
    for title, motion in cases:
        estimate = heads_least_squares(
            [part],
            fine,
            np.radians(FOUR_DEG).tolist(),
            HeadsSettings(one_turn.orders, motion, u_place_arcsec=np.inf, u_radius=0.0),
        )
        found.append({"motion": title, "u_arcsec": estimate.u_places_arcsec[1:].tolist()})
    return found


def _scored(score: TurnScore) -> dict[str, Any]:
    return {
        "span_arcsec": list(score.every_edge_arcsec),
        "rms_arcsec": score.edges_rms_arcsec,
        "amplitude_arcsec": score.amplitude_arcsec.tolist(),
    }


def _placed(one: Places) -> dict[str, Any]:
    def finite(value: float) -> float | None:
        return float(value) if np.isfinite(value) else None

    return {
        "title": one.title,
        "places_deg": list(one.places_deg),
        "mean_noise": finite(one.mean_noise),
        "worst_gain_to_40": finite(one.gain[:40].max()),
        "worst_gain_to_64": finite(one.gain[:64].max()),
        "worst_gain_to_128": finite(one.gain.max()),
        "gain_weak_order": finite(one.gain[WEAK_ORDER - 1]),
        "gain_blind_order": finite(one.gain[BLIND_ORDER - 1]),
        "gain": [finite(value) for value in one.gain],
    }
