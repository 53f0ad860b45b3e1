"""Provides ``arctrue.fit``, which finds parameters that are fixed, at a bound or undetermined."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace

from arctrue.api.conditions import Tied, Wanted, wanted_of, with_places
from arctrue.api.fit_result import FitResult
from arctrue.api.model import ModelLike, model_of
from arctrue.api.parameters import FitParameter, FitParameters, Profiles, State
from arctrue.api.sets import SetOrFolder, set_of
from arctrue.calibration.head_separation import doubts_of
from arctrue.workbench.effects.base import Parameter
from arctrue.workbench.inference.constrained import ConstrainedFit, constrained_fit
from arctrue.workbench.inference.directions import directions_of, undetermined_parameters
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import fitted, step_of, stored_entries
from arctrue.workbench.model.stations import warnings_of_the_arc

AT_BOUND = 1e-5
"""Largest ratio of a parameter's standard uncertainties with and without conditions at which the
conditions alone determine the parameter. Rounding leaves a ratio of 1e-8, the square root of the
relative rounding error of a variance."""
MOST_NAMED = 3
"""Largest number of parameters that a warning names."""


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
        Parameters that keep a value, in the unit of the parameter:
        ``{"hysteresis.reversal_error": 0.5}``; names alone keep the value that the model has from
        an earlier fit.
    bounds : mapping of str to (low, high), optional
        Limits of a parameter, None on an open side. A phase is compared with its limits after a
        shift by whole turns.
    tie : mapping of str to str, (str, float) or callable, optional
        Makes a parameter equal to another parameter, to a multiple of another parameter
        ``("other.name", 2.0)``, or to the result of a function of a mapping of all values.

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
    of_rows = (*doubts_of(data), *observations.left_out)
    warnings = (*data.warnings, *of_rows, *of_arc, *not_determined(lost))
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
    profiles = Profiles(found, wanted.limits)
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
