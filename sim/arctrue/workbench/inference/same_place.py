"""Compares the passes of a reference at equal places: an error that every pass shows at the same
place belongs to the place, and only the scatter between the passes is noise (pure error).

The F test of lack of fit with repeated readings is that of Draper and Smith, Applied Regression
Analysis, chapter 2. The part of each pass that the model's columns explain is removed first; the
mean squares then contain no smooth drift of a pass. The noise of neighbouring places may be
correlated, and its variance may differ from place to place: Box, Ann. Math. Stat. 25 (1954) 290 and
484, multiplies both degrees of freedom of F by ε. The coefficients of the model do not matter,
because its columns are removed from each pass.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.special import fdtrc, ndtr

from arctrue.workbench.inference.repeated_error import RepeatedError, Spot
from arctrue.workbench.inference.step_of_angle import StepOfAngle, best_step
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.numeric.distributions import student_upper_p

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

SURE_P = 1e-4
"""Largest p at which an error counts as repeated; it equals the limit of a sure lack of fit."""
LEAST_OWN = 0.1
"""The error of a place is fitted, and an effect is tested, only if the curves of the passes leave
at least this share of its variance. Its standard uncertainty is then at most 3.2 times that without
the curves (1/√0.1)."""
LEAST_REPEATED = 0.25
"""Smallest RMS of a repeated error, as a share of the scatter of a reading between the passes; it
equals LEAST_EXCESS, the limit of a model that is not adequate."""
MOST_SPOTS = 40
"""Largest number of places that are tried as single places; it limits the computing time only."""
ONE_IN = 8
"""At most 1/ONE_IN of the places may count as single places: their neighbours then show the usual
error."""
FAMILY_WISE = 0.01
"""Probability that a single place is found by chance, over all places."""
NEARLY_ALL = 0.9
"""Smallest share of the repeated mean square that single places must explain if the remaining error
is still significant. A named effect may also leave at most a tenth."""
LEAST_CURVE = 3
"""Smallest number of columns of the curve of a pass at which a step is searched: a constant and one
order. Without orders, a smooth error of the turn looks like a step that returns."""
STEP_AHEAD = 10.0
"""Smallest difference of χ², corrected for the number of places, at which a step replaces single
places: odds of 150 to 1."""
OF_THE_PLACE = 0.9
"""Smallest share of an effect's sum of squares that must repeat at the places; the cycles have the
same limit (MOST_WITHIN in :mod:`forward.cycles`)."""
DRAWS, SEED = 40, 1
"""Number of draws of the fitted noise that give its mean squares (to 4 % with 30 degrees of
freedom), and their seed."""
RESOLVED = 0.5
"""Smallest share of an effect's mean square that must remain in the means of the places; a wave
that is shorter than two places nearly vanishes in them."""


@dataclass(frozen=True)
class PureError:
    """Mean squares of the means of groups, and of the passes within the groups.

    A mean square is the sum of squares divided by its degrees of freedom, in correlated or uneven
    noise too; only the distribution of the ratio of two mean squares has the degrees of freedom
    times ``epsilon``.
    """

    between: float
    within: float
    between_freedom: float
    within_freedom: float
    visits: float
    """Mean number of passes of a group."""
    epsilon: float
    """Box's ε."""
    cases: int = 1
    """Number of ways to form the passes, of which the one with the smallest p was chosen."""

    def effective(self, freedom: float) -> float:
        """Return the degrees of freedom of a mean square in tests of F or t."""
        return max(self.epsilon * freedom, 1.0)

    def upper_p(self, mean_square: float, freedom: float) -> float:
        """Return the probability that the scatter of the passes causes a mean square of the means
        that is at least as large."""
        return float(
            fdtrc(
                self.effective(freedom),
                self.effective(self.within_freedom),
                mean_square / self.within,
            )
        )

    def upper_p_of_size(self, t_value: float) -> float:
        """Return the probability that the scatter of the passes causes a ratio of a size to its
        uncertainty that is at least as large, of either sign."""
        return 2.0 * student_upper_p(t_value, self.effective(self.within_freedom))

    @property
    def p(self) -> float:
        """Probability that the scatter of the passes causes such differences of the groups."""
        if self.within <= 0.0:
            return 1.0
        return min(1.0, self.cases * self.upper_p(self.between, self.between_freedom))

    @property
    def rms_arcsec(self) -> float:
        """RMS of the error of the groups, without the noise of their means."""
        return float(np.sqrt(max(self.between - self.within, 0.0) / self.visits))

    @property
    def scatter_arcsec(self) -> float:
        """Standard deviation of a cell between the passes."""
        return float(np.sqrt(self.within))


@dataclass(frozen=True, eq=False)
class Visits:
    """Residuals of a reference as means of cells; a cell is one place in one pass."""

    of_row: Integer
    """Cell of each row of the reference; −1 for rows that no second pass repeats."""
    place: Integer
    """Number of the place of each cell, 0, 1, … in the order of the angle."""
    one_pass: Integer
    """Number of the pass of each cell."""
    angle_rad: Float
    """Angle of each place."""
    bases: tuple[tuple[Integer, Float], ...]
    """Cells of each pass, and an orthonormal basis of the curve that is removed from this pass."""
    left: Float
    """Residual of each cell, without that curve."""
    stations: bool
    over_travel: bool
    side: Integer
    """Direction of the pass of each cell."""
    mean_square: float = 0.0
    """Mean square of the residual of every row."""
    noise: RowNoise | None = None
    """Noise that was fitted to the rows of the reference."""
    crossed: NDArray[np.bool_] | None = None
    """True for each place from which a run goes on to the next place of the turn, or back."""
    cases: int = 1
    """Number of ways to form the passes, of which the one with the smallest p was chosen."""

    def means(self, of_rows: Float) -> Float:
        """Return the means of the cells, without the curve of each pass."""
        return self.without_curves(cell_means(self.of_row, of_rows, self.place.size))

    def without_curves(self, cells: Float) -> Float:
        """Remove from each pass the curve that the model's columns explain."""
        found = cells.copy()
        for inside, basis in self.bases:
            found[inside] -= basis @ (basis.T @ found[inside])
        return found

    def _tested(self, group: Integer) -> PureError:
        """Calculate the mean squares of groups of cells; ``group`` is the group of each cell."""
        _, group = np.unique(group, return_inverse=True)
        count = np.bincount(group).astype(np.float64)
        repeated = count[group] > 1.0
        means = np.bincount(group, self.left) / count
        within_cells = (self.left - means[group]) * repeated
        # White noise gives a cell the mean square own·σ², and the mean of n cells own·σ²/n.
        of_means = float(np.sum((self._own_share / count[group])[repeated]))
        of_cells = float(np.sum(self._own_share[repeated])) - of_means
        if of_means < 1.0 or of_cells < 2.0:
            return PureError(0.0, 0.0, 1.0, 1.0, 1.0, 1.0)
        epsilon = self._equal_variance_share(within_cells, group, count)
        epsilon *= self._uncorrelated_share(within_cells, of_means, float(count.mean()))
        found = PureError(
            float(np.sum(np.where(count > 1.0, count * means**2, 0.0))) / of_means,
            float(np.sum(within_cells**2)) / of_cells,
            of_means,
            of_cells,
            float(np.mean(count[count > 1.0])),
            epsilon,
            self.cases,
        )
        if found.p >= FAMILY_WISE or not _is_coloured(self.noise):
            return found
        assert self.noise is not None
        # Before and after a reversal, two passes visit neighbouring places at nearly the same time:
        # slow noise then repeats.
        random, squares = np.random.default_rng(SEED), np.zeros(2)
        for _ in range(DRAWS):
            cells = self.means(self.noise.draw(random))
            mean = np.bincount(group, cells) / count
            squares[0] += float(np.sum(np.where(count > 1.0, count * mean**2, 0.0))) / of_means
            squares[1] += float(np.sum(((cells - mean[group]) * repeated) ** 2)) / of_cells
        ratio = float(squares[0] / max(squares[1], 1e-300))
        return found if ratio <= 1.0 else replace(found, within=found.within * ratio)

    @staticmethod
    def _equal_variance_share(within_cells: Float, group: Integer, count: Float) -> float:
        """Return Box's ε for variances that differ between the groups: (Σ v)²/(k·Σ v²).

        The square of a variance with ν degrees of freedom is too large by the factor 1 + 2/ν.
        """
        kept = count > 1.0
        freedom = count[kept] - 1.0
        variance = np.bincount(group, within_cells**2)[kept] / freedom
        square = float(np.mean(variance**2 / (1.0 + 2.0 / freedom)))
        return min(1.0, float(variance.mean()) ** 2 / max(square, 1e-300))

    def _uncorrelated_share(self, within_cells: Float, freedom: float, visits: float) -> float:
        """Return Box's ε for neighbouring places with correlated noise: k/(Σ ρ²) for k places,
        divided by the degrees of freedom.

        The correlations ρ of all lags are those of the differences of the passes from the means.
        The squares of estimated correlations are too large by the factor 1 + 2/ν, where ν is the
        number of passes of a place minus one (Bartlett).
        """
        places = self.angle_rad.size
        table = np.zeros((self.passes, places))
        there = np.zeros((self.passes, places))
        table[self.one_pass, self.place] = within_cells
        there[self.one_pass, self.place] = 1.0
        products, pairs = (
            np.fft.irfft(np.sum(np.abs(np.fft.rfft(item, 2 * places, axis=1)) ** 2, axis=0))[
                :places
            ]
            for item in (table, there)
        )
        rho = products / np.maximum(pairs, 0.5) / max(float(products[0] / pairs[0]), 1e-300)
        weight = pairs / pairs[0]
        squares = 1.0 + 2.0 * float(np.sum((weight * rho**2)[1:]))
        squares /= 1.0 + 2.0 / max(visits - 1.0, 1.0)
        return min(1.0, places / squares / freedom)

    @property
    def passes(self) -> int:
        """Number of passes."""
        return len(self.bases)

    @property
    def visits_of_a_place(self) -> int:
        """Largest number of passes over one place; a pass through 0° counts once on each side."""
        return int(np.bincount(self.place).max(initial=0))

    @cached_property
    def _own_share(self) -> Float:
        """Share of the variance of each cell that remains after the removal of the curves."""
        found = np.ones(self.place.size)
        for inside, basis in self.bases:
            found[inside] -= np.sum(basis**2, axis=1)
        return found

    @cached_property
    def by_place(self) -> PureError:
        """The F test of the places against the scatter of the passes."""
        return self._tested(self.place)

    @cached_property
    def by_place_and_side(self) -> PureError | None:
        """The F test of the places of each direction; None without two passes of each."""
        if (
            any(np.unique(self.one_pass[self.side == one]).size < 2 for one in np.unique(self.side))
            or np.unique(self.side).size < 2
        ):
            return None
        return self._tested(self.place * 2 + (self.side > 0))

    @property
    def lack_of_fit_p(self) -> float:
        """Smaller p of both F tests, times their number.

        With many rows, an error that is far smaller than the scatter of a reading would also be
        significant; it does not count.
        """
        tests = [item for item in (self.by_place, self.by_place_and_side) if item is not None]
        found = [item.p for item in tests if item.rms_arcsec > LEAST_REPEATED * item.scatter_arcsec]
        return min(1.0, min(found, default=1.0) * len(tests))

    def p_of(self, change_arcsec: Float, rank: int) -> float:
        """Return p of an effect that repeats at the places, by the F test among the places.

        ``change_arcsec``: change of the prediction of every row by the effect. Every pass repeats
        the errors of the same places, so that the sample consists of places, not of rows. The
        result is 0, so that this test does not count, in three cases. The effect is not a function
        of the place. No repeated error remains with the effect; the scatter of the passes then
        gives its uncertainty. The remaining errors of neighbouring places are similar, and
        therefore not independent.
        """
        used = self.of_row >= 0
        cells = cell_means(self.of_row, change_arcsec, self.place.size)
        if float(np.var(cells)) < RESOLVED * float(np.var(change_arcsec[used])):
            return 0.0
        whole = float(np.sum((cells - cells.mean()) ** 2))
        cells = self.without_curves(cells)
        if float(cells @ cells) < LEAST_OWN * whole:
            # The curves of the passes contain the effect, for example a constant of each direction.
            return 0.0
        count = np.bincount(self.place).astype(np.float64)
        shape = np.bincount(self.place, cells) / count
        square = float(count @ shape**2)
        if square <= 0.0 or square < OF_THE_PLACE * float(cells @ cells):
            return 0.0
        test = self.by_place
        means = np.bincount(self.place, self.left) / count
        taken = float(count @ (means * shape)) ** 2 / square
        free = test.between_freedom - rank
        left = max(float(count @ means**2) - taken, 1e-300)
        if free < 1.0 or test.upper_p(left / free, free) >= FAMILY_WISE:
            return 0.0
        if _neighbours_agree(means - shape * float(count @ (means * shape)) / square):
            return 0.0
        return float(fdtrc(rank, test.effective(free), taken / rank * free / left))

    def repeated(self) -> RepeatedError | None:
        """Return the error that repeats at the places; None if it is not sure or far smaller than
        the scatter of a reading."""
        test = self.by_place
        if test.p >= SURE_P or test.rms_arcsec <= LEAST_REPEATED * test.scatter_arcsec:
            return None
        found, sizes, sigma = self._single_places
        step, spot = self._step, None
        if step is not None:
            uncertainty = float(np.sqrt(test.within / step.information))
            spot = Spot(float(np.degrees(step.angle_rad)), step.size, uncertainty, 0.0)
        return RepeatedError(
            test.rms_arcsec,
            self.visits_of_a_place,
            self.angle_rad.size,
            () if spot is not None else self._merged(found, sizes, sigma),
            self.stations,
            test.rms_arcsec**2 / max(self.mean_square, 1e-300),
            self.over_travel,
            spot,
        )

    @cached_property
    def system(self) -> tuple[Float, Float, Float]:
        """Normal matrix and moment of the errors of the places, with the curves of the passes
        projected out, and the passes of each place."""
        places = self.angle_rad.size
        normal = np.zeros((places, places))
        for inside, basis in self.bases:
            at = self.place[inside]
            normal[at, at] += 1.0
            normal[np.ix_(at, at)] -= basis @ basis.T
        count = np.bincount(self.place).astype(np.float64)
        return normal, np.asarray(np.bincount(self.place, self.left)), count

    @cached_property
    def _step(self) -> StepOfAngle | None:
        """The step of the error at one angle of the turn, if it explains the repeated error much
        better than single places do; None also where the curves of the passes contain no order."""
        if self.crossed is None or self.over_travel:
            return None
        if min(basis.shape[1] for _, basis in self.bases) < LEAST_CURVE:
            return None
        test, (normal, moment, _) = self.by_place, self.system
        step = best_step(
            self.angle_rad, self.crossed, normal, moment, within_a_place=not self.stations
        )
        if step is None:
            return None
        t_value = float(np.sqrt(step.gain / test.within))
        if test.upper_p_of_size(t_value) > FAMILY_WISE / step.tried:
            return None
        if self._much_is_left(step.gain, 1):
            return None
        rest = best_step(
            self.angle_rad,
            self.crossed,
            normal,
            moment - normal @ step.error,
            within_a_place=not self.stations,
        )
        if rest is not None:
            # If a second step is significant, a part of the turn has another level: this is not a
            # single step.
            t_rest = float(np.sqrt(rest.gain / test.within))
            if test.upper_p_of_size(t_rest) < FAMILY_WISE / rest.tried:
                return None
        found, sizes, _ = self._single_places
        of_one = 2.0 * float(np.log(step.tried))
        ahead = (step.gain - float(sizes @ moment[found])) / test.within
        return step if ahead + (found.size - 1) * of_one > STEP_AHEAD else None

    def _much_is_left(self, explained: float, parameters: int) -> bool:
        """Tell whether a large and significant part of the repeated error remains."""
        test, (_, moment, count) = self.by_place, self.system
        before = float(np.sum(moment**2 / count))
        free_left = max(test.between_freedom - parameters, 1.0)
        left = max(before - explained, 0.0) / free_left
        excess = before - test.between_freedom * test.within
        return test.upper_p(left, free_left) < SURE_P and explained < NEARLY_ALL * excess

    @property
    def of_single_places(self) -> Float:
        """Error of the single places, or of the step, in every row of the reference."""
        found, sizes, _ = self._single_places
        error = np.zeros(self.angle_rad.size)
        error[found] = sizes
        if self._step is not None:
            error = self._step.error
        return np.where(self.of_row >= 0, error[self.place[self.of_row]], 0.0)

    @property
    def of_all_places(self) -> Float:
        """Mean error of the place in every row of the reference; 0 in rows that no second pass
        repeats."""
        error = np.bincount(self.place, self.left) / np.bincount(self.place)
        return np.where(self.of_row >= 0, error[self.place[self.of_row]], 0.0)

    @cached_property
    def _single_places(self) -> tuple[Integer, Float, Float]:
        """Return the numbers of the single places that cause the repeated error, their errors and
        the uncertainties of these errors; empty arrays if a large repeated error remains.

        One place after the other is chosen, the largest first; the errors are fitted together.
        """
        test, places = self.by_place, self.angle_rad.size
        none = np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0)
        normal, moment, count = self.system
        found: list[int] = []
        sizes: Float = np.zeros(0)
        inverse: Float = np.zeros((0, 0))
        explained = 0.0
        while len(found) < min(max(places // ONE_IN, 1), MOST_SPOTS):
            rest = moment - normal[:, found] @ sizes
            own = np.diag(normal) - np.sum((normal[:, found] @ inverse) * normal[:, found], axis=1)
            # Where ``own`` is smaller, the curves of the passes explain the error of the place.
            free = own > LEAST_OWN * count
            free[found] = False
            gain = np.where(free, rest**2 / np.where(free, own, 1.0), 0.0)
            best = int(np.argmax(gain))
            t_value = float(np.sqrt(gain[best] / test.within))
            if test.upper_p_of_size(t_value) > FAMILY_WISE / places:
                break
            found.append(best)
            inverse = np.asarray(np.linalg.pinv(normal[np.ix_(found, found)]), dtype=np.float64)
            sizes = inverse @ moment[found]
            explained = float(sizes @ moment[found])
        if self._much_is_left(explained, len(found)):
            return none
        sigma = np.sqrt(np.diag(inverse) * test.within)
        return np.array(found, dtype=np.int64), sizes, sigma

    def _merged(self, found: Integer, sizes: Float, sigma: Float) -> tuple[Spot, ...]:
        """Return single places, with neighbouring places joined to one."""
        if found.size == 0:
            return ()
        order = np.argsort(found)
        found, sizes, sigma = found[order], sizes[order], sigma[order]
        degrees = np.degrees(self.angle_rad)
        spots = []
        for part in np.split(np.arange(found.size), np.flatnonzero(np.diff(found) > 2) + 1):
            top = part[int(np.argmax(np.abs(sizes[part])))]
            width = float(degrees[found[part[-1]]] - degrees[found[part[0]]])
            spots.append(Spot(float(degrees[found[top]]), float(sizes[top]), float(sigma[top]),
                              0.0 if self.stations else width))  # fmt: skip
        return tuple(spots)


def _is_coloured(noise: RowNoise | None) -> bool:
    return noise is not None and any(item.variances.any() for item in noise.spectra)


def _neighbours_agree(values: Float) -> bool:
    """Tell whether successive values differ less than independent ones, by von Neumann's ratio.

    The ratio of independent values has the mean 2 and about the variance 4/n (von Neumann, Ann.
    Math. Statist. 12 (1941) 367).
    """
    ratio = float(np.sum(np.diff(values) ** 2)) / max(float(np.sum(values**2)), 1e-300)
    return float(ndtr(0.5 * (ratio - 2.0) * np.sqrt(values.size))) < FAMILY_WISE


def cell_means(of_row: Integer, values: Float, cells: int) -> Float:
    """Return the mean of the values of each cell's rows; 0 for a cell without rows."""
    kept = of_row >= 0
    count = np.bincount(of_row[kept], minlength=cells)
    return np.bincount(of_row[kept], values[kept], cells) / np.maximum(count, 1)
