"""Computes the columns of axis motion in the stator frame, for all effects that contain it."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from arctrue.workbench.effects.base import Columns
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations import CaptureRows, ReferenceRows

SEPARATING_HEADS = 3
"""Smallest number of heads that separate x and y of the axis motion at an order that is not whole;
the disc has no such order. At a whole order, this number of heads shows only whether the axis
moves."""


def capture_motion(rows: CaptureRows, orders: Sequence[float]) -> Columns:
    """Return the columns of x, then the columns of y.

    Head 1 reads y, and a head at the angle α after it reads x·sin α + y·cos α
    (docs/architecture.md, "Head geometry"). The difference is x·sin α + y·(cos α − 1), all as
    displacement over the radius, in arcseconds. Three heads have two such differences, from which x
    and y follow if the disc is known. Four heads separate x and y from the disc, except a circular
    motion once per turn in the sense of rotation, which an eccentric disc causes as well.
    """
    waves = harmonic_columns(rows.angle_rad, orders)
    alpha = rows.head_separation_rad
    return np.hstack([waves * np.sin(alpha), waves * (np.cos(alpha) - 1.0)])


def motion_of_waves(alpha_rad: float, columns: int) -> Columns:
    """Return the factors of waves, (columns, 2·columns), in :func:`capture_motion` of two heads."""
    unit = np.eye(columns)
    return np.hstack([unit * np.sin(alpha_rad), unit * (np.cos(alpha_rad) - 1.0)])


def reference_motion(rows: ReferenceRows, orders: Sequence[float]) -> Columns:
    """Return the columns of x, which are 0 because head 1 does not see x, then the columns of y."""
    waves = harmonic_columns(rows.angle_rad, orders)
    return np.hstack([np.zeros_like(waves), waves])
