"""Provides ``arctrue.fit`` and its result: parameters with intervals, prediction, residuals,
report."""

from __future__ import annotations

import html
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.api.model import Model, ModelLike, model_of
from arctrue.api.pictures import Pictures, html_table
from arctrue.api.results import comparison_pictures
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.base.figures import figure, probability, unit_for_people, with_uncertainty
from arctrue.base.similar import did_you_mean
from arctrue.workbench.compare.comparison import compare as _compare
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.constrained import (
    Condition,
    ConstrainedFit,
    constrained_fit,
)
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit as fit_terms
from arctrue.workbench.inference.left import Left, left_by
from arctrue.workbench.inference.model_ratio import ModelRatio, model_ratio
from arctrue.workbench.inference.named import labels, named_parameters, values_of
from arctrue.workbench.inference.profile import Profile, slopes_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import fitted, step_of, stored_entries
from arctrue.workbench.model.predicted import table_rows, term_values

Float = NDArray[np.float64]
Tied = str | tuple[str, float] | Callable[[Mapping[str, float]], float]
"""Value of a tied parameter: a parameter's name, (name, factor), or a function of all values."""


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
        Standard uncertainty of the linearised fit; 0 if fixed, NaN if the data do not determine it.
    unit : str
        Unit of value and stderr, such as ``arcsec/K``.
    """

    name: str
    value: float
    stderr: float
    unit: str
    _profile: Callable[[], Profile] = field(repr=False)

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
            The ends, in ``unit``; infinite where the data do not bound the parameter.

        Raises
        ------
        ValueError
            ``level`` is not between 0 and 1.
        """
        if self.stderr == 0.0:
            return self.value, self.value
        return self._profile().interval(level)

    def __str__(self) -> str:
        """Return value ± uncertainty with the unit, as the commands write it."""
        return with_uncertainty(self.value, self.stderr, self.unit)


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
    return with_uncertainty(parameter.value, parameter.stderr, "1")


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
    """

    model: Model
    params: FitParameters
    solution: Solution = field(repr=False)
    _constrained: ConstrainedFit = field(repr=False)

    @property
    def nobs(self) -> int:
        """Number of fitted rows of both channels together."""
        return self.solution.observations.rows

    @property
    def nfree(self) -> int:
        """Number of rows minus the number of parameter combinations that the data determine."""
        return self.nobs - self.solution.rank

    @property
    def log_likelihood(self) -> float:
        """Logarithm of the likelihood, with the noise parameters that maximise it."""
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
        """Covariance of the parameters, shape (parameters, parameters), in their units."""
        slopes = slopes_of(self._constrained, list(self.params))
        return np.asarray(slopes @ self._constrained.covariance @ slopes.T)

    @cached_property
    def correlations(self) -> Mapping[tuple[str, str], float]:
        """Correlation of each pair of parameters, −1 to 1; a key is a pair of names, in either
        order.

        A pair with a fixed parameter is left out.
        """
        names, covariance = list(self.params), self.covariance
        spread = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        return MappingProxyType(
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
            signed), and the set's own conditions.
        return_std : bool, optional
            If True, also return the standard uncertainty.

        Returns
        -------
        error_arcsec : ndarray, shape (n,)
            Predicted error.
        std_arcsec : ndarray, shape (n,)
            Standard uncertainty of the predicted error, from the uncertainties of the parameters;
            where ``return_std`` is True.

        Raises
        ------
        ValueError
            An effect of the model needs a condition that is not given.
        """
        rows = table_rows(self.solution.observations, angle, conditions or {})
        total, variance = np.zeros(rows.run.size), np.zeros(rows.run.size)
        columns = np.zeros((rows.run.size, sum(self.solution.widths)))
        for number, term in enumerate(self.solution.terms):
            part = self.solution.part(number)
            found = term_values(term, rows, self.solution.context, conditions or {})
            if found is not None:
                columns[:, part] = found
        total = columns @ self.solution.coefficients
        if not return_std:
            return total
        size = columns.shape[1]
        covariance = self._constrained.covariance[:size, :size]
        variance = np.einsum("ij,jk,ik->i", columns, covariance, columns)
        return total, np.sqrt(np.maximum(variance, 0.0))

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
        """Format the fit as text: rows, residual errors, every parameter, correlations.

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
            fixed = " (fixed)" if item.stderr == 0.0 else ""
            lines.append(f"{name.ljust(width)}  {item}{fixed}")
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
        return (
            f"<p>Model: {html.escape(', '.join(self.model.effects))}</p>"
            + self.params._repr_html_()
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
        Limits of a parameter, None on an open side.
    tie : mapping of str to str, (str, float) or callable, optional
        Value that a parameter equals: another parameter, a multiple of one
        ``("other.name", 2.0)``, or a function of a mapping of all values.

    Returns
    -------
    FitResult
        Parameters, correlations, prediction, residuals.

    Raises
    ------
    ValueError
        A parameter is not known, or no values meet the conditions.
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
    conditions, places = _conditions(start, solution, fix, bounds, tie)
    if places:
        solution = _with_places(solution, places)
    found = constrained_fit(solution, conditions)
    if conditions or places:
        solution = found.solution
        content = replace(content, effects=stored_entries(content.effects, solution))
    step = step_of("fit", ", ".join(content.names()), data.label, solution)
    grown = start.grown(replace(content, history=[*start.content.history, step]), data)
    parameters = named_parameters(solution, found.covariance if conditions else None)
    profiles: dict[str, Profile] = {}

    def profile(name: str) -> Profile:
        if name not in profiles:
            profiles[name] = Profile(found, name)
        return profiles[name]

    fixed = {*places, *(item.names[0] for item in conditions if len(item.names) == 1)}
    return FitResult(
        grown,
        FitParameters(
            {
                name: FitParameter(
                    name,
                    item.value,
                    _stderr(item, fixed=name in places or (name in fixed and _is_fixed(name, fix))),
                    item.unit,
                    lambda name=name: profile(name),  # type: ignore[misc]
                )
                for name, item in parameters.items()
            }
        ),
        solution,
        found,
    )


def _is_fixed(name: str, fix: Mapping[str, float] | Iterable[str] | None) -> bool:
    return fix is not None and name in fix


def _stderr(parameter: Parameter, *, fixed: bool) -> float:
    return 0.0 if fixed else parameter.sigma


def _conditions(
    model: Model,
    solution: Solution,
    fix: Mapping[str, float] | Iterable[str] | None,
    bounds: Mapping[str, tuple[float | None, float | None]] | None,
    tie: Mapping[str, Tied] | None,
) -> tuple[list[Condition], dict[str, float]]:
    """Return the conditions that the fit must meet, and the fixed values of search parameters that
    are integers."""
    values = values_of(
        solution.terms, solution.widths, solution.coefficients, solution.observations
    )
    units = {name: item.unit for name, item in named_parameters(solution).items()}

    def require(name: str) -> str:
        if name not in values:
            raise ValueError(
                f"no parameter {name!r}.{did_you_mean(name, values)} There are: {', '.join(values)}"
            )
        return name

    found: list[Condition] = []
    places: dict[str, float] = {}
    for name, value in _fixed_values(model, fix).items():
        if _is_whole(solution, require(name)):
            places[name] = float(value)
        else:
            found.append(_equal(name, lambda _, value=value: value, (name,), units[name]))  # type: ignore[misc]
    for name, limits in (bounds or {}).items():
        low, high = limits
        if low is not None and high is not None and low > high:
            raise ValueError(f"bounds of {name}: expected low <= high, found {low:g} and {high:g}")
        if low is not None and np.isfinite(low):
            found.append(
                Condition((require(name),), lambda p, n=name, v=low: p[n] - v, equation=False)  # type: ignore[misc]
            )
        if high is not None and np.isfinite(high):
            found.append(
                Condition((require(name),), lambda p, n=name, v=high: v - p[n], equation=False)  # type: ignore[misc]
            )
    for name, tied in (tie or {}).items():
        if callable(tied):
            found.append(_equal(require(name), tied, tuple(values), units[name]))
            continue
        other, factor = (tied, 1.0) if isinstance(tied, str) else tied
        require(other)
        found.append(
            _equal(
                require(name),
                lambda p, other=other, factor=factor: factor * p[other],  # type: ignore[misc]
                (name, other),
                units[name],
            )
        )
    return found, places


def _equal(
    name: str, wanted: Callable[[Mapping[str, float]], float], names: tuple[str, ...], unit: str
) -> Condition:
    """Require that ``name`` equals the value of ``wanted``; a phase may differ by whole turns."""

    def difference(parameters: Mapping[str, float]) -> float:
        off = parameters[name] - wanted(parameters)
        if unit == "deg" and name.endswith("phase"):
            return float(np.remainder(off + 180.0, 360.0) - 180.0)
        return float(off)

    return Condition(names if names[:1] == (name,) else (name, *names), difference)


def _fixed_values(
    model: Model, fix: Mapping[str, float] | Iterable[str] | None
) -> Mapping[str, float]:
    """Return the fixed values by name.

    Raises ValueError for a name for which neither ``fix`` nor the model has a value.
    """
    if fix is None or isinstance(fix, Mapping):
        return fix or {}
    stored = {
        f"{entry.name}.{name}": item.value
        for entry in model.content.effects
        for name, item in entry.parameters.items()
    }
    names = [fix] if isinstance(fix, str) else list(fix)
    for name in names:
        if name not in stored:
            raise ValueError(
                f"fix {name}: the model has no fitted value of it.{did_you_mean(name, stored)} "
                f"Give one: fix={{'{name}': VALUE}}"
            )
    return {name: stored[name] for name in names}


def _is_whole(solution: Solution, name: str) -> bool:
    """Tell whether the parameter is a search parameter with integer values, such as an order or a
    run."""
    label, _, own = name.rpartition(".")
    term = solution.terms[labels(solution.terms).index(label)]
    return any(item.name == own and item.integer for item in term.effect.search)


def _with_places(solution: Solution, places: Mapping[str, float]) -> Solution:
    """Return the fit with the integer search parameters fixed at these values.

    Raises ValueError for a value out of range.
    """
    named = labels(solution.terms)
    terms: list[Term] = list(solution.terms)
    for name, value in places.items():
        label, _, own = name.rpartition(".")
        number = named.index(label)
        low, high = terms[number].effect.search_range(own)
        if not low <= value <= high or value != round(value):
            raise ValueError(
                f"fix {name}: expected a whole number from {low:g} to {high:g}, found {value:g}"
            )
        terms[number] = replace(terms[number], nonlinear={**terms[number].nonlinear, own: value})
    return fit_terms(terms, solution.observations)


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
