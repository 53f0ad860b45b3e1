"""Calibrates by closure: the polygon is re-indexed between cycles, which separates its faces'
errors from the table's error.

In cycle i, at station j, the error measured with the polygon is ε_j + p_(j − s_i) + c_i. s_i is the
shift of the polygon, p the error of a face, and c_i the zero of the cycle. ε and p have mean 0,
because the circle closes. Least squares solves for ε and p if the shifts connect all faces.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.studies.methods.method import Method, fitted_harmonics, of_harmonics
from arctrue.studies.methods.world import Output, World

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class Closure:
    """Errors of the table and of the faces, arcseconds, ``(faces,)``, each with mean 0."""

    table_arcsec: Float
    faces_arcsec: Float
    u_table_arcsec: Float
    """Standard uncertainty of the table's errors from the scatter of the fit, ``(faces,)``."""
    scatter_arcsec: float
    degrees_of_freedom: int


def closure(errors_arcsec: Float, face: Integer) -> Closure:
    """Separate the errors of table and polygon.

    ``errors_arcsec`` and ``face`` have the shape ``(cycles, faces)``. Raises ValueError if the
    shifts do not connect all faces; a single position of the polygon is the simplest such case.
    """
    cycles, faces = errors_arcsec.shape
    rows = np.arange(errors_arcsec.size)
    station = np.tile(np.arange(faces), cycles)
    cycle = np.repeat(np.arange(cycles), faces)
    design = np.zeros((rows.size + 2, 2 * faces + cycles))
    design[rows, station] = 1.0
    design[rows, faces + face.ravel()] = 1.0
    design[rows, 2 * faces + cycle] = 1.0
    design[-2, :faces] = 1.0
    design[-1, faces : 2 * faces] = 1.0
    if np.linalg.matrix_rank(design) < design.shape[1]:
        raise ValueError(
            "the positions of the polygon do not separate its faces from the table; turn it on the "
            "table by a number of faces without a common divisor with the number of all faces"
        )
    observed = np.concatenate([errors_arcsec.ravel(), [0.0, 0.0]])
    # The last two rows state the exact closure, so their residuals do not count for the scatter.
    through = np.linalg.pinv(design)
    found = through @ observed
    left = errors_arcsec.ravel() - design[:-2] @ found
    freedom = rows.size + 2 - design.shape[1]
    scatter = float(np.sqrt(left @ left / freedom)) if freedom > 0 else float("nan")
    return Closure(
        found[:faces],
        found[faces : 2 * faces],
        scatter * np.linalg.norm(through[:faces, :-2], axis=1),
        scatter,
        freedom,
    )


def spread_shifts(cycles: int, faces: int) -> list[int]:
    """Return the position of the polygon in each cycle; the positions are spread over the whole
    turn."""
    return [(cycle * faces) // cycles for cycle in range(cycles)]


def _run(world: World) -> Output:
    cycles = world.settings.cycles
    faces = world.instruments()[0].faces
    reading, errors, face = world.stations(spread_shifts(cycles, faces))
    orders = np.arange(1, (faces + 1) // 2)
    table = closure(errors, face).table_arcsec
    return of_harmonics(orders, fitted_harmonics(orders, reading, table))


POLYGON_CLOSURE = Method(
    "polygon_closure",
    "Closure by re-indexing the polygon",
    "cg-23 (EURAMET)",
    1,
    "polygon of 24 faces without certificate, turned to a new position on the table in every "
    "cycle; autocollimator",
    "orders from 12 on, which the fit takes for lower orders; the autocollimator's own error",
    _run,
)
