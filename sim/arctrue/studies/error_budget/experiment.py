"""Computes the uncertainty budget of the experiment in the form of EURAMET cg-23, and E_n between
self-calibration and polygon.

The polygon is remounted in every cycle, and the closure separates its faces from the table, so that
no certificate is needed; the uncertainties of the autocollimator, the scatter, and the mounting
remain. The two heads of the same table give a second result. E_n is the difference of the two
results divided by √(U₁² + U₂²); they agree if |E_n| ≤ 1 (ISO 13528, ISO/IEC 17043).
"""

from __future__ import annotations

import dataclasses
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, arcsec_per_count
from arctrue.calibration.least_squares import least_squares
from arctrue.metrology.budget import COVERAGE, Budget, Contribution
from arctrue.studies.methods.polygon_closure import Closure, closure, spread_shifts
from arctrue.studies.methods.two_heads_dft import SEPARATION_RAD, captured
from arctrue.studies.methods.world import BLIND_ORDER, MethodsSettings, World
from arctrue.studies.paper.budget import mounting_eccentricity_rad, tower_difference_rad
from arctrue.studies.paper.published import PUBLISHED

Float = NDArray[np.float64]


def closure_budget(found: Closure, counts_per_rev: int) -> Budget:
    """Return the uncertainty budget of the table's error at a face, if it is measured by
    re-indexing without a certificate."""
    published = PUBLISHED
    fourth = ARCSEC_PER_RAD * mounting_eccentricity_rad(
        published.mounting_offset_m, published.flatness_m, published.face_width_m
    )
    fifth = ARCSEC_PER_RAD * tower_difference_rad(
        2.0 * np.pi / published.faces, published.tilt_arcsec / ARCSEC_PER_RAD
    )
    scatter = float(np.sqrt(np.mean(found.u_table_arcsec**2)))
    return Budget(
        "closure with a polygon that is remounted in every cycle",
        (
            Contribution(
                "scatter of the readings",
                "residuals of the closure's least-squares fit, propagated to the table's error",
                "A",
                "normal",
                found.scatter_arcsec,
                scatter / found.scatter_arcsec,
                float(found.degrees_of_freedom),
            ),
            Contribution(
                "autocollimator",
                "certificate of the autocollimator, Table 2: 0.1″ (k = 2)",
                "B",
                "normal",
                published.budget.autocollimator_arcsec,
            ),
            Contribution("mounting eccentricity, (14)", "s ≤ 1 µm", "B", "rectangular", fourth),
            Contribution("tower difference, (15)", "τ ≤ 8″", "B", "rectangular", fifth),
            Contribution(
                "reading of head 1, resolution",
                "half a count",
                "B",
                "rectangular",
                0.5 * arcsec_per_count(counts_per_rev),
            ),
        ),
        (),
        ("temperature of the polygon", "orders from 12 on between the faces"),
        (),
    )


def experiment_budget() -> dict[str, Any]:
    """Return the uncertainty budget, and E_n at 24 faces for a resting and for a moving axis, as
    plain values."""
    moving = MethodsSettings()
    still = dataclasses.replace(moving, radial_motion_m=0.0)
    compared = {name: _compared(World(one)) for name, one in
                (("axis at rest", still), ("axis moves", moving))}  # fmt: skip
    world = World(still)
    polygon, _ = world.instruments()
    found = _closure(world)
    budget = closure_budget(found, still.counts_per_rev)
    # If a face is rotated forward by p, the table seems to stand p before its target.
    true_faces = (polygon.normal_rad.mean() - polygon.normal_rad) * ARCSEC_PER_RAD
    return {
        "cycles": still.cycles,
        "turns": still.turns,
        "radial_motion_m": moving.radial_motion_m,
        "rows": [one.record() for one in budget.contributions],
        "u_arcsec": budget.u_arcsec,
        "U_arcsec": budget.expanded_arcsec,
        "faces_off_by_arcsec": float(np.sqrt(np.mean((found.faces_arcsec - true_faces) ** 2))),
        "faces_arcsec": float(np.sqrt(np.mean(true_faces**2))),
        "compared": compared,
    }


def _closure(world: World) -> Closure:
    faces = world.instruments()[0].faces
    _, errors, face = world.stations(spread_shifts(world.settings.cycles, faces))
    return closure(errors, face)


def _compared(world: World) -> dict[str, Any]:
    """Return E_n between self-calibration and polygon at every face."""
    reading, _, _ = world.stations([0])
    by_polygon = _closure(world)
    orders = world.settings.orders
    estimate, _ = least_squares(
        [captured(world)],
        world.settings.counts_per_rev,
        SEPARATION_RAD,
        orders[orders != BLIND_ORDER],
        "measured",
    )
    own = estimate.error_arcsec(reading)
    difference = (own - own.mean()) - by_polygon.table_arcsec
    half = 0.5 * arcsec_per_count(world.settings.counts_per_rev) / math.sqrt(3.0)
    u_own = np.hypot(estimate.u_error_arcsec(reading), half)
    u_polygon = closure_budget(by_polygon, world.settings.counts_per_rev).u_arcsec
    e_n = difference / (COVERAGE * np.hypot(u_own, u_polygon))
    return {
        "U_own_arcsec": float(COVERAGE * np.sqrt(np.mean(u_own**2))),
        "U_polygon_arcsec": float(COVERAGE * u_polygon),
        "difference_rms_arcsec": float(np.sqrt(np.mean(difference**2))),
        "e_n": e_n.tolist(),
    }
