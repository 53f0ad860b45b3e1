"""Converts the disc's error and the heads' places to the words of the gateware's weighted mean.

The mean Σwᵢrᵢ has the error E = Σwᵢ·ε under head i. The calibration fits g(R) = ε(θ) as a function
of the reading. Let y_i be the disc reading under head i, y_i = θ + p_i + g_i(y_i). The readings rᵢ
= y_i − p_i then give E = Σwᵢ·g_i(y_i). This module calculates E at even steps of the reading r_s of
head s, whose reading the lanes use (the carrier): θ = r_s − g_s(r_s + p_s) without approximation.
The lanes are the circuits that each add one harmonic to the correction.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.harmonics import error_arcsec
from arctrue.calibration.head_weights import (
    WeightsRefusedError,
    mean_weights,
    weight_words,
    weights_without_each,
)
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE, MeanSet
from arctrue.gateware.weighted_mean import TERM_LSB_COUNTS, weighted_mean, whole_readings
from arctrue.generated.number_formats import LANES_DEFAULT

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

ROUNDS = 6
"""Number of iterations. Each iteration multiplies the error of y_i by |dε/dR|; with |dε/dR| below
10⁻³, the error after six iterations is below the resolution of float64."""


@dataclass(frozen=True)
class HeadsOnDisc:
    """A disc and the heads that read it, as calibrated.

    ``orders`` (N,), ``values`` (2N,) in arcseconds, cosines before sines: g(R) of the disc reading;
    ``places_rad`` (H,): angles from head 1 to each head; ``offsets_rad`` (H,): mean of R_i − R_1
    over a turn, which is p_i minus the angle by which head i detects the index mark late;
    ``radius_ratios`` (H,): the disc's nominal radius divided by the radius of each head; order 1 is
    multiplied by this ratio.
    """

    orders: Integer
    values: Float
    places_rad: Float
    offsets_rad: Float
    radius_ratios: Float

    @property
    def heads(self) -> int:
        """Number of heads."""
        return int(self.places_rad.size)

    def under_head(self, head: int, disc_reading_rad: Float) -> Float:
        """Return g under head 0, 1, … in arcseconds at disc readings of any shape."""
        own = self.values.copy()
        first = np.flatnonzero(self.orders == 1)
        own[np.concatenate((first, first + self.orders.size))] *= self.radius_ratios[head]
        return error_arcsec(self.orders, own, disc_reading_rad)


def mean_error_arcsec(disc: HeadsOnDisc, weights: Float, carrier: int, carrier_rad: Float) -> Float:
    """Return the error E of the mean at readings r_s of the head ``carrier`` (0, 1, …), arcseconds,
    in the shape of ``carrier_rad``."""
    place = disc.places_rad[carrier]
    angle = carrier_rad - disc.under_head(carrier, carrier_rad + place) * RAD_PER_ARCSEC
    total = np.zeros_like(angle)
    for head in np.flatnonzero(weights):
        nominal = angle + disc.places_rad[head]
        under = np.zeros_like(angle)
        for _ in range(ROUNDS):
            under = disc.under_head(int(head), nominal + under * RAD_PER_ARCSEC)
        total += weights[head] * under
    return total


def mean_lanes(
    disc: HeadsOnDisc,
    weights: Float,
    carrier: int,
    counts_per_rev: int,
    lanes: int = LANES_DEFAULT,
) -> Coefficients:
    """Return the ``lanes`` orders with the largest amplitudes of E as a function of r_s; an order
    with amplitude 0 is left out."""
    most = int(disc.orders.max(initial=1))
    number = 1 << max(10, int(np.ceil(np.log2(8 * most))))
    reading: Float = np.arange(number) * np.float64(2.0 * np.pi / number)
    lines = np.fft.rfft(mean_error_arcsec(disc, weights, carrier, reading)) * (2.0 / number)
    unit = arcsec_per_count(counts_per_rev)
    sizes = np.abs(lines[: most + 1])
    sizes[0] = 0.0
    largest = np.sort(np.argsort(-sizes, kind="stable")[:lanes])
    # An order whose amplitude is 0 gets no lane.
    kept = largest[sizes[largest] > 0.0]
    return Coefficients.from_harmonics(
        kept,
        sizes[kept] / unit,
        np.angle(lines[kept]),
        counts_per_rev,
        lanes,
        offset_counts=float(lines[0].real / 2.0 / unit),
    )


def offset_words(offsets_rad: Float, counts_per_rev: int) -> tuple[int, ...]:
    """Return offsets as u24.4 counts within a turn, one per head."""
    turn = counts_per_rev * OFFSET_ONE
    words = np.rint(np.remainder(offsets_rad / (2.0 * np.pi), 1.0) * turn).astype(np.int64)
    return tuple((words % turn).tolist())


def mean_bank(
    disc: HeadsOnDisc,
    counts_per_rev: int,
    *,
    lanes: int = LANES_DEFAULT,
    weights: Float | None = None,
    missing: int = 0,
) -> Coefficients:
    """Return the words of the mean of all heads, or of the mean without the head ``missing`` (1, 2,
    …).

    ``weights`` (H,): None means the weights with the least noise. The carrier is the first head
    that is not missing. Raises WeightsRefusedError if no weights exist.
    """
    if weights is None:
        if not missing:
            weights = mean_weights(disc.places_rad, disc.radius_ratios)
        else:
            found = weights_without_each(disc.places_rad, disc.radius_ratios)[missing - 1]
            if isinstance(found, WeightsRefusedError):
                raise found
            weights = found
    carrier = 2 if missing == 1 else 1
    words = weight_words(weights, disc.places_rad, disc.radius_ratios)
    mean = MeanSet(
        tuple(words.tolist()), offset_words(disc.offsets_rad, counts_per_rev), carrier, missing
    )
    exact = words / float(WEIGHT_ONE)
    return replace(
        mean_lanes(disc, exact, carrier - 1, counts_per_rev, lanes),
        extension=Extension(mean=mean),
    )


def mean_banks(
    disc: HeadsOnDisc,
    counts_per_rev: int,
    *,
    lanes: int = LANES_DEFAULT,
) -> tuple[Coefficients, tuple[WeightsRefusedError, ...]]:
    """Return the words of the mean of all heads, with a set of words for each head that may be
    missing, and the reason for each head without such a set.

    Raises WeightsRefusedError if all heads together have no mean.
    """
    every = mean_weights(disc.places_rad, disc.radius_ratios)
    without, refused = [], []
    cases = weights_without_each(disc.places_rad, disc.radius_ratios)
    for missing, weights in enumerate(cases, start=1):
        if isinstance(weights, WeightsRefusedError):
            refused.append(weights)
            continue
        without.append(
            mean_bank(
                disc,
                counts_per_rev,
                lanes=lanes,
                weights=weights,
                missing=missing,
            )
        )
    all_heads = mean_bank(disc, counts_per_rev, lanes=lanes, weights=every)
    assert all_heads.extension is not None
    extension = replace(all_heads.extension, without=tuple(without))
    return replace(all_heads, extension=extension), tuple(refused)


def mean_angle_counts(coefficients: Coefficients, head_counts: NDArray[np.int64]) -> Float:
    """Return the gateware's output before rounding, counts (n,), for whole counts (heads, n).

    The weighted sum of the readings is bit-true; the lanes' words are evaluated in double
    precision. Raises ValueError for coefficients without a mean.
    """
    mean = None if coefficients.extension is None else coefficients.extension.mean
    if mean is None:
        raise ValueError("the coefficients hold no mean of the heads")
    turn = coefficients.counts_per_rev
    whole = whole_readings(np.asarray(head_counts).T, mean, turn)
    carrier = whole[:, mean.carrier - 1]
    term = weighted_mean(whole, mean, turn).term * TERM_LSB_COUNTS
    return np.asarray(carrier - term - coefficients.error_counts(carrier))
