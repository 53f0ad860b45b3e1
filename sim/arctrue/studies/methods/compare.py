"""All methods on the same table, and what a third and a fourth head bring."""

from __future__ import annotations

import dataclasses
from typing import Any

import numpy as np

from arctrue.base.progress import ReportStep
from arctrue.instrument.turn_score import TurnScore
from arctrue.studies.methods.equal_division import equal_division
from arctrue.studies.methods.free_spin import FREE_SPIN
from arctrue.studies.methods.head_places import (
    Places,
    best_further_two,
    best_third,
    gain_of_places,
)
from arctrue.studies.methods.heads_least_squares import MOTION_ORDERS, least_squares_of
from arctrue.studies.methods.method import Method
from arctrue.studies.methods.polygon_closure import POLYGON_CLOSURE
from arctrue.studies.methods.reference_table import LOOK_UP_TABLE, REFERENCE_HARMONICS
from arctrue.studies.methods.two_heads_dft import (
    MEASURED_DFT,
    PAPER_DFT,
    TWO_HEADS_LEAST_SQUARES,
)
from arctrue.studies.methods.virtual_division import VIRTUAL_DIVISION
from arctrue.studies.methods.world import BLIND_ORDER, WEAK_ORDER, MethodsSettings, World

PLACED_ORDERS = np.arange(1, 129)
"""Orders for which the further heads are placed."""
FIRST_DEG = (0.0, 33.0)
UNCORRECTED = "uncorrected"
AT_REST_MOTION_M = 0.0


def places() -> tuple[Places, ...]:
    """The paper's two heads, with a third, and with two more at their best places."""
    third = best_third(FIRST_DEG, PLACED_ORDERS)
    further = best_further_two(FIRST_DEG, PLACED_ORDERS, MOTION_ORDERS)
    sets = (
        ("2 heads", FIRST_DEG, False),
        ("3 heads", (*FIRST_DEG, third), False),
        ("4 heads", (*FIRST_DEG, *further), False),
        ("4 heads, motion of the axis unknown", (*FIRST_DEG, *further), True),
    )
    none = np.zeros(0, dtype=np.int64)
    return tuple(
        Places(
            title,
            at,
            motion,
            gain_of_places(-np.radians(at), PLACED_ORDERS, MOTION_ORDERS if motion else none),
        )
        for title, at, motion in sets
    )


def methods(sets: tuple[Places, ...]) -> tuple[Method, ...]:
    """Every method, in the order of the paper's introduction; ``sets`` as from :func:`places`."""
    _, three, _, four = sets
    return (
        LOOK_UP_TABLE,
        REFERENCE_HARMONICS,
        POLYGON_CLOSURE,
        FREE_SPIN,
        equal_division(4),
        equal_division(12),
        VIRTUAL_DIVISION,
        PAPER_DFT,
        MEASURED_DFT,
        TWO_HEADS_LEAST_SQUARES,
        least_squares_of("three_heads_least_squares", three.places_deg, motion=False),
        least_squares_of("four_heads_least_squares", four.places_deg, motion=True),
    )


def compare_methods(
    settings: MethodsSettings, progress: ReportStep | None = None
) -> dict[str, Any]:
    """Run every method with the bearing that moves and with one that does not; plain values.

    Raises ValueError for a time of measurement that is too short for a method.
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
    found["uncorrected"] = _scored(moving.score(None))
    for method in methods(sets):
        if progress is not None:
            progress(method.title)
        score, at_rest = (world.score(method.run(world)) for world in (moving, still))
        found["methods"].append(
            {
                "name": method.name,
                "title": method.title,
                "source": method.source,
                "heads": method.heads,
                "needs": method.needs,
                "cannot_see": method.cannot_see,
                **_scored(score),
                "rms_without_motion_arcsec": at_rest.edges_rms_arcsec,
                "amplitude_without_motion_arcsec": at_rest.amplitude_arcsec.tolist(),
            }
        )
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
        "worst_gain_to_40": finite(one.gain[:40].max()),
        "worst_gain_to_128": finite(one.gain.max()),
        "gain_weak_order": finite(one.gain[WEAK_ORDER - 1]),
        "gain_blind_order": finite(one.gain[BLIND_ORDER - 1]),
        "gain": [finite(value) for value in one.gain],
    }
