"""Separates the channels of a capture with three or four heads, for searches."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]


def channel_rows(
    rows: CaptureRows | ReferenceRows, block: slice = slice(None)
) -> list[slice | NDArray[np.int64]]:
    """Return the rows of each channel within a block.

    Sums are calculated channel by channel, because signals of two channels may cancel in a common
    sum.
    """
    if isinstance(rows, ReferenceRows) or rows.channel is None:
        return [slice(None)]
    inside = rows.channel[block]
    return [np.flatnonzero(inside == channel) for channel in range(rows.channels)]


def power_of_channels(spectra: Sequence[NDArray[np.complex128]]) -> Float:
    """Return the summed power of the channels, to be divided by the information of all channels.

    Each of K channels has 1/K of the information. The power is therefore multiplied by K, so that
    the quotient is the sum of the gains of the channels.
    """
    total = np.abs(spectra[0]) ** 2
    for spectrum in spectra[1:]:
        total += np.abs(spectrum) ** 2
    return np.asarray(total * len(spectra) if len(spectra) > 1 else total)


def best_factor(rows: CaptureRows, orders: NDArray[np.int64]) -> Float:
    """Return, for each order n, the largest |e^{jnβ} − 1| over the heads at the angles β after head
    1."""
    factor = np.abs(np.exp(1j * orders * rows.head_separation_rad) - 1.0)
    for place_rad in rows.further_places_rad:
        factor = np.maximum(factor, np.abs(np.exp(1j * orders * place_rad) - 1.0))
    return np.asarray(factor)


def shifts_of_channels(
    rows: CaptureRows, orders: NDArray[np.int64]
) -> list[NDArray[np.complex128]]:
    """Return the factor by which a disc error e^{jnψ} enters each channel; for R₂ − R₁ it is
    e^{jnα} − 1."""
    places = (rows.head_separation_rad, *rows.further_places_rad)
    of_heads = [np.exp(1j * orders * place_rad) - 1.0 for place_rad in places]
    if len(places) == 1:
        return of_heads
    return list(rows.weights @ np.array(of_heads))
