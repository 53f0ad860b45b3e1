"""Estimates the noise of a channel: first spectra, then scales of runs and of parts of the turn."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtrc, fdtrc

from arctrue.workbench.noise.law import ANGLE_BINS, NoiseLaw, angle_bins, like_steps
from arctrue.workbench.noise.likelihood import FixedTerms, Stretch
from arctrue.workbench.noise.noise import FittedGroup
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.noise.spectrum_fit import SpectrumFit, WhiteBounds, fit_spectrum

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

UNEVEN_P = 1e-4
"""Largest p at which noise counts as uneven; p is the probability that noise with equal scatter in
all groups of rows shows such differences."""
LEAST_ROWS_A_BIN = 40
"""Smallest number of rows in a bin; with this number, the scatter of the bin has an uncertainty of
11 %, 1/√(2·40)."""
LEAST_ROWS_A_CELL = 5
"""Smallest number of rows of a pass in a part of the turn; with fewer rows, their scatter is not
compared with that of other passes. The logarithm of a mean of five squares is nearly normal
(Bartlett and Kendall, J. R. Stat. Soc. Suppl. 8 (1946) 128)."""
ROBUST_LIMIT = 4.0
"""Limit of whitened residuals: larger residuals are clipped to this limit before their scatter is
estimated."""


@dataclass(frozen=True)
class ChannelRows:
    """Rows from which the noise of a channel is estimated; arrays of shape (rows,) or (rows, k)."""

    channel: str
    clock: Float
    run: Integer
    angle_rad: Float
    residual: Float
    stated_scale: Float
    columns: Float
    """Columns of the model on these rows."""
    own_constants: bool
    """True: each run has its own offset. False: all runs have one constant."""
    kept: dict[bytes, SpectrumFit] | None = None
    """Earlier fits of spectra to these rows (:func:`fit_spectrum`)."""


def estimated_law(
    rows: ChannelRows,
    fixed_terms: FixedTerms,
    white: WhiteBounds,
    before: NoiseLaw | None = None,
    rounds: int = 40,
    *,
    walk: bool = False,
) -> tuple[NoiseLaw, list[FittedGroup]]:
    """Estimate the law of a channel; the search starts from ``before``, the law with another model.

    Without ``before``, spectra and scales (of runs and of parts of the turn) are estimated. If
    ``before`` has scales, they are estimated anew, because an effect that the model lacked can
    cause such scatter; if it has none, no scales are estimated. The search starts from spectra with
    the scatter of ``before``; the maximum is near, so that few steps suffice. ``walk``: see
    :func:`fit_spectrum`.
    """
    names = np.unique(rows.run)
    law = before or NoiseLaw(tuple(Spectrum(1.0) for _ in names), names, np.ones(names.size))
    warm = before is not None
    if warm and _is_uneven(law):
        law = _even(rows, law)
    elif warm:
        return _with_spectra(rows, law, fixed_terms, white, warm, rounds, walk)
    law, groups = _with_spectra(rows, law, fixed_terms, white, warm, rounds, walk)
    uneven = _uneven(rows, law)
    if uneven is None:
        return law, groups
    return _with_spectra(rows, uneven, fixed_terms, white, True, rounds, walk)


def _is_uneven(law: NoiseLaw) -> bool:
    return law.angle_scale is not None or bool(np.any(law.run_scale != 1.0))


def _even(rows: ChannelRows, law: NoiseLaw) -> NoiseLaw:
    """Return the law without scales; runs that share a spectrum get the mean variance of their
    rows."""
    noise = row_noise(rows, law)
    squares = (noise.scale / rows.stated_scale) ** 2
    spectra = list(law.spectra)
    for members in like_steps(rows.clock, rows.run):
        mean = float(np.mean(squares[np.isin(rows.run, members)]))
        for name in members:
            index = int(np.searchsorted(law.runs, name))
            spectra[index] = spectra[index].times(mean)
    return NoiseLaw(tuple(spectra), law.runs, np.ones(law.runs.size))


def row_noise(rows: ChannelRows, law: NoiseLaw) -> RowNoise:
    """Return the noise of these rows under the law."""
    return law.of(
        rows.clock, rows.run, rows.angle_rad, rows.stated_scale, goes_on=not rows.own_constants
    )


def _with_spectra(
    rows: ChannelRows,
    law: NoiseLaw,
    fixed_terms: FixedTerms,
    white: WhiteBounds,
    warm: bool,
    rounds: int,
    walk: bool,
) -> tuple[NoiseLaw, list[FittedGroup]]:
    noise = row_noise(rows, law)
    residual = rows.residual / noise.scale
    columns = rows.columns
    ones = 1.0 / noise.scale
    if np.any(noise.scale != 1.0):
        columns = columns * ones[:, np.newaxis]
    spectra = list(law.spectra)
    groups = []
    for members in like_steps(rows.clock, rows.run):
        stretches = [
            Stretch(
                rows.clock[part],
                residual[part],
                columns[part],
                int(rows.run[part.start]) if rows.own_constants else 0,
                ones[part],
            )
            for part in noise.stretches
            if int(rows.run[part.start]) in members and part.stop - part.start > 1
        ]
        if not stretches:
            continue
        index = int(np.searchsorted(law.runs, members[0]))
        start = spectra[index] if warm else None
        fit = fit_spectrum(
            stretches, fixed_terms, white, start=start, rounds=rounds, walk=walk, kept=rows.kept
        )
        fit = _rescaled(fit, stretches, white)
        for name in members:
            spectra[int(np.searchsorted(law.runs, name))] = fit.spectrum
        size = sum(stretch.clock.size for stretch in stretches)
        groups.append(FittedGroup(rows.channel, tuple(members), fit, size))
    found = NoiseLaw(tuple(spectra), law.runs, law.run_scale, law.angle_scale)
    return found, groups


def _rescaled(fit: SpectrumFit, stretches: Sequence[Stretch], white: WhiteBounds) -> SpectrumFit:
    """Multiply a spectrum that was fitted to some rows by a factor that gives it the scatter of all
    rows."""
    rows = sum(stretch.clock.size for stretch in stretches)
    freedom = rows - stretches[0].columns.shape[1]
    if freedom < 0.9 * rows or not rows:
        return fit
    clock = np.concatenate([stretch.clock for stretch in stretches])
    sizes = np.cumsum([0, *(stretch.clock.size for stretch in stretches)])[:-1]
    spectra = (fit.spectrum,) * len(stretches)
    noise = RowNoise(clock, sizes, spectra, np.ones(rows))
    whitened = noise.whiten(np.concatenate([stretch.residual for stretch in stretches]))
    factor = float(whitened @ whitened) / freedom
    spectrum = fit.spectrum
    scaled = Spectrum(
        max(spectrum.white * factor, white.floor), spectrum.constants, spectrum.variances * factor
    )

    def covariance() -> Float:
        found = fit.covariance.copy()
        # All rows determine the common factor: its variance is 2/freedom.
        limit = 2.0 / freedom / max(found[0, 0], 1e-30)
        shrink = np.sqrt(min(limit, 1.0))
        found[0, :] *= shrink
        found[:, 0] *= shrink
        return found

    return SpectrumFit(scaled, covariance)


def _uneven(rows: ChannelRows, law: NoiseLaw) -> NoiseLaw | None:
    """Add a scale for each run and each part of the turn to the law, if these differ significantly;
    return None if neither the runs nor the parts differ.
    """
    noise = row_noise(rows, law)
    whitened = np.clip(noise.whiten(rows.residual), -ROBUST_LIMIT, ROBUST_LIMIT)
    run = np.searchsorted(law.runs, rows.run)
    run_scale = _scales(whitened, run, law.runs.size)
    if run_scale is not None:
        whitened = whitened / run_scale[run]
    bins = angle_bins(rows.angle_rad)
    angle_scale = _scales(whitened, bins, ANGLE_BINS)
    # Gusts act on the reference only, because both heads of a capture are on the same table. In a
    # capture, a slip makes one part of the turn loud in one pass, and this scale helps to find the
    # slip.
    of_gusts = rows.channel == "reference"
    if of_gusts and angle_scale is not None and not _repeats(whitened, bins, _passes(rows)):
        angle_scale = None
    if run_scale is None and angle_scale is None:
        return None
    return NoiseLaw(
        law.spectra,
        law.runs,
        law.run_scale if run_scale is None else law.run_scale * run_scale,
        angle_scale,
    )


def _scales(whitened: Float, group: Integer, groups: int) -> Float | None:
    """Return the standard deviation of each group divided by the typical standard deviation; None
    if the groups do not differ significantly."""
    counts = np.bincount(group, minlength=groups).astype(np.float64)
    full = counts >= LEAST_ROWS_A_BIN
    if full.sum() < 2:
        return None
    squares = np.bincount(group, weights=whitened**2, minlength=groups)
    mean = np.where(full, squares / np.maximum(counts, 1.0), 1.0)
    total = float(squares[full].sum() / counts[full].sum())
    ratio = float(
        np.sum(counts[full] * (np.log(max(total, 1e-30)) - np.log(np.maximum(mean[full], 1e-30))))
    )
    # The logarithm of the likelihood ratio is 0 for groups of equal scatter; rounding may make it
    # negative.
    if chdtrc(int(full.sum()) - 1, max(ratio, 0.0)) > UNEVEN_P:
        return None
    typical = float(np.exp(np.average(np.log(mean[full]), weights=counts[full])))
    return np.asarray(np.where(full, np.sqrt(mean / typical), 1.0))


def _passes(rows: ChannelRows) -> Integer:
    """Return the number of the pass over the turn of each row."""
    turn = np.floor(rows.angle_rad / (2.0 * np.pi))
    return np.unique(np.stack([rows.run, turn]), axis=1, return_inverse=True)[1].astype(np.int64)


def _repeats(whitened: Float, part: Integer, passes: Integer) -> bool:
    """Tell whether the scatter of the parts of the turn is the same in different passes.

    If the level changes with time, as in gusts, some parts are louder in one pass only. A scale of
    these parts would cut slow noise into pieces with jumps between them, and a drift would seem to
    explain the jumps. An F test compares the scatter of the logarithms of the mean squares between
    the parts with their scatter between the passes. With a single pass this test is not possible:
    the result is True.
    """
    cell = part * (int(passes.max(initial=0)) + 1) + passes
    names, cell = np.unique(cell, return_inverse=True)
    rows = np.bincount(cell).astype(np.float64)
    squares = np.bincount(cell, weights=whitened**2)
    there = (rows >= LEAST_ROWS_A_CELL) & (squares > 0.0)
    rows, level = rows[there], np.log(squares[there] / rows[there])
    _, part = np.unique(names[there] // (int(passes.max(initial=0)) + 1), return_inverse=True)
    parts = int(part.max(initial=0)) + 1
    free = rows.size - parts
    if parts < 2 or free < parts:
        return True
    weight = np.bincount(part, weights=rows)
    mean = np.bincount(part, weights=rows * level) / weight
    between = float(np.sum(weight * (mean - np.average(mean, weights=weight)) ** 2)) / (parts - 1)
    within = float(np.sum(rows * (level - mean[part]) ** 2)) / free
    return bool(fdtrc(parts - 1, free, between / max(within, 1e-300)) < UNEVEN_P)


__all__ = ["ChannelRows", "estimated_law", "row_noise"]
