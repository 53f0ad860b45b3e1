"""Stepwise regression: the effect that lowers the BIC most is added until none does."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from arctrue.studies.benchmark.peers.textbook import (
    CHUNK,
    Candidate,
    Fit,
    Float,
    candidates,
    problem,
)

MOST_STEPS = 3
INDEPENDENT = 0.02
"""Of its length: the least part of a column that the model may leave over, so that an order that
the samples fold onto another one is not taken for it."""


def stepwise_bic(folder: Path) -> dict[str, Any]:
    """Answer by the order in which the effects are added; it knows no class and no stranger.

    Noise is taken for white. A search pays with 2·ln(places) beside its coefficients.
    """
    fit = Fit(problem(folder))
    names: list[str] = []
    for _ in range(MOST_STEPS):
        found = _best(fit)
        if found is None or found[0] in names:
            break
        names.append(found[0])
        fit.add(found[1])
    if not names:
        return {"verdict": "adequate", "named": None, "class": [], "beside": []}
    return {"verdict": "named", "named": names[0], "class": names[:1], "beside": names[1:]}


def _best(fit: Fit) -> tuple[str, Float] | None:
    """The effect and its columns whose BIC falls most; None where none falls."""
    left = fit.scaled_left
    square, rows = float(left @ left), left.size
    best: tuple[float, str, Float] | None = None
    for candidate in candidates(fit):
        places = candidate.places.size * candidate.share
        for columns in _chunks(fit, candidate):
            gain, rank = _gains(fit, columns, left)
            at = int(gain.argmax())
            fall = rows * np.log(square / max(square - gain[at], 1e-12))
            fall -= rank[at] * np.log(rows) + 2.0 * np.log(places)
            if fall > 0 and (best is None or fall > best[0]):
                best = (float(fall), candidate.name, columns[:, at, :])
    return None if best is None else best[1:]


def _chunks(fit: Fit, candidate: Candidate) -> list[Float]:
    places = candidate.places
    return [
        fit.whole(candidate.columns(places[begin : begin + CHUNK]))
        for begin in range(0, places.size, CHUNK)
    ]


def _gains(fit: Fit, columns: Float, left: Float) -> tuple[Float, Float]:
    """By how much each place lowers the sum of squares, and with how many coefficients."""
    rows, places, width = columns.shape
    flat = columns.reshape(rows, places * width)
    # What is left is orthogonal to the model, so only the columns' own part need be taken off.
    inside = (fit.basis.T @ flat).reshape(-1, places, width)
    moment = (flat.T @ left).reshape(places, width)
    by_place = np.ascontiguousarray(columns.transpose(1, 2, 0))
    whole = by_place @ by_place.transpose(0, 2, 1)
    normal = whole - np.einsum("kpi,kpj->pij", inside, inside)
    gains, ranks = np.zeros(places), np.zeros(places)
    for at in range(places):
        length = np.sqrt(np.maximum(np.diag(whole[at]), 1e-300))
        sizes, directions = np.linalg.eigh(normal[at] / np.outer(length, length))
        kept = sizes > INDEPENDENT**2
        along = directions[:, kept].T @ (moment[at] / length)
        gains[at], ranks[at] = float(np.sum(along**2 / sizes[kept])), int(kept.sum())
    return gains, ranks
