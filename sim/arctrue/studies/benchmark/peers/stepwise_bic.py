"""Adds effects by stepwise regression: each step adds the effect that lowers the BIC most.

The regression ends after three effects, or earlier if no effect lowers the BIC or if the effect
that lowers it most has already been added.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.studies.benchmark.peers.textbook import (
    CHUNK,
    Fit,
    Float,
    TextbookEffect,
    effects_of,
    problem,
)

MOST_STEPS = 3
THINNED, MANY_ROWS = 4, 12_000
INDEPENDENT = 0.02
"""Smallest share of a column's length that must be orthogonal to the model; a smaller share
excludes the column, for example an order that is an alias of another order at these samples."""


def stepwise_bic(folder: Path) -> dict[str, Any]:
    """Add effects one by one; return them in the order in which they were added.

    This rival states neither a class nor an unknown cause, and it assumes white noise. The BIC of
    an effect with a search includes 2·ln(number of places) in addition to the cost of its
    coefficients; a place is one order, frequency, angle or instant of the search.
    """
    given = problem(folder)
    fit = Fit(given)
    # The search uses a subset of rows that still resolves every order; the BIC is computed from all
    # rows.
    coarse = Fit(given.thinned(THINNED)) if given.theta.size > MANY_ROWS else fit
    names: list[str] = []
    for _ in range(MOST_STEPS):
        found = _best(fit, coarse)
        if found is None or found[0] in names:
            break
        name, columns, thin = found
        names.append(name)
        fit.add(columns)
        if coarse is not fit:
            coarse.add(thin)
    if not names:
        return {"verdict": "adequate", "named": None, "class": [], "further": []}
    return {"verdict": "named", "named": names[0], "class": names[:1], "further": names[1:]}


def _best(fit: Fit, coarse: Fit) -> tuple[str, Float, Float] | None:
    """Return the effect that lowers the BIC most, with its columns in both fits; None if no effect
    lowers it."""
    left, coarse_left = fit.scaled_left, coarse.scaled_left
    square, rows = float(left @ left), left.size
    best: tuple[float, str, Float, Float] | None = None
    for exact, effect in zip(effects_of(fit), effects_of(coarse), strict=True):
        place, thin = _place(coarse, effect, coarse_left)
        columns = fit.whole(exact.columns(effect.places[place : place + 1]))
        gain, rank = (values[0] for values in _gains(fit, columns, left))
        fall = rows * np.log(square / max(square - gain, 1e-12))
        fall -= rank * np.log(rows) + 2.0 * np.log(effect.places.size * exact.share)
        if fall > 0 and (best is None or fall > best[0]):
            best = (float(fall), effect.name, columns[:, 0, :], thin)
    return None if best is None else best[1:]


def _place(fit: Fit, effect: TextbookEffect, left: Float) -> tuple[int, Float]:
    """Return the place that lowers the sum of squares most, and its columns."""
    best: tuple[float, int, Float] | None = None
    for begin, columns in _chunks(fit, effect):
        gains, _ = _gains(fit, columns, left)
        at = int(gains.argmax())
        if best is None or gains[at] > best[0]:
            best = (float(gains[at]), begin + at, columns[:, at, :])
    assert best is not None
    return best[1:]


def _chunks(fit: Fit, effect: TextbookEffect) -> Iterator[tuple[int, Float]]:
    """Yield the columns of up to CHUNK places at a time, with the number of the first place."""
    for begin in range(0, effect.places.size, CHUNK):
        yield begin, fit.whole(effect.columns(effect.places[begin : begin + CHUNK]))


def _gains(fit: Fit, columns: Float, left: Float) -> tuple[Float, Float]:
    """Return the decrease of the sum of squares and the number of coefficients for each place."""
    rows, places, width = columns.shape
    flat = columns.reshape(rows, places * width)
    # The residual is already orthogonal to the model, so only the columns are projected.
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
