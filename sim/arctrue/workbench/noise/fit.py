"""Estimates the noise of a set, channel by channel, together with the coefficients of a model.

The restricted likelihood of a channel contains the information of the other channel about the
coefficients. Thus even 24 reference rows show their noise, if a long capture determines the
coefficients.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Protocol
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.noise.estimate import ChannelRows, estimated_law, row_noise
from arctrue.workbench.noise.law import NoiseLaw, reference_clock, stated_scale
from arctrue.workbench.noise.likelihood import FixedTerms
from arctrue.workbench.noise.noise import FittedGroup, Noise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.noise.spectrum_fit import STATED_READINGS, SpectrumFit, WhiteBounds
from arctrue.workbench.numeric.least_squares import (
    ChannelSums,
    Matrix,
    WhitenedRows,
    divided_by_constants,
)
from arctrue.workbench.numeric.symmetric import solve_symmetric
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

_FITS: WeakKeyDictionary[CaptureRows | ReferenceRows, dict[bytes, SpectrumFit]] = (
    WeakKeyDictionary()
)
"""Fits of spectra to the rows of a channel, which are kept while these rows exist."""

FIT_ROUNDS = 1
"""Number of fits before the noise is estimated. One fit with white noise suffices, because the
restricted likelihood accounts for the degrees of freedom of the coefficients."""
FIRST_ROUNDS, NEXT_ROUNDS = 30, 8
"""Largest number of steps towards the likelihood's maximum, from a rough start and from a near
start."""
LEAST_FREEDOM = 3.0
"""Degrees of freedom that a channel without a stated uncertainty needs for an estimate of its
scatter.
"""
NO_KNOWLEDGE_ARCSEC2 = 1.0
"""Variance of a channel whose noise cannot be estimated. The channel gets no weight if the noise of
the other channel can be estimated."""


class DesignColumns(Protocol):
    """Design matrix of a model on the rows of a set."""

    @property
    def observations(self) -> Observations:
        """The rows of the set."""

    @property
    def shared(self) -> int:
        """Number of coefficients that both channels share."""

    def columns(self, *, capture: bool) -> Matrix:
        """Return the columns of a channel, shape (rows, shared), arcseconds."""

    def whitened(self, noise: Noise, *, capture: bool) -> WhitenedRows | None:
        """Return the whitened columns of a channel; None if the set lacks that channel."""


class Design(DesignColumns, Protocol):
    """Design matrix with the operations that a fit of its coefficients needs."""

    def sums(self, noise: Noise, *, capture: bool) -> ChannelSums | None:
        """Return the sums of least squares over the rows of a channel; None if the set lacks that
        channel."""

    def residuals(self, noise: Noise) -> tuple[Float | None, Float | None]:
        """Return the residuals of a fit with this noise, (capture, reference), arcseconds."""


def white_noise(
    observations: Observations, deviations_arcsec: tuple[float | None, float | None]
) -> Noise:
    """Return white noise with these standard deviations, (capture, reference).

    For a deviation of None, the variance is NO_KNOWLEDGE_ARCSEC2.
    """
    laws: list[NoiseLaw | None] = []
    for rows, deviation in zip(
        (observations.capture, observations.reference), deviations_arcsec, strict=True
    ):
        if rows is None:
            laws.append(None)
            continue
        names = np.unique(rows.run)
        variance = NO_KNOWLEDGE_ARCSEC2 if deviation is None else deviation**2
        spectra = tuple(Spectrum(variance) for _ in names)
        laws.append(NoiseLaw(spectra, names, np.ones(names.size)))
    return _with_laws(observations, laws[0], laws[1])


def _with_laws(
    observations: Observations, capture: NoiseLaw | None, reference: NoiseLaw | None
) -> Noise:
    rows, stations = observations.capture, observations.reference
    return Noise(
        None if rows is None or capture is None else capture.on(rows),
        None if stations is None or reference is None else reference.on(stations),
        observations.index_sigma_arcsec**2,
        capture,
        reference,
    )


def estimated_noise(design: Design) -> tuple[Noise, frozenset[str]]:
    """Return the noise with the largest restricted likelihood, and the channels without an
    estimate."""
    noise, unknown = _white_start(design)
    for _ in range(FIT_ROUNDS):
        left = design.residuals(noise)
        noise = noise_of(design, left, noise, unknown, warm=False, rounds=FIRST_ROUNDS)
    return noise, unknown


def noise_of(
    design: DesignColumns,
    left: tuple[Float | None, Float | None],
    before: Noise,
    unknown: frozenset[str] = frozenset(),
    *,
    warm: bool = True,
    rounds: int = NEXT_ROUNDS,
    walk: bool = False,
) -> Noise:
    """Estimate the noise from the residuals ``left`` of a model, (capture, reference).

    ``before`` is the earlier noise, which weights the channels; with ``warm`` the search starts
    from it. ``walk``: see :func:`fit_spectrum`.
    """
    noise = before
    groups: list[FittedGroup] = []
    for channel, residual in zip(("capture", "reference"), left, strict=True):
        capture = channel == "capture"
        if residual is None:
            continue
        old = [group for group in before.groups if group.channel == channel]
        of_rows = noise.capture if capture else noise.reference
        if channel in unknown or (of_rows is not None and of_rows.weightless):
            groups += old
            continue
        rows = _channel_rows(design, residual, capture=capture)
        law, fits = estimated_law(
            rows,
            _fixed_terms(design, left, noise, capture=capture),
            white_bounds(design.observations, capture=capture),
            (noise.capture_law if capture else noise.reference_law) if warm else None,
            rounds,
            walk=walk,
        )
        groups += fits
        if capture:
            noise = replace(noise, capture=row_noise(rows, law), capture_law=law)
        else:
            noise = replace(noise, reference=row_noise(rows, law), reference_law=law)
    return replace(noise, groups=tuple(groups))


def white_bounds(observations: Observations, *, capture: bool) -> WhiteBounds:
    """Return the bounds of a row's white variance: the rounding of counts, and the stated
    uncertainty."""
    count = observations.count_arcsec or 0.0
    if capture:
        # A row is a difference of two heads, and each is rounded to whole counts.
        return WhiteBounds(max(2.0 * count**2 / 12.0, 1e-12))
    stated = observations.reference_uncertainty_arcsec
    return WhiteBounds(1e-12, None if not stated else float(stated) ** 2)


def _channel_rows(design: DesignColumns, residual: Float, *, capture: bool) -> ChannelRows:
    """Return the rows of a channel in the form that the estimate of the noise needs."""
    if capture:
        rows = design.observations.capture
        assert rows is not None
        return ChannelRows(
            "capture", rows.time_s, rows.run, rows.angle_rad, residual, stated_scale(rows),
            design.columns(capture=True), True, _FITS.setdefault(rows, {}),
        )  # fmt: skip
    reference = design.observations.reference
    assert reference is not None
    return ChannelRows(
        "reference", reference_clock(reference), reference.run, reference.angle_rad, residual,
        stated_scale(reference), design.columns(capture=False), False,
        _FITS.setdefault(reference, {}),
    )  # fmt: skip


def _white_start(design: Design) -> tuple[Noise, frozenset[str]]:
    """Return white noise of both channels, jointly estimated, and channels without an estimate."""
    observations = design.observations
    noise = white_noise(observations, (1.0, 1.0))
    unknown = set()
    sums = {
        channel: design.sums(noise, capture=channel == "capture")
        for channel in ("capture", "reference")
    }
    variance: dict[str, float] = {}
    for _ in range(6):
        for channel, own in sums.items():
            if own is None:
                continue
            other = sums["reference" if channel == "capture" else "capture"]
            found, freedom = _scatter(own, other, variance, channel, design.shared)
            stated = white_bounds(observations, capture=channel == "capture").stated
            if freedom < LEAST_FREEDOM and stated is None:
                unknown.add(channel)
                variance[channel] = NO_KNOWLEDGE_ARCSEC2
            else:
                weight = 0.0 if stated is None else STATED_READINGS
                square = found * freedom + weight * (stated or 0.0)
                variance[channel] = max(square / max(freedom + weight, 1.0), 1e-12)
                unknown.discard(channel)
    laws: list[NoiseLaw | None] = []
    for channel, law in (("capture", noise.capture_law), ("reference", noise.reference_law)):
        if law is None:
            laws.append(None)
            continue
        spectra = tuple(Spectrum(variance[channel]) for _ in law.spectra)
        # A channel without an estimate loses its weight only if the noise of the other channel can
        # be estimated.
        weightless = channel in unknown and len(variance) > len(unknown)
        laws.append(replace(law, spectra=spectra, weightless=weightless))
    return _with_laws(observations, laws[0], laws[1]), frozenset(unknown)


def _scatter(
    own: ChannelSums,
    other: ChannelSums | None,
    variance: dict[str, float],
    channel: str,
    shared: int,
) -> tuple[float, float]:
    """Return the variance of a channel's rows and its degrees of freedom, given the variance of the
    other channel."""
    size = own.gram.shape[0]
    known = variance.get(channel, 1.0)
    normal, moment = own.gram / known, own.moment / known
    if other is not None:
        rival = "reference" if channel == "capture" else "capture"
        weight = 1.0 / variance.get(rival, 1.0)
        eliminated, pushed = _without_constants(other.gram, other.moment, shared)
        normal[:shared, :shared] += weight * eliminated
        moment[:shared] += weight * pushed
    solution, covariance, _, _ = solve_symmetric(normal, moment)
    spent = float(np.sum(covariance * own.gram)) / known
    freedom = own.rows - min(spent, size)
    return own.residual_square(solution) / max(freedom, 1.0), float(freedom)


def _without_constants(gram: Matrix, moment: Matrix, shared: int) -> tuple[Matrix, Matrix]:
    """Return Gram matrix and moment of the terms' columns after the free constants are
    eliminated."""
    cross = divided_by_constants(gram[:shared, shared:], gram[shared:, shared:], 1e-300)
    return (
        gram[:shared, :shared] - cross @ gram[shared:, :shared],
        moment[:shared] - cross @ moment[shared:],
    )


def _fixed_terms(
    design: DesignColumns, left: tuple[Float | None, Float | None], noise: Noise, *, capture: bool
) -> FixedTerms:
    """Return the information of the other channel about the coefficients, from its present
    residuals."""
    shared = design.shared
    of_rows = noise.reference if capture else noise.capture
    residual = left[1] if capture else left[0]
    if of_rows is None or residual is None or of_rows.weightless:
        return FixedTerms(np.zeros((shared, shared)), np.zeros(shared))
    other = design.whitened(noise, capture=not capture)
    assert other is not None
    information, moment = _without_constants(
        other.gram, other.moment(of_rows.whiten(residual)), shared
    )
    return FixedTerms(information, moment)
