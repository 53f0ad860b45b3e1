"""Provides ``arctrue.fit`` and its result: parameters with intervals, prediction, residuals,
report."""

from __future__ import annotations

import html
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.api.conditions import Tied, Wanted, wanted_of, with_places
from arctrue.api.model import Model, ModelLike, model_of
from arctrue.api.pictures import Pictures, html_table
from arctrue.api.results import comparison_pictures
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.base.figures import figure, probability, unit_for_people, with_uncertainty
from arctrue.base.similar import did_you_mean
from arctrue.calibration.head_separation import doubts_of
from arctrue.workbench.compare.comparison import compare as _compare
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.constrained import ConstrainedFit, constrained_fit
from arctrue.workbench.inference.directions import (
    MOST_UNDETERMINED,
    Directions,
    directions_of,
    undetermined_parameters,
)
from arctrue.workbench.inference.left import Left, left_by
from arctrue.workbench.inference.model_ratio import ModelRatio, model_ratio
from arctrue.workbench.inference.profile import Profile, slopes_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import fitted, step_of, stored_entries
from arctrue.workbench.model.predicted import prediction_columns
from arctrue.workbench.model.stations import warnings_of_the_arc

Float = NDArray[np.float64]
State = Literal["free", "fixed", "at_bound", "undetermined"]
AT_BOUND = 1e-5
"""Largest ratio of a parameter's standard uncertainties with and without conditions at which the
conditions alone determine the parameter. Rounding leaves a ratio of 1e-8, the square root of the
relative rounding error of a variance."""
SAID: Mapping[State, str] = {
    "free": "",
    "fixed": " (fixed)",
    "at_bound": " (at a bound)",
    "undetermined": " (not determined)",
}
"""Remark after a parameter's value."""
MOST_NAMED = 3
"""Largest number of parameters that a warning names."""


@dataclass
class _Profiles:
    """The likelihood along each parameter of a fit, computed when it is needed."""

    fit: ConstrainedFit
    limits: Mapping[str, tuple[float, float]]
    _found: dict[str, Profile] = field(default_factory=dict)

    def of(self, parameter: FitParameter) -> Profile:
        """Return the likelihood along a parameter; its own bounds limit the profile's range."""
        name = parameter.name
        if name not in self._found:
            own = [one for one in self.fit.conditions if one.equation or one.names != (name,)]
            low, high = self.limits.get(name, (-np.inf, np.inf))
            if parameter.unit == "deg" and name.endswith("phase") and np.isfinite(high - low):
                turns = round((0.5 * (low + high) - parameter.value) / 360.0)
                low, high = low - 360.0 * turns, high - 360.0 * turns
            fit = replace(
                self.fit,
                conditions=tuple(own),
                covariance=self.fit.covariance_of_equations
                if parameter.state == "at_bound"
                else self.fit.covariance,
            )
            self._found[name] = Profile(fit, name, (low, high))
        return self._found[name]


@dataclass(frozen=True, eq=False)
class FitParameter:
    """A parameter of a fit.

    Parameters
    ----------
    name : str
        Effect and parameter: ``thermal_eccentricity.amplitude``.
    value : float
        Maximum-likelihood estimate, in ``unit``.
    stderr : float
        Standard uncertainty of the linearised fit; 0 for a fixed parameter. NaN for a parameter
        that the data do not determine, and for a parameter at a bound, because the linearised fit
        is not valid beyond the bound.
    unit : str
        Unit of value and stderr, such as ``arcsec/K``.
    state : {"free", "fixed", "at_bound", "undetermined"}
        ``fixed``: ``fix`` or a tie to fixed parameters states the value. ``at_bound``: the value is
        that of a bound. ``undetermined``: other values, together with other values of further
        parameters, fit the rows equally well.
    """

    name: str
    value: float
    stderr: float
    unit: str
    state: State
    _profiles: _Profiles = field(repr=False)

    def interval(self, level: float = 0.95) -> tuple[float, float]:
        """Compute a confidence interval by profile likelihood.

        At each value of this parameter, all other parameters and the noise take the values of
        maximum likelihood. The interval is wider than ``value ± 1.96·stderr`` if slow noise could
        explain part of the parameter's effect, for instance part of a drift. The interval is
        asymmetric if the likelihood is asymmetric.

        Parameters
        ----------
        level : float, optional
            Probability with which such intervals contain the true value.

        Returns
        -------
        low, high : float
            The ends, in ``unit``; infinite where the data do not bound the parameter. The interval
            ends at the bounds of the fit.

        Raises
        ------
        ValueError
            ``level`` is not between 0 and 1.
        """
        if not 0.0 < level < 1.0:
            raise ValueError(f"level: expected a number between 0 and 1, found {level:g}")
        if self.state == "fixed" or self.stderr == 0.0:
            return self.value, self.value
        profile = self._profiles.of(self)
        return profile.unbounded() if self.state == "undetermined" else profile.interval(level)

    def __str__(self) -> str:
        """Return value ± uncertainty with the unit, as the commands write it."""
        return with_uncertainty(self.value, self.stderr, self.unit) + SAID[self.state]


class FitParameters(Mapping[str, FitParameter]):
    """Parameters of a fit by name, in the order of the model."""

    def __init__(self, parameters: Mapping[str, FitParameter]) -> None:
        """Store the ``parameters`` by name."""
        self._parameters = dict(parameters)

    def __getitem__(self, name: str) -> FitParameter:
        """Return the parameter ``name``; raises KeyError, which lists similar names, for an unknown
        name."""
        if name not in self._parameters:
            raise KeyError(
                f"no parameter {name!r}.{did_you_mean(name, self._parameters)} There are: "
                f"{', '.join(self._parameters)}"
            )
        return self._parameters[name]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names."""
        return iter(self._parameters)

    def __len__(self) -> int:
        """Return the number of parameters."""
        return len(self._parameters)

    def __repr__(self) -> str:
        """Return a line for each parameter."""
        return "\n".join(f"{name}: {item}" for name, item in self.items())

    def valuesdict(self) -> dict[str, float]:
        """Return the values of all parameters as a dictionary.

        Returns
        -------
        dict of str to float
            The value of each parameter, by name.
        """
        return {name: item.value for name, item in self.items()}

    def _repr_html_(self) -> str:
        rows = [
            (name, figure_of(item), unit_for_people(item.unit).strip())
            for name, item in self.items()
        ]
        return html_table(("parameter", "value ± standard uncertainty", "unit"), rows)


def figure_of(parameter: FitParameter) -> str:
    """Return value ± uncertainty without the unit."""
    said = with_uncertainty(parameter.value, parameter.stderr, "1")
    return said + SAID[parameter.state]


class Correlations(Mapping[tuple[str, str], float]):
    """Correlations of pairs of parameters by both names; they cannot be changed."""

    def __init__(self, pairs: Mapping[tuple[str, str], float]) -> None:
        """Store the correlations by pair."""
        self._pairs = dict(pairs)

    def __getitem__(self, pair: tuple[str, str]) -> float:
        """Return the correlation of a pair."""
        return self._pairs[pair]

    def __iter__(self) -> Iterator[tuple[str, str]]:
        """Iterate over the pairs."""
        return iter(self._pairs)

    def __len__(self) -> int:
        """Return the number of pairs, each counted in both orders."""
        return len(self._pairs)

    def __repr__(self) -> str:
        """Return the correlations as a dictionary's text."""
        return repr(self._pairs)


@dataclass(frozen=True, eq=False)
class FitResult:
    """A model fitted to a set.

    Parameters
    ----------
    model : Model
        The model with the fitted values; its history has this fit as a step, with date, program and
        hash.
    params : FitParameters
        Every parameter by name, each with ``value``, ``stderr``, ``unit``, ``interval(level)``.
    solution : Solution
        The same results as objects of the workbench.
    warnings : tuple of str
        Remarks on the set and the fit for the user, one sentence each.
    """

    model: Model
    params: FitParameters
    solution: Solution = field(repr=False)
    warnings: tuple[str, ...]
    _constrained: ConstrainedFit = field(repr=False)
    _directions: Directions = field(repr=False)

    @property
    def nobs(self) -> int:
        """Number of fitted rows of both channels together."""
        return self.solution.rows

    @property
    def nfree(self) -> int:
        """Number of rows minus the number of parameter combinations that the data determine, at
        least 0. The stated scatter of the index determines a few combinations without any row, so
        the difference could be negative."""
        return max(self.nobs - self.solution.rank, 0)

    @property
    def log_likelihood(self) -> float:
        """Logarithm of the likelihood, with the noise parameters that maximise it; without the
        term −n/2·log 2π of n rows."""
        return self.solution.log_likelihood

    @property
    def bic(self) -> float:
        """Bayesian information criterion: of two models fitted to the same set, the model with the
        smaller value is better."""
        return self.solution.bic

    @property
    def aic(self) -> float:
        """Akaike's information criterion: of two models fitted to the same set, the model with the
        smaller value is better."""
        parameters = self.solution.rank + self.solution.searched
        return 2.0 * (parameters - self.log_likelihood)

    @cached_property
    def covariance(self) -> Float:
        """Covariance of the parameters, shape (parameters, parameters), in their units; read only.

        NaN for a parameter that is not determined or at a bound; 0 for a fixed parameter.
        """
        slopes = slopes_of(self._constrained, list(self.params))
        found = np.asarray(slopes @ self._constrained.covariance @ slopes.T)
        fixed = [item.state == "fixed" for item in self.params.values()]
        found[fixed, :] = 0.0
        found[:, fixed] = 0.0
        unknown = [item.state in ("at_bound", "undetermined") for item in self.params.values()]
        found[unknown, :] = np.nan
        found[:, unknown] = np.nan
        found.setflags(write=False)
        return found

    @cached_property
    def correlations(self) -> Mapping[tuple[str, str], float]:
        """Correlation of each pair of parameters, −1 to 1; a key is a pair of names, in either
        order.

        A pair with a parameter that is fixed, at a bound or not determined is left out.
        """
        names, covariance = list(self.params), self.covariance
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return Correlations(
            {
                (one, other): float(covariance[i, j] / (spread[i] * spread[j]))
                for i, one in enumerate(names)
                for j, other in enumerate(names)
                if i != j and spread[i] > 0.0 and spread[j] > 0.0
            }
        )

    @cached_property
    def left(self) -> Left:
        """RMS residual of each channel, on fitted and on held-out rows, and the noise;
        arcseconds."""
        return left_by(self.solution)

    def predict(
        self,
        angle: ArrayLike,
        conditions: Mapping[str, ArrayLike] | None = None,
        *,
        return_std: bool = False,
    ) -> Any:
        """Predict the error of head 1: its reading minus the true angle.

        The prediction excludes errors of the reference, because they are no errors of the table,
        and the constant, because it depends on the place of the zero.

        Parameters
        ----------
        angle : array_like, shape (n,)
            Angle of the table, degrees; it may exceed a turn.
        conditions : mapping of str to array_like, shape (n,) or (), optional
            ``temperature_c`` (°C), ``time_s`` (s), ``direction`` (+1, −1), ``speed_deg_s`` (°/s,
            signed), and the set's own conditions. An astropy quantity is converted to this unit;
            ``angle`` can be such a quantity too.
        return_std : bool, optional
            If True, also return the standard uncertainty.

        Returns
        -------
        error_arcsec : ndarray, shape (n,)
            Predicted error.
        std_arcsec : ndarray, shape (n,)
            Standard uncertainty of the predicted error, from the uncertainties of the parameters;
            where ``return_std`` is True. It is infinite where the rows do not determine the error.

        Raises
        ------
        ValueError
            An effect of the model needs a condition that is not given, or a value is impossible.
        """
        columns = prediction_columns(self.solution, angle, conditions or {})
        total = columns[:, : sum(self.solution.widths)] @ self.solution.coefficients
        if not return_std:
            return total
        variance = np.einsum("ij,jk,ik->i", columns, self._constrained.covariance, columns)
        unknown = self._directions.share(columns) > MOST_UNDETERMINED
        return total, np.where(unknown, np.inf, np.sqrt(np.maximum(variance, 0.0)))

    def residuals(self, *, whitened: bool = False) -> dict[str, Float]:
        """Return the residuals of the model, measured minus fitted.

        Parameters
        ----------
        whitened : bool, optional
            If True, divide the residuals by the noise and remove its correlation, so that they
            should be independent with a standard deviation of 1.

        Returns
        -------
        dict of str to ndarray, shape (rows,)
            Residuals by channel, ``capture`` and ``reference``; arcseconds, or a pure number. For a
            very long set, they contain only the rows that the statistics use.
        """
        solution, found = self.solution, {}
        for name, values, noise in (
            ("capture", solution.capture_residual_arcsec(), solution.noise.capture),
            ("reference", solution.reference_residual_arcsec(), solution.noise.reference),
        ):
            if values is not None:
                scaled = noise.whiten(values) if whitened and noise is not None else values
                found[name] = np.array(scaled)
        return found

    def fit_report(self, *, min_correl: float = 0.5) -> str:
        """Format the fit as text: rows, residual errors, every parameter, correlations, warnings.

        Parameters
        ----------
        min_correl : float, optional
            Correlations of this size or more are listed, the largest first.

        Returns
        -------
        str
            Several lines.
        """
        left = self.left
        lines = [
            f"model: {', '.join(self.model.effects)}",
            f"{self.nobs} rows, {self.solution.rank} parameters determined, "
            f"log likelihood {figure(self.log_likelihood, 2)}, BIC {figure(self.bic, 2)}",
        ]
        lines += [
            f"{channel}: left {figure(rms, 4)}″ RMS, held out "
            f"{figure(left.heldout_rms_arcsec.get(channel), 4)}″, repeats "
            f"{figure(left.noise_arcsec[channel], 4)}″"
            for channel, rms in left.rms_arcsec.items()
        ]
        width = max((len(name) for name in self.params), default=0)
        for name, item in self.params.items():
            lines.append(f"{name.ljust(width)}  {item}")
        pairs = sorted(
            (
                (abs(value), one, other, value)
                for (one, other), value in self.correlations.items()
                if one < other and abs(value) >= min_correl
            ),
            reverse=True,
        )
        lines += [
            f"correlation {one}, {other}: {figure(value, 3, signed=True)}"
            for _, one, other, value in pairs
        ]
        lines += [f"warning: {text}" for text in self.warnings]
        return "\n".join(lines)

    def plot(self) -> Pictures:
        """Draw the residual over the angle, by run and by direction, and over the conditions.

        Returns
        -------
        Pictures
            The same pictures as :func:`arctrue.compare` draws.

        Raises
        ------
        MissingExtraError
            matplotlib is not installed.
        """
        return comparison_pictures(self.solution, _compare(self.solution, 1))

    def _repr_html_(self) -> str:
        warned = "".join(f"<p>Warning: {html.escape(text)}</p>" for text in self.warnings)
        return (
            f"<p>Model: {html.escape(', '.join(self.model.effects))}</p>"
            + self.params._repr_html_()
            + warned
        )


@dataclass(frozen=True, eq=False)
class ModelTest:
    """Comparison of two models of one set.

    Parameters
    ----------
    bic_difference : float
        BIC of the first model minus BIC of the second model: above 0 the second model is better,
        above 10 it is much better.
    ratio : ModelRatio or None
        Likelihood ratio, difference between the numbers of parameters, and p value; None if neither
        model contains the other.
    held_out_fall_arcsec : dict of str to (float, float)
        Decrease of the error on held-out rows from the first model to the second, by channel, and
        its standard error.
    """

    bic_difference: float
    ratio: ModelRatio | None
    held_out_fall_arcsec: dict[str, tuple[float, float]]

    def __str__(self) -> str:
        """Return one line of text for each comparison."""
        lines = [
            f"BIC of the first model minus that of the second: {figure(self.bic_difference, 2)}"
        ]
        if self.ratio is not None:
            lines.append(
                f"likelihood ratio {figure(self.ratio.gain, 2)} with {self.ratio.parameters} "
                f"parameters, p {probability(self.ratio.p_value)}"
            )
        lines += [
            f"{channel}: held-out error falls by {with_uncertainty(fall, error, 'arcsec')}"
            for channel, (fall, error) in self.held_out_fall_arcsec.items()
        ]
        return "\n".join(lines)

    def _repr_html_(self) -> str:
        return "".join(f"<p>{html.escape(line)}</p>" for line in str(self).splitlines())


def fit(
    measurement: SetOrFolder,
    model: ModelLike = None,
    *,
    fix: Mapping[str, float] | Iterable[str] | None = None,
    bounds: Mapping[str, tuple[float | None, float | None]] | None = None,
    tie: Mapping[str, Tied] | None = None,
) -> FitResult:
    """Fit a model to a set by generalised least squares, and estimate its noise.

    Parameters
    ----------
    measurement : MeasurementSet, Path or str
        The set, or the name of its folder.
    model : Model, Path, str or iterable of str, optional
        The model, its file, or names of effects to add to the paper's model, which is the default.
    fix : mapping of str to float, or iterable of str, optional
        Parameters that keep a value: ``{"hysteresis.reversal_error": 0.5}``; names alone
        keep the value that the model has from an earlier fit.
    bounds : mapping of str to (low, high), optional
        Limits of a parameter, None on an open side. Limits of a phase hold up to whole turns.
    tie : mapping of str to str, (str, float) or callable, optional
        What a parameter equals: another parameter, a multiple of another parameter
        ``("other.name", 2.0)``, or the result of a function of a mapping of all values.

    Returns
    -------
    FitResult
        Parameters, correlations, prediction, residuals.

    Raises
    ------
    ValueError
        A parameter is not known, a value is impossible, or no values meet the conditions.
    NotTestableError
        The set lacks data that an effect of the model needs.
    MeasurementError
        The folder cannot be read.

    Examples
    --------
    >>> import numpy as np
    >>> import arctrue as at
    >>> angle = np.tile(np.arange(24) * 15.0, 4)
    >>> error = 2.0 * np.cos(np.deg2rad(angle)) + 0.01 * np.sin(np.arange(96))
    >>> data = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})
    >>> found = at.fit(data, at.Model().having(graduation_harmonics={"orders": [1]}))
    >>> round(found.params["graduation_harmonics.order_1_amplitude"].value, 2)
    2.0
    """
    start, data = model_of(model), set_of(measurement)
    observations, known = start.observations(data), start.known()
    content, solution = fitted(start.content, observations, known)
    wanted = wanted_of(start, solution, fix, bounds, tie)
    if wanted.places:
        solution = with_places(solution, wanted.places)
    before, found = solution, constrained_fit(solution, wanted.conditions)
    if wanted.conditions or wanted.places:
        solution = found.solution
        content = replace(content, effects=stored_entries(content.effects, solution))
    step = step_of("fit", ", ".join(content.names()), data.label, solution)
    grown = start.grown(replace(content, history=[*start.content.history, step]), data)
    directions = directions_of(solution, equations=found.equations)
    params = _parameters(before, found, wanted, undetermined_parameters(solution, directions))
    lost = [name for name, item in params.items() if item.state == "undetermined"]
    of_arc = warnings_of_the_arc(start.content, observations)
    warnings = (*data.warnings, *doubts_of(data), *of_arc, *not_determined(lost))
    return FitResult(grown, params, solution, warnings, found, directions)


def not_determined(names: Sequence[str]) -> list[str]:
    """Return a warning about parameters that a set does not determine; none without such names."""
    if not names:
        return []
    which = ", ".join(names[:MOST_NAMED])
    if len(names) > MOST_NAMED:
        which = f"{which} and {len(names) - MOST_NAMED} more"
    return [
        f"the set does not determine {which}: other values fit its rows equally well; fit fewer "
        "orders or effects, or measure at further angles or conditions"
    ]


def _parameters(
    before: Solution, found: ConstrainedFit, wanted: Wanted, lost: Sequence[str]
) -> FitParameters:
    """Return the parameters of a fit; ``before``: the fit without conditions; ``lost``: names of
    the parameters that the rows do not determine."""
    solution, conditions = found.solution, found.conditions
    profiles = _Profiles(found, wanted.limits)
    under = solution.named_parameters(found.covariance if conditions else None)
    unbound = solution.named_parameters(found.covariance_of_equations) if conditions else under
    free = before.named_parameters()
    has_equations, parameters = bool(found.is_equation.any()), {}
    for name, item in under.items():
        state: State = "free"
        if name in wanted.fixed or (has_equations and _is_kept(unbound[name], free[name])):
            state = "fixed"
        elif name in lost:
            state = "undetermined"
        elif not found.is_equation.all() and _is_kept(item, unbound[name]):
            state = "at_bound"
        stderr = {"free": item.sigma, "fixed": 0.0}.get(state, float("nan"))
        parameters[name] = FitParameter(name, item.value, stderr, item.unit, state, profiles)
    return FitParameters(parameters)


def _is_kept(under: Parameter, without: Parameter) -> bool:
    """Tell whether the conditions alone determine a parameter, from its standard uncertainties with
    and without them."""
    return without.sigma > 0.0 and under.sigma <= AT_BOUND * without.sigma


def compare_models(one: FitResult, other: FitResult) -> ModelTest:
    """Compare two fits of the same set, and find which model the data prefer.

    Parameters
    ----------
    one : FitResult
        Fit of the first, usually the smaller model.
    other : FitResult
        Fit of the second model.

    Returns
    -------
    ModelTest
        Difference of BIC; likelihood ratio with p if one model contains the other; error on
        held-out rows.

    Raises
    ------
    ValueError
        The two fits use different rows.
    """
    first, second = one.solution, other.solution
    for channel in ("capture", "reference"):
        mine, theirs = getattr(first.observations, channel), getattr(second.observations, channel)
        if (mine is None) != (theirs is None) or (
            mine is not None and not np.array_equal(mine.measured_arcsec, theirs.measured_arcsec)
        ):
            raise ValueError(
                f"the two fits use different rows of the {channel}: fit both models to one set"
            )
    falls = other.left.fall_from(one.left)
    return ModelTest(
        first.bic - second.bic,
        model_ratio(first, second),
        {name: (fall.fall_arcsec, fall.standard_error_arcsec) for name, fall in falls.items()},
    )
