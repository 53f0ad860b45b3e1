"""Finds the face of the polygon at which each reference row was read."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

FACE_TOLERANCE_DEG = 0.05
"""A station counts as being at a face if its distance from the face is at most this angle."""
LEAST_STATIONS = 3
"""Smallest number of rows of shorter runs that show how the polygon is turned: a single row is at a
face for some angle of the polygon."""


def faces_of(faces: int | None, run: Integer, target_deg: Float) -> Integer | None:
    """Return the face of each row, (rows,); the polygon may have another angle on the table in each
    run.

    If some rows of a run are between the faces, each row of this run gets the nearest face. The
    angle of the polygon on the table is then that of the first run whose rows are all at faces. The
    result is None if there is no such run, because the angle of the polygon is then unknown.
    """
    if faces is None or target_deg.size == 0:
        return None
    place = target_deg * (faces / 360.0)
    first = None
    between = []
    for rows in _mountings(faces, run):
        shift, keeps = _shift_to_faces(place[rows], faces)
        few = np.count_nonzero(rows) < min(LEAST_STATIONS, run.size)
        if few or not keeps:
            between.append(rows)
            continue
        first = shift if first is None else first
        place[rows] -= shift
    if first is None:
        return None
    for rows in between:
        place[rows] -= first
    return np.asarray(np.round(place).astype(np.int64) % faces)


def keep_to_faces(faces: int, run: Integer, target_deg: Float) -> bool:
    """Tell whether all rows are at faces; ``run`` and ``target_deg``: shapes (rows,)."""
    place = target_deg * (faces / 360.0)
    return all(_shift_to_faces(place[rows], faces)[1] for rows in _mountings(faces, run))


def _mountings(faces: int, run: Integer) -> list[NDArray[np.bool_]]:
    """Return the rows of each run that has at least as many rows as the polygon has faces, and
    after them all rows of the shorter runs together.

    A shorter run alone has too few rows to show how the polygon is turned.
    """
    names, sizes = np.unique(run, return_counts=True)
    complete = names[sizes >= faces]
    short = ~np.isin(run, complete)
    return [*(run == name for name in complete), *([short] if short.any() else [])]


def _shift_to_faces(place: Float, faces: int) -> tuple[float, bool]:
    """Return the shift, in faces, that brings the stations to the faces, and whether it does so.

    The shift is a circular mean, because stations in the middle between two faces lie half a face
    above one face and half a face below the next.
    """
    shift = float(np.angle(np.mean(np.exp(2j * np.pi * place)))) / (2.0 * np.pi)
    away = np.abs(place - shift - np.round(place - shift))
    return shift, bool(np.max(away) * 360.0 / faces <= FACE_TOLERANCE_DEG)
