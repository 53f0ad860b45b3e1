"""Finds lines that are too fast for the averaged rows of a record, in the single rows.

A mean over several rows keeps a part of such a line, which then looks like a slower line: its alias
about the rate of the averaged rows. A record therefore has the averaged columns of these lines in
its base.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import median_filter
from scipy.optimize import minimize_scalar
from scipy.special import chdtri, fdtrc, gamma

from arctrue.workbench.inference.forward.fast_resonances import (
    REACH,
    gain_over_an_oscillation,
)

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

CHANCE = 0.01
"""Probability with which white noise shows a fast line: the family-wise level of every search."""
MOST_LINES = 16
"""Largest number of lines that are subtracted, to limit cost; the search for lines has the same
limit."""
CELLS_A_ROW = 2.0
"""Cells of the evenly spaced grid in a median step of the rows. A line at the highest rate keeps
sinc² 1/4 = 81 % of its power in cells of half a step."""
LEAST_PERIODS = 4.0
"""Fewest periods of a line in a record, as in the search for lines."""
PADDED = 2
"""Length of the transform, in lengths of the record: a line midway between two rates keeps sinc²
1/4 = 81 % of its power."""
MOST_CELLS = 2**23
"""Largest number of cells, to limit cost; a transform then takes about a second. A record with more
cells, such as two short runs with days between them, gets no search."""
NEIGHBOURS = 41
"""Number of independent rates in the median that gives the local level, as in the search for
lines."""
FINE = 0.005
"""Accuracy of a rate, in units of 1/span: the phase at the ends of the record is then wrong by
0.016 rad, and the alias of the error has 1 % of the alias of the line."""
BLOCKS = 8
"""Number of blocks of rows, each of which the others must predict, as in the search for lines."""
PREDICTED_SHARE = 0.5
"""Smallest share of a line's own error that the other blocks must predict, as in the search for
lines; an oscillation that loses its phase within a block has a share of 0."""

OSCILLATION_GAIN = 7.0
"""Smallest gain in log likelihood of each line over an oscillation, as in the search for lines."""


@dataclass(frozen=True, eq=False)
class FastLine:
    """A line in single rows."""

    rate: float
    columns: Float
    """Cos and sin, for each sense of motion, shape (rows, k)."""


@dataclass(frozen=True)
class FastSize:
    """Rate and amplitude of a line in single rows that the other blocks predict."""

    rate: float
    amplitude_arcsec: float


def sizes_of(
    lines: Sequence[FastLine],
    place: Float,
    stretch: Integer,
    left_arcsec: Float,
    lowest: float = 0.0,
) -> tuple[FastSize, ...]:
    """Return the amplitude of each line above the rate ``lowest`` that is the same in all blocks of
    rows and more than an oscillation driven by noise, the largest first.

    All lines are fitted together; with two senses of motion the amplitude is the RMS of both. As in
    the search for lines, each line is compared with an oscillation, and neighbouring lines (within
    REACH ordinates) together with one oscillation.
    """
    if not lines:
        return ()
    every = np.hstack([line.columns for line in lines])
    fitted = np.linalg.lstsq(every, left_arcsec, rcond=1e-10)[0]
    remaining = left_arcsec - every @ fitted
    width = lines[0].columns.shape[1]
    senses = _senses(place, stretch)

    def gain(of: Sequence[tuple[FastLine, Float]]) -> float:
        without = remaining + np.sum([wave for _, wave in of], axis=0)
        rates = [line.rate for line, _ in of]
        return gain_over_an_oscillation(place, senses, remaining, without, rates) / len(of)

    waves = [
        (line, line.columns @ fitted[number * width : (number + 1) * width])
        for number, line in enumerate(lines)
        if line.rate > lowest
    ]
    block = np.arange(left_arcsec.size) * BLOCKS // left_arcsec.size
    found = [
        FastSize(line.rate, float(np.sqrt(2.0 * np.mean(wave**2))))
        for group in _neighbours(waves, REACH / float(np.ptp(place)))
        if gain(group) > OSCILLATION_GAIN
        for line, wave in group
        if (len(group) == 1 or gain([(line, wave)]) > OSCILLATION_GAIN)
        and _share_predicted(line.columns, remaining + wave, block) > PREDICTED_SHARE
    ]
    return tuple(sorted(found, key=lambda line: -line.amplitude_arcsec))


def _neighbours(
    waves: Sequence[tuple[FastLine, Float]], apart: float
) -> Iterator[list[tuple[FastLine, Float]]]:
    """Yield groups of lines, each at most ``apart`` from the next in its group."""
    group: list[tuple[FastLine, Float]] = []
    for item in sorted(waves, key=lambda item: item[0].rate):
        if group and item[0].rate - group[-1][0].rate > apart:
            yield group
            group = []
        group.append(item)
    if group:
        yield group


def _share_predicted(columns: Float, left: Float, block: Integer) -> float:
    """Return the share of a line's square in each block that the other blocks predict."""
    own = missed = 0.0
    for number in range(BLOCKS):
        here = block == number
        inside = columns[here]
        alone = inside @ np.linalg.lstsq(inside, left[here], rcond=1e-10)[0]
        elsewhere = np.linalg.lstsq(columns[~here], left[~here], rcond=1e-10)[0]
        own += float(alone @ alone)
        missed += float(np.sum((alone - inside @ elsewhere) ** 2))
    return 1.0 - missed / max(own, 1e-300)


def fast_lines(
    place: Float, stretch: Integer, left_arcsec: Float, lowest: float
) -> Iterator[FastLine]:
    """Yield every significant line above the rate ``lowest``, with its cos and sin.

    Each line has one pair of columns for each sense of motion, because a lag or backlash gives the
    line another phase on the way back. Slower lines are subtracted too: uneven rows show them at
    fast rates as well, with less power.
    """
    senses = _senses(place, stretch)
    left = left_arcsec
    known: list[float] = []
    for _ in range(MOST_LINES):
        rate = _largest_line(place, stretch, left, senses, known)
        if rate is None:
            return
        known.append(rate)
        phase = 2.0 * np.pi * rate * (place - place[0])
        waves = np.column_stack([np.cos(phase), np.sin(phase)])
        columns = np.hstack([sense[:, np.newaxis] * waves for sense in senses.T])
        left = left - columns @ np.linalg.lstsq(columns, left, rcond=1e-10)[0]
        if rate > lowest:
            yield FastLine(rate, columns)


def changes_evenly(place: Float, other: Float, stretch: Integer) -> bool:
    """Tell whether the coordinate changes in proportion to ``other``, so that both show the same
    lines. The phase of a line up to the highest rate then differs by at most FINE periods."""
    steps = np.abs(np.diff(place))[np.diff(stretch) == 0]
    step, from_mean = float(np.median(steps)), other - other.mean()
    square = float(from_mean @ from_mean)
    if step <= 0.0 or square <= 0.0:
        return False
    even = (float(from_mean @ place) / square) * from_mean + place.mean()
    return float(np.max(np.abs(place - even))) <= FINE * 2.0 * step


def _senses(place: Float, stretch: Integer) -> Float:
    """Return a column of zeros and ones for each sense of motion, shape (rows, 1 or 2)."""
    starts = np.flatnonzero(np.diff(stretch, prepend=stretch[0] - 1))
    ends = np.append(starts[1:], stretch.size) - 1
    back = np.repeat(place[ends] < place[starts], ends - starts + 1)
    both = np.column_stack([~back, back]).astype(np.float64)
    return both[:, both.any(axis=0)]


def _largest_line(
    place: Float,
    stretch: Integer,
    left_arcsec: Float,
    senses: Float,
    known: Sequence[float],
) -> float | None:
    """Return the rate with the largest power among the significant rates; None if there is none.

    A rate nearer than 1/span to a known line is not separated from this line: amplitudes that are
    fitted to both would be large and cancel each other.
    """
    steps = np.abs(np.diff(place))[np.diff(stretch) == 0]
    step, span = float(np.median(steps)), float(np.ptp(place))
    if step <= 0.0 or CELLS_A_ROW * PADDED * span / step > MOST_CELLS:
        return None
    cell = np.floor((place - place.min()) * (CELLS_A_ROW / step)).astype(np.int64)
    cells = int(cell.max()) + 1
    length = 2 ** int(np.ceil(np.log2(PADDED * cells)))
    rates = np.arange(length // 2 + 1) * (CELLS_A_ROW / (step * length))
    kept = (rates > LEAST_PERIODS / span) & (rates < 0.5 / step)
    if np.count_nonzero(kept) < NEIGHBOURS:
        return None
    power = np.zeros(np.count_nonzero(kept))
    for sense in senses.T:
        sums = np.bincount(cell, weights=sense * left_arcsec, minlength=cells)
        power += (np.abs(np.fft.rfft(sums, length)) ** 2)[kept] / float(sense.sum())
    freedom = 2 * senses.shape[1]
    excess = power / _level(power, round(length / cells), freedom)
    independent = max(float(np.ptp(rates[kept])) * span, 1.0)
    p_values = fdtrc(freedom, _freedom_of_level(freedom), 2.0 * excess / freedom)
    sure = independent * p_values < CHANCE
    for other in known:
        sure &= np.abs(rates[kept] - other) * span >= 1.0
    if not sure.any():
        return None
    at = int(np.argmax(np.where(sure, power, 0.0)))
    rate = float(rates[kept][at])

    def cost(moved: float) -> float:
        wave = np.exp(-2j * np.pi * moved * (place - place[0])) * left_arcsec
        powers = [float(np.abs(wave @ sense) ** 2 / sense.sum()) for sense in senses.T]
        return -sum(powers)

    wide = 0.5 / span
    found = minimize_scalar(
        cost, bounds=(rate - wide, rate + wide), method="bounded", options={"xatol": FINE / span}
    )
    return float(found.x)


def _level(power: Float, apart: int, freedom: int) -> Float:
    """Return the level of the noise at each rate: the median of neighbours that are ``apart``
    ordinates from each other and therefore independent, divided by the median for noise of level
    1."""
    middle = median_filter(power[::apart], size=NEIGHBOURS, mode="reflect")
    middle = middle / (0.5 * float(chdtri(freedom, 0.5)))
    at = np.arange(power.size)
    return np.asarray(np.maximum(np.interp(at, at[::apart], middle), 1e-300))


def _freedom_of_level(freedom: int) -> float:
    """Return the degrees of freedom of the level: those of the mean of squares with the same
    relative variance as the median of NEIGHBOURS values of χ² with ``freedom``.

    The median of m values with the density f at the median x has the variance 1/(4·m·f(x)²), and
    the mean of squares with n degrees of freedom has the relative variance 2/n.
    """
    middle, half = float(chdtri(freedom, 0.5)), 0.5 * freedom
    density = (0.5 * middle) ** (half - 1.0) * np.exp(-0.5 * middle) / (2.0 * float(gamma(half)))
    return float(8.0 * NEIGHBOURS * (density * middle) ** 2)
