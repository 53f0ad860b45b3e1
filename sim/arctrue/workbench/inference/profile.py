"""Calculates intervals by profile likelihood: the values of a parameter that the data do not
contradict.

At each value of the parameter, all other parameters and the noise have their most likely values.
Such an interval is also right in two cases where the standard uncertainty of a linearised fit is
wrong: a drift that slow noise has partly absorbed, and the frequency of a line with few periods (a
nonlinear parameter). The limit of the likelihood ratio follows from Student's t with the degrees of
freedom of the noise variance. It is exact for a linear parameter in white noise (Bates and Watts,
Nonlinear Regression Analysis and Its Applications, chapter 6).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import brentq
from scipy.special import ndtri

from arctrue.workbench.effects.parameter import kind_of, phases_among
from arctrue.workbench.inference.constrained import (
    Condition,
    ConditionError,
    ConstrainedFit,
    conditioned,
    noise_with,
    restricted_likelihood_of,
)
from arctrue.workbench.inference.design_matrix import channel_prediction, channel_sums
from arctrue.workbench.inference.named import labels, parameters_of, values_of
from arctrue.workbench.inference.significance import MANY
from arctrue.workbench.inference.solution import Solution, joint_normal
from arctrue.workbench.inference.tangents import tangent_terms
from arctrue.workbench.noise.degrees_of_freedom import degrees_of_freedom
from arctrue.workbench.noise.noise import Noise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.numeric.distributions import student_quantile
from arctrue.workbench.numeric.least_squares import Layout
from arctrue.workbench.numeric.symmetric import solve_symmetric

Float = NDArray[np.float64]

NOISE_ROUNDS = 2
"""Number of rounds at each value and from each start; a round estimates the noise and fits the
model. The starts are the fitted noise, this noise with a random walk, and the noise at the nearest
value.
"""
FARTHEST = 40.0
"""If the interval reaches farther than this from the fitted value, in standard uncertainties, its
end counts as infinite."""
WIDER = 1.6
"""Factor by which each step outwards increases the distance from the fitted value, until the
likelihood has fallen far enough."""
PRECISION = 0.01
"""Accuracy of the ends of the interval, in standard uncertainties."""
HALF_TURN_DEG = 180.0
"""Half a turn, in degrees: a phase is known only up to whole turns."""
SLOW = 0.02
"""Smallest time constant of noise that may be a random walk, as a share of the longest time
constant."""
WALK_SPANS = 10.0
"""Factor by which the longest time constant, the length of the record, is multiplied; the noise is
then a random walk within the record."""
LITTLE = 1e-2
"""Share of its variance that each slow part keeps. The part with the longest time constant gets the
variance at which the steps from row to row stay the same."""


def limit_of(level: float, freedom: float) -> float:
    """Return the fall of twice the log likelihood at the ends of an interval of this level.

    In white noise with m degrees of freedom, a deviation of t standard uncertainties lowers twice
    the log likelihood by

    (m + 1)·log(1 + t²/m).
    """
    if freedom > MANY:
        return float(ndtri(0.5 + 0.5 * level) ** 2)
    deviation = student_quantile(0.5 + 0.5 * level, freedom)
    return (freedom + 1.0) * float(np.log1p(deviation**2 / freedom))


@dataclass
class Profile:
    """The likelihood along one parameter of a fit.

    ``limits``: bounds of the parameter, of a phase up to whole turns; ``fit.conditions`` does not
    contain them.
    """

    fit: ConstrainedFit
    name: str
    limits: tuple[float, float] = (-np.inf, np.inf)
    _best: float = field(init=False, default=0.0)
    _highest: float = field(init=False, default=-np.inf)
    _found: dict[float, float] = field(init=False, default_factory=dict)
    _noise: list[tuple[float, Noise]] = field(init=False, default_factory=list)
    _free: Float | None = field(init=False, default=None)

    def __post_init__(self) -> None:
        """Find the parameter. Raises ValueError for an unknown name."""
        parameters = self.fit.solution.named_parameters(self.fit.covariance)
        if self.name not in parameters:
            raise ValueError(f"no parameter {self.name}; there are: {', '.join(parameters)}")
        self._parameter = parameters[self.name]
        self._best = self._parameter.value
        low, high = self.limits
        if self._is_phase and np.isfinite(high - low):
            turns = round((0.5 * (low + high) - self._best) / 360.0)
            self.limits = (low - 360.0 * turns, high - 360.0 * turns)

    @property
    def _is_phase(self) -> bool:
        return kind_of(self.name, self._parameter) == "phase"

    def _condition(self, value: float) -> Condition:
        def difference(parameters: dict[str, float]) -> float:
            off = parameters[self.name] - value
            return float(np.remainder(off + 180.0, 360.0) - 180.0) if self._is_phase else off

        return Condition((self.name,), difference)  # type: ignore[arg-type]

    def likelihood(self, value: float) -> float:
        """Return the restricted log likelihood with the parameter at ``value`` and the noise and
        all other parameters free; the highest result if this value was searched before."""
        fitted = self.fit.solution.noise
        starts = [fitted, _as_a_walk(fitted)]
        if self._noise:
            starts.append(min(self._noise, key=lambda item: abs(item[0] - value))[1])
        conditions = (*self.fit.conditions, self._condition(value))
        tried = [self._fixed_terms(conditions, start) for start in starts]
        likelihood, noise = max(tried, key=lambda item: item[0])
        self._noise.append((value, noise))
        self._found[value] = max(self._found.get(value, -np.inf), likelihood)
        self._highest = max(self._highest, likelihood)
        return self._found[value]

    def _fixed_terms(self, conditions: Sequence[Condition], start: Noise) -> tuple[float, Noise]:
        """Return the likelihood under these conditions, and the noise with which it was calculated;
        the search for the noise begins at ``start``."""
        found = conditioned(replace(self.fit.solution, noise=start), conditions)
        if self._free is None:
            # All values use the same restricted likelihood (the same free directions), so that they
            # can be compared.
            self._free = found.free
        for _ in range(NOISE_ROUNDS):
            noise = noise_with(found, self._free)
            found = conditioned(replace(found.solution, noise=noise), conditions)
        return restricted_likelihood_of(found, self._free), found.solution.noise

    def fall(self, value: float) -> float:
        """Return twice the fall of the log likelihood from its highest value.

        Each value is searched only once, so that its fall does not change: a second search at the
        same value begins at the noise of a nearer value and may find a higher likelihood.
        """
        for wanted in (self._best, value):
            if wanted not in self._found:
                self.likelihood(wanted)
        return 2.0 * (self._highest - self._found[value])

    def interval(self, level: float) -> tuple[float, float]:
        """Return the lower and the upper end; an end is infinite where the data do not bound the
        parameter."""
        if not 0.0 < level < 1.0:
            raise ValueError(f"level: expected a number between 0 and 1, found {level:g}")
        limit = limit_of(level, freedom_of(self.fit, self.name))
        return self._end(-1.0, limit), self._end(1.0, limit)

    def unbounded(self) -> tuple[float, float]:
        """Return the interval of a parameter that the data do not determine: its whole range."""
        if self._is_phase:
            return self._best - HALF_TURN_DEG, self._best + HALF_TURN_DEG
        return self._range()

    def _end(self, way: float, limit: float) -> float:
        sigma = self._parameter.sigma
        if not (np.isfinite(sigma) and sigma > 0.0):
            return self.unbounded()[0 if way < 0.0 else 1]
        farthest = FARTHEST * sigma
        if self._is_phase:
            farthest = HALF_TURN_DEG
        low, high = self._range()
        farthest = max(min(farthest, self._best - low if way < 0.0 else high - self._best), 0.0)
        inside, step = 0.0, float(np.sqrt(limit)) * sigma
        outside = min(step, farthest)
        while (fall := self._fall_or_end(self._best + way * outside)) < limit:
            if outside >= farthest:
                return self._limit_reached(way, farthest)
            inside, outside = outside, min(WIDER * outside, farthest)
        if not np.isfinite(fall):
            return self._best + way * self._last_possible(way, inside, outside, limit)
        # The fitted value is searched again, now from the noise of the nearest value; this may
        # raise the highest likelihood.
        self.likelihood(self._best)
        if self._fall_or_end(self._best + way * inside) >= limit:
            inside, outside = 0.0, inside
        if self.fall(self._best) >= limit:
            return self._best
        return (
            float(
                brentq(
                    lambda off: self._fall_or_end(self._best + way * off) - limit,
                    inside,
                    outside,
                    xtol=PRECISION * sigma,
                    maxiter=30,
                )
            )
            * way
            + self._best
        )

    def _last_possible(self, way: float, inside: float, outside: float, limit: float) -> float:
        """Return the distance at which the likelihood has fallen by ``limit``, or the largest
        distance at which values meet the conditions, whichever is smaller."""
        while outside - inside > PRECISION * self._parameter.sigma:
            middle = 0.5 * (inside + outside)
            if self._fall_or_end(self._best + way * middle) < limit:
                inside = middle
            else:
                outside = middle
        return inside

    def _fall_or_end(self, value: float) -> float:
        try:
            return self.fall(value)
        except ConditionError:
            return np.inf

    def _range(self) -> tuple[float, float]:
        """Return the range of possible values of the parameter.

        An amplitude is not negative; a search parameter stays in its declared range; every
        parameter stays within its bounds.
        """
        low, high = self._possible()
        return max(low, self.limits[0]), min(high, self.limits[1])

    def _possible(self) -> tuple[float, float]:
        label, _, own = self.name.rpartition(".")
        solution = self.fit.solution
        term = solution.terms[labels(solution.terms).index(label)]
        if any(item.name == own for item in term.effect.search):
            return term.effect.search_range(own)
        is_amplitude = kind_of(self.name, self._parameter) == "amplitude"
        return (0.0 if is_amplitude else -np.inf), np.inf

    def _limit_reached(self, way: float, farthest: float) -> float:
        low, high = self._range()
        end = self._best + way * farthest
        if self._is_phase:
            return end
        near = 1e-9 * self._parameter.sigma
        if way < 0.0 and end <= low + near:
            return low
        if way > 0.0 and end >= high - near:
            return high
        return way * np.inf


def _as_a_walk(noise: Noise) -> Noise:
    """Return noise with the same steps from row to row, in which the slow parts are a random walk.

    The steps hardly distinguish a random walk from slow noise, but a random walk can hide a drift.
    The search for the likeliest noise does not lead from slow noise to a random walk, so that both
    are tried.
    """
    laws = [
        None if law is None else replace(law, spectra=tuple(map(_slowest, law.spectra)))
        for law in (noise.capture_law, noise.reference_law)
    ]
    return replace(noise, capture_law=laws[0], reference_law=laws[1])


def _slowest(spectrum: Spectrum) -> Spectrum:
    constants, variances = spectrum.constants, spectrum.variances
    if not constants.size:
        return spectrum
    slow = constants > SLOW * constants[-1]
    rate = float(np.sum(variances[slow] / constants[slow]))
    moved, longer = np.where(slow, LITTLE * variances, variances), constants.copy()
    longer[-1] *= WALK_SPANS
    moved[-1] = rate * longer[-1]
    return replace(spectrum, constants=longer, variances=moved)


def freedom_of(fit: ConstrainedFit, name: str) -> float:
    """Return the degrees of freedom of the noise variance in a parameter (Satterthwaite).

    The parameter is linearised as aᵀ·b: b contains the coefficients and search parameters, a the
    slopes of the parameter with respect to them.
    """
    solution = fit.solution
    observations, noise = solution.observations, solution.noise
    terms = tangent_terms(solution)
    widths = [len(term.effect.column_names(observations)) for term in terms]
    layout = Layout(sum(widths), observations.runs)
    sums = {
        channel: channel_sums(
            terms, observations, solution.context, noise, capture=channel == "capture"
        )
        for channel in ("capture", "reference")
    }
    normal, _ = joint_normal(layout, noise, sums["capture"], sums["reference"])
    slope = np.zeros(layout.size)
    slope[: layout.shared] = slope_of(fit, name)
    _, inverse, _, _ = solve_symmetric(normal, np.zeros(layout.size))
    direction = inverse @ slope
    offsets = direction[layout.shared : layout.shared + layout.runs]
    weights: list[Float | None] = []
    for channel, of_rows in (("capture", noise.capture), ("reference", noise.reference)):
        if of_rows is None:
            weights.append(None)
            continue
        moved = channel_prediction(
            terms, direction[: layout.shared], observations, solution.context,
            capture=channel == "capture",
        )  # fmt: skip
        if channel == "capture":
            assert observations.capture is not None
            moved = moved + observations.capture.offsets_of_rows(offsets)
        else:
            moved = moved + direction[-1]
        weights.append(of_rows.precise(of_rows.whiten(moved)))
    runs = {
        channel: rows.run
        for channel, rows in (
            ("capture", observations.capture),
            ("reference", observations.reference),
        )
        if rows is not None
    }
    return degrees_of_freedom(noise, (weights[0], weights[1]), offsets, runs)[0]


def slope_of(fit: ConstrainedFit, name: str) -> Float:
    """Return ∂(parameter)/∂(coefficients, then search parameters), by central differences."""
    return np.asarray(slopes_of(fit, [name])[0])


def slopes_of(fit: ConstrainedFit, names: Sequence[str]) -> Float:
    """Return the slopes of several parameters with respect to all unknowns, shape (parameters,
    unknowns)."""
    solution = fit.solution
    spread = np.sqrt(np.maximum(np.diag(fit.covariance), 0.0))
    shared = sum(solution.widths)
    phases = phases_among(
        parameters_of(solution.terms, solution.widths, solution.coefficients, solution.observations)
    )
    found = np.zeros((len(names), spread.size))
    for place in range(spread.size):
        width = 1e-4 * spread[place]
        if width <= 0.0:
            continue
        sides = [_at(solution, place, shared, sign * width) for sign in (1.0, -1.0)]
        for number, name in enumerate(names):
            rise = sides[0][name] - sides[1][name]
            if name in phases:
                rise = float(np.remainder(rise + HALF_TURN_DEG, 360.0) - HALF_TURN_DEG)
            found[number, place] = rise / (2.0 * width)
    return found


def _at(solution: Solution, place: int, shared: int, off: float) -> dict[str, float]:
    """Return every parameter after one unknown has been changed by ``off``."""
    coefficients, terms = solution.coefficients, list(solution.terms)
    if place < shared:
        coefficients = coefficients.copy()
        coefficients[place] += off
    else:
        number = shared
        for index, term in enumerate(terms):
            for name in [item.name for item in term.effect.search if not item.integer]:
                if number == place:
                    moved = {**term.nonlinear, name: term.nonlinear[name] + off}
                    terms[index] = replace(term, nonlinear=moved)
                number += 1
    return values_of(terms, solution.widths, coefficients, solution.observations)
