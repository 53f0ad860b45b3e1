"""Calculates the error on omitted rows, which are predicted from the model and their neighbours.

The rows are omitted in turn, a quarter of the rows at a time; the omitted rows are single rows, not
blocks. In the test of an effect (:func:`held_out_with`), an omitted row is predicted from the model
and from the coloured noise of its neighbours. Correlated noise therefore does not make the test too
favourable. The same noise is used for the model with the effect and without it. The figure *held
out* of a model (:func:`held_out`) uses the model alone.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import (
    Term,
    channel_prediction,
    keep_part,
    measured_arcsec,
    term_columns,
)
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.score_test import Score
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.numeric.symmetric import RANK_TOLERANCE
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

FOLDS = 4
"""Number of folds. Each fit has three quarters of the rows; :data:`.detectable.FOLDS_SHARE` follows
from this number."""
STANDARD_ERRORS = 2.0
"""Standard errors by which the log predictive density of omitted (held-out) rows must rise."""
ENOUGH_ERRORS = 3.0
"""If a true effect would raise the log predictive density by less than this number of standard
errors, the test does not require a rise."""
LEAST_KEPT = 0.01
"""Smallest share that the kept rows must have of all rows' information about a direction of an
effect. Three quarters of the rows usually have about 0.75; below 0.01, only a row at the edge of
the effect is kept."""
SEED = 20_120_215
"""Seed of the order in which rows are left out; fixed, so that a set always has the same folds."""


@dataclass(frozen=True)
class HeldOut:
    """Error with which each row is predicted by a fit without this row (held-out error), by
    channel, arcseconds."""

    capture_arcsec: Float | None
    reference_arcsec: Float | None

    @property
    def capture_rms_arcsec(self) -> float | None:
        """RMS over all rows of the capture."""
        return _rms(self.capture_arcsec)

    @property
    def reference_rms_arcsec(self) -> float | None:
        """RMS over all rows of the reference."""
        return _rms(self.reference_arcsec)


@dataclass(frozen=True)
class Improvement:
    """The fall of the held-out error of one channel, with its standard error."""

    fall_arcsec: float
    """Fall of the RMS of the held-out error."""
    standard_error_arcsec: float
    gain: float
    """Rise of the log predictive density of all rows of the channel."""
    information: float
    """Σ (change of the prediction)²/variance over the rows. For a real effect, the rise has this
    sum as its variance and half this sum as its mean."""


def holds_out(channels: Iterable[Improvement]) -> bool:
    """Tell whether the predictive density of held-out rows rises by more than two standard errors.

    If such rows cannot show the effect, because their neighbours already predict it as slow noise,
    it suffices that the density does not fall by two standard errors or more.
    """
    found = list(channels)
    gain = sum(item.gain for item in found)
    information = sum(item.information for item in found)
    error = float(np.sqrt(information))
    if 0.5 * information < ENOUGH_ERRORS * error:
        return gain > -STANDARD_ERRORS * error
    return gain > STANDARD_ERRORS * error


@dataclass(frozen=True)
class Folds:
    """For each row, the number of the fit that leaves the row out, by channel; shape (rows,)."""

    capture: Integer | None
    reference: Integer | None


def _rms(errors: Float | None) -> float | None:
    return None if errors is None or errors.size == 0 else float(np.sqrt(np.mean(errors**2)))


def improvement(before: Float | None, after: Float | None, scale: Float) -> Improvement | None:
    """Return the fall of the error between two models on the same rows; ``scale`` is the noise
    scale of each row, shape (rows,)."""
    if before is None or after is None or before.size == 0:
        return None
    old, new = before / scale, after / scale
    variance = max(float(np.mean(new**2)), 1e-30)
    change = old - new
    information = float(change @ change) / variance
    gain = 0.5 * float(old @ old - new @ new) / variance
    # The fall of the mean square contains twice the sum of (change times error); the known variance
    # of this sum gives the standard error.
    spread = 2.0 * np.sqrt(float(change @ change) * variance) / old.size
    rms_before, rms_after = float(np.sqrt(np.mean(before**2))), float(np.sqrt(np.mean(after**2)))
    unit = float(np.mean(scale**2)) / max(rms_before + rms_after, 1e-30)
    return Improvement(rms_before - rms_after, float(spread * unit), gain, information)


def falls(before: HeldOut, after: HeldOut, noise: Noise) -> dict[str, Improvement]:
    """Return the fall of the error on held-out rows, by channel."""
    found = {}
    for channel, old, new, of_rows in (
        ("capture", before.capture_arcsec, after.capture_arcsec, noise.capture),
        ("reference", before.reference_arcsec, after.reference_arcsec, noise.reference),
    ):
        if of_rows is not None and (fall := improvement(old, new, of_rows.scale)) is not None:
            found[channel] = fall
    return found


def folds_of(observations: Observations) -> Folds:
    """Assign the rows of each group of four consecutive rows to the four folds, in a random order.

    Half a period of any wave that the rows can show is longer than the distance of two rows, so the
    rows on both sides of an omitted row show this wave too. In a fixed order, the same stations of
    every cycle could be left out together.
    """
    found: list[Integer | None] = []
    for rows in (observations.capture, observations.reference):
        if rows is None:
            found.append(None)
            continue
        random = np.random.default_rng(SEED)
        rounds = -(-rows.run.size // FOLDS)
        order = random.permuted(np.tile(np.arange(FOLDS), (rounds, 1)), axis=1).ravel()
        found.append(order[: rows.run.size])
    return Folds(*found)


def without(
    observations: Observations, keep_capture: NDArray[np.bool_] | None,
    keep_reference: NDArray[np.bool_] | None,
) -> Observations:  # fmt: skip
    """Return the observations with only the rows where the masks are True."""
    capture, reference = observations.capture, observations.reference
    parts: dict[str, CaptureRows | ReferenceRows | None] = {}
    for channel, rows, kept in (
        ("capture", capture, keep_capture),
        ("reference", reference, keep_reference),
    ):
        parts[channel] = None if rows is None or kept is None else rows.part(kept)
        if rows is not None and kept is not None:
            keep_part(rows, parts[channel], kept)  # type: ignore[arg-type]
    return replace(observations, **parts, stored=None, stored_reference=None)  # type: ignore[arg-type]


def held_out(
    terms: Sequence[Term],
    observations: Observations,
    context: FitContext,
    noise: Noise | None = None,
) -> HeldOut:
    """Return the errors of the model on rows that the fit did not use, without a prediction from
    neighbours.

    ``noise`` weights the rows; it is estimated if it is not given.
    """
    if noise is None:
        noise = fit(terms, observations, context).noise
    folds = folds_of(observations)
    left = _Errors(observations, noise, by_neighbours=False)
    for keep, train, of_kept in _trainings(observations, noise, folds):
        left.judge(fit(terms, train, context, noise=of_kept), keep)
    return left.found()


def held_out_with(
    terms: Sequence[Term], further: Term, observations: Observations, context: FitContext,
    noise: Noise,
) -> tuple[HeldOut, HeldOut]:  # fmt: skip
    """Return the errors without and with the term ``further``, on the same folds and for the same
    noise.

    In each fold, the search parameters of the further term are searched again. An omitted row
    counts with the error 0 in both models if the kept rows do not determine the term there: their
    prediction has a larger variance than the row's noise.
    """
    folds = folds_of(observations)
    before, after = _Errors(observations, noise), _Errors(observations, noise)
    every = Residuals(fit(terms, observations, context, noise=noise))
    for keep, train, of_kept in _trainings(observations, noise, folds):
        residuals = Residuals(fit(terms, train, context, noise=of_kept))
        before.judge(residuals.solution, keep)
        place = further.nonlinear
        if further.effect.search:
            found = places_of(further.effect, residuals)
            if found:
                place = found[0].nonlinear
        score = residuals.score(further.effect, place)
        whole = every.score(further.effect, place).information
        score, covariance = _determined(score, whole)
        after.judge(residuals.solution_with(further.effect, place, score), keep)
        term = Term(further.effect, place)
        undetermined = _undetermined(term, covariance, every.solution, keep)
        for errors in (before, after):
            errors.omit(undetermined)
    return before.found(), after.found()


Keep = tuple[NDArray[np.bool_] | None, NDArray[np.bool_] | None]


def _trainings(
    observations: Observations, noise: Noise, folds: Folds
) -> Iterator[tuple[Keep, Observations, Noise]]:
    for fold in range(FOLDS):
        keep = (
            None if folds.capture is None else folds.capture != fold,
            None if folds.reference is None else folds.reference != fold,
        )
        yield keep, without(observations, keep[0], keep[1]), noise.part(keep[0], keep[1])


def _determined(score: Score, whole: Float) -> tuple[Score, Float]:
    """Return the score of an effect on the kept rows, limited to the directions that these rows
    determine, and a covariance of the coefficients that is very large in the other directions.

    ``whole``: information of every row about the effect. Directions that all rows together do not
    determine are left out of both, because the effect predicts nothing in them.
    """
    unit = 1.0 / np.sqrt(np.maximum(np.diag(whole), 1e-300))
    values, vectors = np.linalg.eigh(whole * np.outer(unit, unit))
    there = values > RANK_TOLERANCE * max(float(values[-1]), 1e-300)
    into = unit[:, np.newaxis] * vectors[:, there] / np.sqrt(values[there])
    shares, turned = np.linalg.eigh(into.T @ score.information @ into)
    into = into @ turned
    covariance = (into / np.maximum(shares, RANK_TOLERANCE)) @ into.T
    kept = shares > LEAST_KEPT
    if kept.all():
        return score, covariance
    inverse = (into[:, kept] / shares[kept]) @ into[:, kept].T
    coefficients = inverse @ score.moment
    gain = max(float(score.moment @ coefficients), 0.0)
    rank = int(kept.sum())
    found = replace(score, gain=gain, rank=rank, coefficients=coefficients, covariance=inverse)
    return found, covariance


def _undetermined(term: Term, covariance: Float, every: Solution, keep: Keep) -> Keep:
    """Return, by channel, the omitted rows where the kept rows do not determine the term, whose
    coefficients have this covariance."""
    found: list[NDArray[np.bool_] | None] = []
    for capture, of_rows, kept in (
        (True, every.noise.capture, keep[0]),
        (False, every.noise.reference, keep[1]),
    ):
        columns = None
        if of_rows is not None and kept is not None:
            columns = term_columns(term, every.observations, every.context, capture=capture)
        if columns is None or of_rows is None or kept is None:
            found.append(None)
            continue
        own = columns[~kept]
        undetermined = np.zeros(kept.size, dtype=np.bool_)
        spread = np.sum((own @ covariance) * own, axis=1)
        undetermined[~kept] = spread > of_rows.variance_arcsec2[~kept]
        found.append(undetermined)
    return found[0], found[1]


class _Errors:
    """Held-out errors of every row, collected fold by fold."""

    def __init__(
        self, observations: Observations, noise: Noise, *, by_neighbours: bool = True
    ) -> None:
        self._observations, self._noise = observations, noise
        self._by_neighbours = by_neighbours
        self._capture, self._reference = (
            None if rows is None else np.zeros(rows.run.size)
            for rows in (observations.capture, observations.reference)
        )

    def judge(self, solution: Solution, keep: Keep) -> None:
        """Store, for all rows that were not kept, the errors of a solution that was fitted to the
        kept rows."""
        for total, kept, of_rows, is_capture in (
            (self._capture, keep[0], self._noise.capture, True),
            (self._reference, keep[1], self._noise.reference, False),
        ):
            if total is not None and kept is not None and of_rows is not None:
                total[~kept] = _errors(
                    solution,
                    self._observations,
                    kept,
                    of_rows if self._by_neighbours else None,
                    capture=is_capture,
                )

    def omit(self, rows: Keep) -> None:
        """Set the errors of these rows to 0."""
        for total, chosen in zip((self._capture, self._reference), rows, strict=True):
            if total is not None and chosen is not None:
                total[chosen] = 0.0

    def found(self) -> HeldOut:
        """Return the errors collected from all folds."""
        return HeldOut(self._capture, self._reference)


def _errors(
    solution: Solution,
    observations: Observations,
    kept: NDArray[np.bool_],
    noise: RowNoise | None,
    *,
    capture: bool,
) -> Float:
    """Return measured minus predicted values of the rows that were left out.

    If ``noise``, the noise of all rows, is given, the neighbours predict the coloured part.
    """
    apart = _left_out(observations, kept, capture=capture)
    predicted = channel_prediction(
        solution.terms, solution.coefficients, apart, solution.context, capture=capture
    )
    if capture:
        assert apart.capture is not None
        predicted = predicted + apart.capture.offsets_of_rows(solution.run_offsets_arcsec)
        left = solution.capture_residual_arcsec()
        of_kept = solution.noise.capture
    else:
        predicted = predicted + solution.reference_offset_arcsec
        left = solution.reference_residual_arcsec()
        of_kept = solution.noise.reference
    if noise is not None and left is not None and of_kept is not None:
        precise = of_kept.precise(of_kept.whiten(left))
        predicted = predicted + noise.expected(kept, precise)
    return np.asarray(measured_arcsec(apart, capture=capture) - predicted)


def _left_out(
    observations: Observations, kept: NDArray[np.bool_], *, capture: bool
) -> Observations:
    """Return the rows of one channel that were left out."""
    rows = observations.capture if capture else observations.reference
    assert rows is not None
    apart = rows.part(~kept)
    shown = {"capture": apart} if capture else {"reference": apart}
    return replace(observations, **shown)  # type: ignore[arg-type]
