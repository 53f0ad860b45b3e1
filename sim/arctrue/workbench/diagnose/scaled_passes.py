"""Finds passes of a reference whose errors are a constant times those of the other passes.

Such a pass is in another unit, or its errors have the other sign. Another unit multiplies the noise
of the reference by the same constant; a real error of the table that grows leaves the noise as it
is. The noise therefore decides if the passes show it. A real error may change its sign with a
recorded condition, or because a vibration has advanced by half a period between two passes.
Therefore a sign counts as wrong only without such a condition, and only if several orders of the
angle show it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.part_conditions import recorded_conditions
from arctrue.workbench.inference.visits_of_places import LEAST_PLACES, visits_of_rows
from arctrue.workbench.observations import Observations, ReferenceRows
from arctrue.workbench.observations.file_lines import file_line

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOST_ROWS = 30_000
"""Limit of the computing time: of n times this number of rows or more, only every n-th row is
compared. Twenty turns with 720 places and two rows at each place have nearly this number."""
EQUAL_RATIO = 1.3
"""Largest ratio of the RMS errors of two passes that count as equal: a gain may change by 30 %."""
FAR = 3.0
"""Smallest factor, or inverse of a factor, that counts as another unit: the smallest factor of
usual units is 3.09 (arcseconds to tenths of a milligon)."""
LEAST_EXPLAINED = 0.9
"""Smallest share of the sum of squares of a pass's errors that the factor times the curve of the
others explains. Two passes of eight independent values reach it by chance in one of 3,000 cases
(Student's t, six degrees of freedom)."""
OF_TWO_PASSES = 0.8
"""Smallest squared correlation of two equal passes: 0.9², because both have noise."""
MOST_OF_ONE_PLACE = 0.5
"""Largest share of the curve's sum of squares at one place: the error of a single station is no
curve."""
LEAST_OVER_U = 10.0
"""Smallest factor, in its own standard uncertainties: three of these are then at most 30 % of the
factor, much less than FAR."""
DECIDES = 2.0
"""The scatter of a pass decides whether its noise has the factor if the two expected scatters, with
and without the factor, differ enough: half the difference of their logarithms must be at least this
number of standard deviations. The logarithm of a scatter with ν degrees of freedom has the standard
deviation 1/√(2ν)."""
PRECISE = 0.05
"""Largest relative standard uncertainty of a factor that shows a unit of SURE_FACTORS without the
evidence of the scatter."""
DIFFERS = 3.0
"""A condition separates a pass from the equal passes if its mean in the pass is outside the range
of its means in these by more than this number times the larger of two values: this range, and the
standard deviation within the passes. At a smaller distance, a linear effect would change the equal
passes too, by more than a third of the change."""
SIGN_WITHIN = 0.1
"""A factor is a wrong sign if it differs from −1 by at most this value, or by at most three
standard uncertainties."""
FINEST_ORDER = 0.25
"""Lowest order, and step of the order, in the search for the strongest line, which is removed
before the sign is tested: half of the order 0.5 that a pass over a turn resolves."""

SURE_FACTORS = {
    60.0: "arcminutes",
    3600.0: "degrees",
    180.0 * 3600.0 / np.pi: "radians",
    1000.0: "thousands of its unit",
    0.648 / np.pi * 1000.0: "milliradians",
}
"""Number of arcseconds in each unit, or 1,000. No real effect enlarges the whole curve so much; the
factor alone therefore shows the unit."""
OTHER_FACTORS = {np.pi / 0.648: "microradians"}
"""Number of units in an arcsecond; the scatter must have the factor too."""


@dataclass(frozen=True, eq=False)
class _Passes:
    """Errors of the passes at their common places."""

    values: Float
    """Errors without the mean of each pass, (passes, places)."""
    angle_rad: Float
    number: Integer
    """Number of each pass among the passes of the reference."""


@dataclass(frozen=True)
class _Factor:
    """Ratio of the errors of one pass to the curve of the equal passes."""

    one_pass: int
    size: float
    sigma: float
    scatter_too: bool
    """True if the scatter of the pass has the factor too."""


def scaled_passes(observations: Observations) -> list[str]:
    """Describe the runs, or passes, whose errors are a constant times those of the others."""
    every = observations.every_reference_row
    if every is None:
        return []
    thin = max(every.run.size // MOST_ROWS, 1)
    rows = every.part(slice(None, None, thin)) if thin > 1 else every
    visits = visits_of_rows(rows)
    if visits is None:
        return []
    means = visits.means(rows.error_arcsec)
    table = np.full((visits.passes, visits.angle_rad.size), np.nan)
    table[visits.one_pass, visits.place] = means
    passes = _common(table, visits.angle_rad)
    if passes is None:
        return []
    equal = _largest_group(passes.values)
    others = np.setdiff1d(np.arange(passes.number.size), equal)
    if others.size == 0 or equal.size < others.size:
        return []
    of_row = np.where(visits.of_row >= 0, visits.one_pass[visits.of_row], -1)
    rows_of = [np.flatnonzero(of_row == number) for number in passes.number]
    found = [
        _factor(passes, equal, int(one), _smallest_step(rows.error_arcsec[rows_of[one]]))
        for one in others
    ]
    factors = [item for item in found if item is not None]
    if len(factors) < others.size:
        # If another pass differs from the curve by more than a factor, the curve is not constant.
        return []
    for item in factors:
        if _name(item) in SURE_FACTORS.values():
            continue
        if _separated(observations, rows, rows_of, equal, item.one_pass):
            return []
        if item.size < 0.0 and not item.scatter_too and not _shows_a_sign(passes, equal, item):
            return []

    def line_of(row: int) -> int:
        return file_line(observations.used_reference_rows, row * thin)

    return _sentences(rows, factors, rows_of, passes, line_of)


def _common(table: Float, angle_rad: Float) -> _Passes | None:
    """Return the errors at the places that all passes visit; short passes are left out."""
    there = np.isfinite(table)
    number = np.flatnonzero(there.sum(axis=1) > 0.5 * table.shape[1])
    places = np.flatnonzero(there[number].all(axis=0))
    if number.size < 2 or places.size < LEAST_PLACES:
        return None
    values = table[np.ix_(number, places)]
    return _Passes(values - values.mean(axis=1, keepdims=True), angle_rad[places], number)


def _largest_group(values: Float) -> Integer:
    """Return the pass that equals the most other passes, and these passes."""
    products = values @ values.T
    square = np.maximum(np.diag(products), 1e-300)
    scale = np.sqrt(square[:, np.newaxis] / square)
    correlated = products / np.sqrt(np.outer(square, square)) >= np.sqrt(OF_TWO_PASSES)
    near = correlated & (np.abs(np.log(scale)) <= np.log(EQUAL_RATIO))
    return np.asarray(np.flatnonzero(near[int(np.argmax(near.sum(axis=1)))]))


def _smallest_step(values: Float) -> float:
    """Return the smallest difference of two different values, an upper bound of the rounding."""
    steps = np.diff(np.unique(np.round(values, 9)))
    return float(steps.min(initial=np.inf)) if steps.size else 0.0


def _factor(passes: _Passes, equal: Integer, one_pass: int, step: float) -> _Factor | None:
    """Return the factor of a pass; None if it is near 1 or does not explain the errors."""
    group, own = passes.values[equal], passes.values[one_pass]
    curve = group.mean(axis=0)
    count, places = group.shape
    square, whole = float(curve @ curve), float(own @ own)
    if whole <= 0.0 or float(np.max(curve**2)) > MOST_OF_ONE_PLACE * square:
        return None
    noise = 0.0
    if count > 1:
        noise = float(np.sum((group - curve) ** 2)) / ((count - 1) * (places - 1))
    slope = float(own @ curve) / square
    left = own - slope * curve
    scatter = float(np.sqrt(left @ left / (places - 2)))
    sigma = scatter / float(np.sqrt(square))
    if whole * LEAST_EXPLAINED > whole - float(left @ left):
        return None
    # The noise of the curve makes the slope smaller. If only one pass gives the curve, this noise
    # is unknown. The ratio of the RMS errors is then the factor, if the noise has this factor too.
    size = slope * square / max(square - (places - 1) * noise / count, 0.5 * square)
    if count == 1:
        size = float(np.sign(slope)) * float(np.sqrt(whole / square))
    rounding = step**2 / 12.0
    with_factor = np.sqrt(size**2 * noise * (1.0 + 1.0 / count) + rounding)
    without = np.sqrt(noise * (1.0 + size**2 / count) + rounding)
    decides, scatter_too = False, False
    if noise > 0.0:
        apart = abs(float(np.log(with_factor / without)))
        variance = 0.5 / (places - 2) + 0.5 / ((count - 1) * (places - 1))
        decides = 0.5 * apart >= DECIDES * float(np.sqrt(variance))
        away = abs(float(np.log(max(scatter, 1e-300) / with_factor)))
        scatter_too = decides and away < 0.5 * apart
    item = _Factor(one_pass, size, sigma, scatter_too)
    far = max(abs(size), 1.0 / abs(size)) >= FAR
    if abs(size) < LEAST_OVER_U * sigma or (decides and far and not scatter_too):
        return None
    if far:
        sure = _name(item) in SURE_FACTORS.values() and sigma <= PRECISE * abs(size)
        return item if scatter_too or sure else None
    return item if abs(size + 1.0) <= max(SIGN_WITHIN, 3.0 * sigma) else None


def _name(item: _Factor) -> str | None:
    """Return the unit that the factor shows; None if it is no known factor."""
    ratio = max(abs(item.size), 1.0 / abs(item.size))
    within = 3.0 * item.sigma / abs(item.size) + 0.005
    for known, name in (SURE_FACTORS | OTHER_FACTORS).items():
        if abs(ratio / known - 1.0) <= within:
            return name
    return None


def _shows_a_sign(passes: _Passes, equal: Integer, item: _Factor) -> bool:
    """Tell whether a pass still has the other sign after a parabola and the strongest line, which a
    drift or a line in time may cause, are removed."""
    angle = passes.angle_rad
    if angle.size < 2 * LEAST_PLACES:
        return False
    both = np.stack([passes.values[equal].mean(axis=0), passes.values[item.one_pass]], axis=1)
    way = (angle - angle[0]) / float(np.ptp(angle)) * (1.0 - 1.0 / angle.size)
    basis = np.linalg.qr(np.stack([np.ones(way.size), way, way**2], axis=1))[0]
    both = both - basis @ (basis.T @ both)
    strongest, taken = both, -1.0
    for order in np.arange(FINEST_ORDER, angle.size / 2, FINEST_ORDER):
        phase = 2.0 * np.pi * order * way
        wave = np.stack([np.cos(phase), np.sin(phase)], axis=1)
        wave = wave - basis @ (basis.T @ wave)
        left = both - wave @ np.linalg.lstsq(wave, both, rcond=1e-9)[0]
        gain = float(np.sum(both[:, 0] ** 2) - np.sum(left[:, 0] ** 2))
        if gain > taken:
            strongest, taken = left, gain
    curve, own = strongest.T
    slope = float(own @ curve) / max(float(curve @ curve), 1e-300)
    remaining = float(np.sum((own - slope * curve) ** 2))
    return slope < 0.0 and remaining <= (1.0 - LEAST_EXPLAINED) * float(own @ own)


def _separated(
    observations: Observations,
    rows: ReferenceRows,
    rows_of: list[Integer],
    equal: Integer,
    one_pass: int,
) -> bool:
    """Tell whether the direction of the targets or a recorded condition (except the time) separates
    a pass from the equal passes."""
    ways = np.zeros(rows.run.size)
    for own in rows_of:
        ways[own] = np.sign(rows.target_rad[own[-1]] - rows.target_rad[own[0]])
    conditions = [item for item in recorded_conditions(observations) if item.part != "time"]
    for values in [ways, *(item.values(rows) for item in conditions)]:
        if values is None:
            continue
        mean = float(values[rows_of[one_pass]].mean())
        means = np.array([values[rows_of[other]].mean() for other in equal])
        within = float(np.mean([np.std(values[rows_of[other]]) for other in equal]))
        away = max(mean - float(means.max()), float(means.min()) - mean)
        if away > DIFFERS * max(within, float(np.ptp(means))) + 1e-9 * abs(mean):
            return True
    return False


def _sentences(
    rows: ReferenceRows,
    factors: list[_Factor],
    rows_of: list[Integer],
    passes: _Passes,
    line_of: Callable[[int], int],
) -> list[str]:
    """Return a sentence for each run, or pass, with a factor."""
    found: dict[str, tuple[int, list[_Factor]]] = {}
    scaled = {item.one_pass for item in factors}
    runs = np.array([rows.run[own[0]] for own in rows_of])
    for item in factors:
        of_run = np.flatnonzero(runs == runs[item.one_pass])
        whole = scaled.issuperset(of_run.tolist())
        name = f"run {runs[item.one_pass]}"
        if not whole:
            name += f", pass {int(np.flatnonzero(of_run == item.one_pass)[0]) + 1}"
        first = int(rows_of[item.one_pass][0])
        found.setdefault(name, (line_of(first), []))[1].append(item)
    said = []
    for name, (line, items) in found.items():
        weights = np.array([max(item.sigma, 1e-300) ** -2 for item in items])
        size = float(np.array([item.size for item in items]) @ weights / weights.sum())
        sigma = float(weights.sum() ** -0.5)
        said.append(
            f"reference, {name}, from line {line} of the file: at {passes.angle_rad.size} places "
            f"its errors are {size:.4g} (u {sigma:.1g}) times those of the other passes"
            + _reason(_Factor(items[0].one_pass, size, sigma, items[0].scatter_too))
        )
    return said


def _reason(item: _Factor) -> str:
    """Return what the factor shows, and what is expected."""
    unit = _name(item)
    scatter = ", and their scatter has the same factor" if item.scatter_too else ""
    asked = "; expected error_arcsec in arcseconds, with one sign, in every row"
    if max(abs(item.size), 1.0 / abs(item.size)) < FAR:
        return f": the sign of error_arcsec is wrong in one of them{asked}"
    smaller = "its" if (abs(item.size) < 1.0) == (unit != "microradians") else "the other"
    sign = ", with the other sign" if item.size < 0.0 else ""
    if unit is None:
        return f"{scatter}: the unit or the gain differs{sign}{asked}"
    if unit == SURE_FACTORS[1000.0]:
        return f"{scatter}: one unit is 1,000 times the other{sign}{asked}"
    return f"{scatter}: {smaller} errors seem to be in {unit}{sign}{asked}"
