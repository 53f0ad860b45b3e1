"""Scans for whole orders and bumps of the disc, over the angle of the disc in bins."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.channels import (
    best_factor,
    channel_rows,
    power_of_channels,
    shifts_of_channels,
)
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.maximum import moved_to_maximum
from arctrue.workbench.inference.scan.places import BEST_PLACES, Place, peaks, scored

Float = NDArray[np.float64]

DISC_BINS = 1 << 15
"""Number of bins in a turn. With eight bins per period, the highest order that is searched is
4,096, a quarter of the lines of the paper's disc."""
BLIND_FACTOR = 0.02
"""If |e^{jnα} − 1| is below this value, two heads cannot show order n."""
ALIAS_AHEAD = 6.0
"""Gain by which an order above half the samples per turn must exceed the best lower order: odds of
20 to 1, "strong" on the scale of Kass and Raftery, J. Am. Stat. Assoc. 90 (1995) 773."""


def disc_spectra(residuals: Residuals, bins: int) -> list[NDArray[np.complex128]]:
    """Return Σ (C⁻¹r)·e^{−jnθ} over the capture rows of each channel, n = 0 … bins/2."""
    capture, precise = residuals.observations.capture, residuals.capture_precise
    assert capture is not None
    assert precise is not None
    place = np.floor(capture.line1_rad * (bins / (2.0 * np.pi))).astype(np.int64) % bins
    return [
        np.asarray(np.fft.rfft(np.bincount(place[rows], weights=precise[rows], minlength=bins)))
        for rows in channel_rows(capture)
    ]


def order_information(residuals: Residuals, orders: Float) -> Float:
    """Return the information of the capture rows about e^{jνθ}: the sum over the rows of
    1/(spectral density of the noise at ν·ω)."""
    noise, rows = residuals.solution.noise.capture, residuals.observations.capture
    assert noise is not None
    assert rows is not None
    total = np.full(orders.size, 1e-30)
    for part, spectrum in zip(noise.stretches, noise.spectra, strict=True):
        count = part.stop - part.start
        step = noise.step(part)
        way = np.abs(np.diff(rows.angle_rad[part]))
        turns_a_step = float(np.median(way)) / (2.0 * np.pi) if count > 1 else 0.0
        density = spectrum.density(orders * (turns_a_step / max(step, 1e-300)), step)
        total += count / (density * noise.mean_square_scale(part))
    return np.asarray(total)


def samples_a_turn(residuals: Residuals) -> float:
    """Return the number of capture samples in a turn, calculated from the median step."""
    capture = residuals.observations.capture
    assert capture is not None
    steps = np.abs(np.diff(capture.angle_rad))
    inside = np.diff(capture.run) == 0
    if not inside.any():
        return 0.0
    return float(2.0 * np.pi / max(float(np.median(steps[inside])), 1e-12))


def disc_order_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search whole orders of the disc in the declared range; return the best places, best first.

    Orders whose alias is below the range are omitted.

    With N samples per turn, orders n and N − n differ only by a phase in each run. Runs that start
    at different angles separate the two; for a single run, the lower order is preferred.
    """
    low, high = effect.search_range("order")
    above = int(low) - 1
    capture = residuals.observations.capture
    if capture is None:
        return []
    a_turn = samples_a_turn(residuals)
    highest = int(min(a_turn - low if a_turn > 2.0 * low else 0.0, DISC_BINS / 8.0, high))
    if highest <= above:
        return []
    orders = np.arange(highest + 1)
    power = power_of_channels(disc_spectra(residuals, DISC_BINS))[: highest + 1]
    power /= order_information(residuals, orders.astype(np.float64))
    blind = best_factor(capture, orders) < BLIND_FACTOR
    power[blind | (orders <= above)] = 0.0
    best = np.argsort(power)[::-1][:BEST_PLACES]
    aliases = np.abs(np.round(a_turn) - best)
    tried = np.unique(np.concatenate([best, aliases[aliases <= highest].astype(np.int64)]))
    found = scored(
        effect, residuals, ({"order": float(order)} for order in tried), float(highest - above)
    )
    if not found or found[0].nonlinear["order"] <= a_turn / 2.0:
        return found
    below = next((item for item in found if item.nonlinear["order"] <= a_turn / 2.0), None)
    if below is None or found[0].gain - below.gain > ALIAS_AHEAD:
        return found
    return [below, *(item for item in found if item is not below)]


BUMP_WIDTHS_DEG = 0.05 * 1.5 ** np.arange(14)
"""Widths σ of the bells that a scan tries, 0.05° to 9.7°; a ratio of 1.5 between neighbouring
widths suffices, because the best width is then moved to its maximum."""


def bump_scan(effect: Effect, residuals: Residuals) -> list[Place]:
    """Search place and width of a bell on the disc, by matched filters over the binned angle."""
    capture = residuals.observations.capture
    if capture is None or residuals.capture_precise is None:
        return []
    bins = 1 << 14
    spectra = disc_spectra(residuals, bins)
    spacing_deg = 360.0 / max(samples_a_turn(residuals), 1.0)
    orders = np.arange(spectra[0].size)
    known_information = order_information(residuals, orders.astype(np.float64))
    found: list[tuple[float, dict[str, float]]] = []
    trials = 0.0
    shifts = shifts_of_channels(capture, orders)
    for width in BUMP_WIDTHS_DEG:
        if width < 0.5 * spacing_deg:
            continue
        sigma = np.radians(width)
        bell = np.exp(-0.5 * (orders * sigma) ** 2)
        # Template g(θ + α − ψ₀) − g(θ − ψ₀): its transform is bell·(e^{jnα} − 1)·e^{−jnψ₀}.
        correlation, norm = np.zeros(bins), 0.0
        for spectrum, shift in zip(spectra, shifts, strict=True):
            template = bell * shift
            correlation += np.fft.irfft(spectrum * np.conj(template), bins)
            norm += np.fft.irfft(np.abs(template) ** 2 * known_information / bins, bins)[0] / len(
                spectra
            )
        # The base model's graduation absorbs the low orders, but ``norm`` contains them, so that
        # the power of wide bells is too small here; the exact score below is right.
        power = correlation**2 / max(norm, 1e-30)
        for index in peaks(power, 2):
            found.append(
                (float(power[index]), {"place": 360.0 * index / bins, "width": float(width)})
            )
        trials += 360.0 / width
    found.sort(key=lambda item: -item[0])
    candidates = scored(effect, residuals, (item for _, item in found[:BEST_PLACES]), trials)
    if candidates:
        width = candidates[0].nonlinear["width"]
        candidates = moved_to_maximum(effect, residuals, candidates, "place", 0.5 * width)
        candidates = moved_to_maximum(effect, residuals, candidates, "width", 0.35 * width)
    return candidates
