"""Computes the ideal test of one cause, with the cause's exact form, the true covariance and the
base model.

The base model has orders 1 to 20 on the disc, an offset for each run and contrast of the heads, and
a zero of the reference.
The test is the generalised likelihood ratio of the cause's exact form against the base model, under
the covariance with which the noise was drawn. This module imports nothing from the workbench.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_solve_banded, cholesky_banded, lstsq
from scipy.optimize import brentq
from scipy.stats import chi2, ncx2

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.measurement import MeasurementSet
from arctrue.studies.simulate.measured_table import TrueNoise, contrasts
from arctrue.table.noise import Noise
from arctrue.table.registry import REGISTRY

Float = NDArray[np.float64]

BASE_ORDERS = 20
FALSE_ALARM, POWER = 0.01, 0.95


@dataclass(frozen=True, slots=True)
class Sight:
    """Result of the ideal test for one cause in one set."""

    noncentrality: float
    """Noncentrality of the test's χ²: the sum of squares, in units of the noise, of the part that
    the base model cannot absorb."""
    needed: float
    """Noncentrality at which the test, with a false-alarm probability of 1 %, finds the cause in 95
    % of such sets."""
    rms_arcsec: float
    """RMS of the part that the base model cannot absorb, in the channel where it is largest; the
    offsets of runs count too."""

    @property
    def sees(self) -> bool:
        """Tell whether the ideal test finds the cause in 95 % of such sets."""
        return self.noncentrality >= self.needed

    @property
    def size_in_limits(self) -> float:
        """Return the cause's size divided by the smallest size that the ideal test finds in 95 % of
        such sets."""
        return float(np.sqrt(self.noncentrality / self.needed))


@dataclass(frozen=True, slots=True)
class _Block:
    """Rows of one contrast of the heads, or of the reference."""

    channel: str
    rows: slice
    """Rows of the channel's signal."""
    columns: Float
    """Base model ``(n, width)``."""


@cache
def needed_noncentrality(effect: str, heads: int = 2, of_one_head: bool = False) -> float:
    """Return the λ at which a noncentral χ² exceeds the look-elsewhere threshold with probability
    POWER.

    With three or four heads the test also searches for the head if the cause acts on one head; two
    heads do not show which of them has a fault.
    """
    recipe = REGISTRY[effect]
    rank, places = recipe.coefficients, recipe.places
    if heads > 2:
        rank = recipe.coefficients_of_more_heads or rank
        places = places * (heads if of_one_head else 1)
    threshold = chi2.isf(FALSE_ALARM / places, rank)
    return float(brentq(lambda value: ncx2.sf(threshold, rank, value) - POWER, 1e-3, 1e4))


def inverse_times(noise: Noise, columns: Float) -> Float:
    """Return C⁻¹ × ``columns`` ``(n, c)`` for C = W + Σ_j sigma_j²·K_j, W = diag(white²) > 0.

    The function uses the matrix inversion lemma over the k Gauss–Markov processes. Their joint
    precision matrix is banded if their states are interleaved row by row: O(n·k²·(k + c)).
    """
    weight = 1.0 / noise.white_rad**2
    weighted = weight[:, None] * columns
    parts = noise.sigma_rad.size
    if parts == 0:
        return weighted
    rows = weight.size
    decay = noise.decay.T.copy()
    decay[0] = 0.0
    fresh = 1.0 / ((1.0 - decay**2) * noise.sigma_rad**2)
    # Precision of x_i = a_i·x_{i−1} + w_i with var w_i = q_i: 1/q_i + a²_{i+1}/q_{i+1} on the
    # diagonal, −a_i/q_i next to the diagonal.
    diagonal = fresh.copy()
    diagonal[:-1] += decay[1:] ** 2 * fresh[1:]
    band = np.zeros((parts + 1, rows * parts))
    band[0] = (diagonal + weight[:, None]).ravel()
    band[parts, : (rows - 1) * parts] = -(decay[1:] * fresh[1:]).ravel()
    for apart in range(1, parts):
        # A row measures the sum of all its processes, so the white precision couples them pairwise.
        together = np.zeros((rows, parts))
        together[:, : parts - apart] = weight[:, None]
        band[apart] = together.ravel()
    factor = cholesky_banded(band, lower=True)
    states = cho_solve_banded((factor, True), np.repeat(weighted, parts, axis=0))
    explained = states.reshape(rows, parts, -1).sum(axis=1)
    return np.asarray(weighted - weight[:, None] * explained)


def look(
    effect: str,
    measurement: MeasurementSet,
    signal_arcsec: dict[str, Float],
    noise: dict[str, TrueNoise],
    index_variance_arcsec2: float,
    of_one_head: bool = False,
) -> Sight:
    """Compute the ideal test of one cause; ``signal_arcsec`` is the signal of this cause alone in
    each channel. The signal of the capture holds the rows of every contrast of the heads, one
    contrast after another."""
    blocks = _blocks(measurement)
    normal, right, square = _sums(measurement, blocks, signal_arcsec, noise, index_variance_arcsec2)
    absorbed = lstsq(normal, right, lapack_driver="gelsy")[0]
    noncentrality = max(0.0, square - float(right @ absorbed))
    largest = 0.0
    for block in blocks:
        left = signal_arcsec[block.channel][block.rows] - np.asarray(block.columns @ absorbed)
        sound = ~noise[block.channel].struck
        largest = max(largest, float(np.sqrt(np.mean(left[sound] ** 2))))
    # The fit may absorb an offset in the index, but the offset still shifts the prediction, so its
    # full size counts.
    if measurement.capture is not None:
        for offsets in absorbed[_offsets(measurement)].reshape(-1, _runs(measurement)):
            largest = max(largest, float(np.sqrt(np.mean(offsets**2))))
    heads = 0 if measurement.capture is None else len(measurement.capture.heads)
    return Sight(noncentrality, needed_noncentrality(effect, heads, of_one_head), largest)


def _sums(
    measurement: MeasurementSet,
    blocks: Sequence[_Block],
    signal_arcsec: dict[str, Float],
    noise: dict[str, TrueNoise],
    index_variance_arcsec2: float,
) -> tuple[Float, Float, float]:
    """Compute normal matrix, right side and square of the signal over all channels and index."""
    width = blocks[0].columns.shape[1]
    normal, right, square = np.zeros((width, width)), np.zeros(width), 0.0
    for block in blocks:
        sound = ~noise[block.channel].struck
        process = noise[block.channel].gaussian.rows(sound)
        signal = signal_arcsec[block.channel][block.rows]
        with_signal = np.column_stack([block.columns[sound], signal[sound]])
        weighted = inverse_times(_in_arcsec(process), with_signal)
        products = with_signal.T @ weighted
        normal += products[:-1, :-1]
        right += products[:-1, -1]
        square += float(products[-1, -1])
    offsets = range(width)[_offsets(measurement)]
    stated = measurement.table.index_repeatability_counts is not None
    # The offset of a single run does not show how well the index repeats.
    if stated or _runs(measurement) > 1:
        for offset in offsets:
            # If the index repeats exactly, the offset is zero.
            normal[offset, offset] += 1.0 / max(index_variance_arcsec2, 1e-12)
    return normal, right, square


def _in_arcsec(noise: Noise) -> Noise:
    return Noise(noise.white_rad * ARCSEC_PER_RAD, noise.sigma_rad * ARCSEC_PER_RAD, noise.decay)


def _runs(measurement: MeasurementSet) -> int:
    return 0 if measurement.capture is None else int(measurement.capture.run.max()) + 1


def _offsets(measurement: MeasurementSet) -> slice:
    """Return the columns with the offsets of all runs, for each contrast of the heads."""
    capture = measurement.capture
    more = 0 if capture is None else len(capture.heads) - 1
    return slice(2 * BASE_ORDERS, 2 * BASE_ORDERS + more * _runs(measurement))


def _blocks(measurement: MeasurementSet) -> list[_Block]:
    """Return the base model of every contrast and of the reference: orders, offsets, reference
    zero."""
    found: list[_Block] = []
    block: Float
    capture, reference, facts = measurement.capture, measurement.reference, measurement.table
    offsets = _offsets(measurement)
    if capture is not None:
        assert facts.counts_per_rev is not None
        assert facts.places_deg is not None
        head1_rad = capture.head1_counts * (2 * np.pi / facts.counts_per_rev)
        rows = np.arange(head1_rad.size)
        seen = [_waves(head1_rad + float(np.radians(place))) for place in facts.places_deg]
        for number, waves in enumerate(contrasts(seen)):
            block = np.zeros((rows.size, offsets.stop + 1))
            block[:, : offsets.start] = waves
            first = offsets.start + number * _runs(measurement)
            block[rows, first + capture.run] = 1.0
            found.append(
                _Block("capture", slice(number * rows.size, (number + 1) * rows.size), block)
            )
    if reference is not None:
        block = np.zeros((reference.target_deg.size, offsets.stop + 1))
        block[:, : offsets.start] = _waves(np.radians(reference.target_deg))
        block[:, -1] = 1.0
        found.append(_Block("reference", slice(None), block))
    return found


def _waves(angle_rad: NDArray[np.floating[Any]]) -> Float:
    powers = np.exp(1j * angle_rad)[:, None] ** np.arange(1, BASE_ORDERS + 1)
    return np.concatenate([powers.real, powers.imag], axis=1)


def visible(sights: Sequence[Sight], matters_arcsec: float) -> bool:
    """Tell whether the ideal test detects any of the causes that change the prediction by more than
    ``matters_arcsec``."""
    return any(sight.sees and sight.rms_arcsec > matters_arcsec for sight in sights)
