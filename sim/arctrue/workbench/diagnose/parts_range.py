"""Checks products of parts, candidate effects of the form condition × wave.

The checks are whether the rows cover enough periods of the wave, and whether the fitted size is not
larger than the measured error.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.part_conditions import ALWAYS, SHORT_ARC_RAD
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.design_matrix import measured_arcsec
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.observations import ReferenceRows

Float = NDArray[np.float64]

LEAST_WAVE = 0.75
"""Least number of periods of an order that a run must cover: an order with fewer periods is a slow
curve or a bump."""
LEAST_WAVE_OF_AN_ARC = 4.0
"""Least number of periods of an order on an arc shorter than SHORT_ARC_RAD, where the model has no
order of the disc: a wave with fewer periods is a slow curve of the angle, as in the search for
lines."""
HALF_REPEATS_TURNS = 2.0
"""Number of turns after which a half order repeats. On one turn, whole orders describe any error
(Fourier), and a half order differs from them only by a step where the turn closes. The rows must
therefore cover LEAST_WAVE of these turns to show a half order."""
MOSTLY_ITS_OWN = 0.5
"""Share of a part's variance that the model cannot reproduce (1/VIF). A part with a larger share is
accepted, because the model could not cancel most of it.
"""
CLEARLY_ITS_OWN = 0.1
"""The same share for a recorded column. Marquardt calls a VIF of 10 too large (Technometrics 12
(1970) 610). A column that repeats with the angle, such as the torque of an unbalanced payload,
resembles the model's orders: the fit then cancels a part of the column by these orders even if the
column is the cause.
"""


def resolved_orders(rows: ReferenceRows, factor: Float, orders: Float) -> NDArray[np.bool_]:
    """Tell for each of ``orders``, (n,), whether a reference run covers enough of its periods.

    Travel counts only where the condition (for example a temperature) that multiplies the wave is
    large.

    ``factor``: the condition at each row, shape (rows,). The travel is weighted with the condition,
    relative to its largest value: a condition exp(−t/τ) covers a travel of τ times the speed.
    """
    way_rad = np.abs(np.diff(rows.target_rad, prepend=rows.target_rad[:1]))
    way_rad[np.diff(rows.run, prepend=rows.run[:1]) != 0] = 0.0
    share = np.abs(factor) / max(float(np.abs(factor).max(initial=0.0)), 1e-300)
    _, number = np.unique(rows.run, return_inverse=True)
    of_run = np.bincount(number, weights=share * way_rad)
    span_rad = float(np.ptp(rows.target_rad))
    passed = min(span_rad, float(of_run.max())) / (2.0 * np.pi)
    whole = orders % 1.0 == 0.0
    repeats = span_rad / (2.0 * np.pi) >= LEAST_WAVE * HALF_REPEATS_TURNS
    least = LEAST_WAVE_OF_AN_ARC if span_rad < SHORT_ARC_RAD else LEAST_WAVE
    return np.asarray((orders * passed >= least) & (whole | repeats))


def passes_its_wave(residuals: Residuals, effect: ProductOfParts) -> bool:
    """Tell whether a reference run covers enough periods of each order of a product.

    The result is True for every product that is not fixed to the reference.
    """
    rows = residuals.observations.reference
    factor = None if rows is None else effect.condition.values(rows)
    if rows is None or factor is None or effect.frame != "reference":
        return True
    return bool(resolved_orders(rows, factor, np.array(effect.orders)).all())


def only_cancels(residuals: Residuals, effect: ProductOfParts, score: Score) -> bool:
    """Tell whether the fitted part exceeds the measured error, so that the model must cancel most
    of the part.

    Var(y) = Var(part) + Var(others) + 2 cov(part, others): without cancellation Var(part) is at
    most Var(y). The share of the part that the model cannot reproduce is 1/VIF, where VIF is the
    variance inflation factor of the part (Marquardt, Technometrics 12 (1970) 591); a part with VIF
    < 2 is accepted. If the model already contains the part's wave, the mean of the condition is
    subtracted before the sizes are compared: the model's wave absorbs the mean, and the zero of the
    condition is arbitrary.
    """
    least = MOSTLY_ITS_OWN if effect.condition.column is None else CLEARLY_ITS_OWN
    if score.own_share > least or score.rank == 0:
        return False
    context, observations = residuals.solution.context, residuals.observations
    wave = ProductOfParts.of(ALWAYS, effect.orders, effect.frame, effect.electrical_head)
    known = {
        float(order)
        for term in residuals.solution.terms
        for order in term.effect.disc_orders(term.nonlinear)
    }
    in_model = effect.electrical_head is None and known.issuperset(effect.orders)
    for rows, is_capture in ((observations.capture, True), (observations.reference, False)):
        factor = None if rows is None else effect.condition.values(rows)
        if factor is None:
            continue
        if is_capture:
            assert observations.capture is not None
            columns = wave.capture_columns(observations.capture, {}, context)
        else:
            assert observations.reference is not None
            columns = wave.reference_columns(observations.reference, {}, context)
        if columns is None:
            continue
        varies = factor - float(np.mean(factor)) if in_model else factor
        part = varies * (columns @ score.coefficients)
        if float(np.std(part)) > float(np.std(measured_arcsec(observations, capture=is_capture))):
            return True
    return False
