"""Defines the parameters of a fit: values, standard uncertainties and confidence intervals."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from arctrue.api.pictures import html_table
from arctrue.base.figures import unit_for_people, with_uncertainty
from arctrue.base.similar import did_you_mean
from arctrue.workbench.inference.constrained import ConstrainedFit
from arctrue.workbench.inference.profile import Profile

State = Literal["free", "fixed", "at_bound", "undetermined"]
SAID: Mapping[State, str] = {
    "free": "",
    "fixed": " (fixed)",
    "at_bound": " (at a bound)",
    "undetermined": " (not determined)",
}
"""Remark after a parameter's value."""


@dataclass
class Profiles:
    """The likelihood along each parameter of a fit, computed when it is needed."""

    fit: ConstrainedFit
    limits: Mapping[str, tuple[float, float]]
    _found: dict[str, Profile] = field(default_factory=dict)

    def of(self, parameter: FitParameter) -> Profile:
        """Return the likelihood along a parameter; its own bounds limit the profile's range."""
        name = parameter.name
        if name not in self._found:
            own = [one for one in self.fit.conditions if one.equation or one.names != (name,)]
            limits = self.limits.get(name, (-np.inf, np.inf))
            fit = replace(
                self.fit,
                conditions=tuple(own),
                covariance=self.fit.covariance_of_equations
                if parameter.state == "at_bound"
                else self.fit.covariance,
            )
            self._found[name] = Profile(fit, name, limits)
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
        Standard uncertainty of the linearised fit, in ``unit``; 0 for a fixed parameter. NaN for a
        parameter that the data do not determine, and for a parameter at a bound, because the
        linearised fit is not valid beyond the bound.
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
    _profiles: Profiles = field(repr=False)

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
    """Parameters of a fit by name, in the order of the model.

    Parameters
    ----------
    parameters : mapping of str to FitParameter
        The parameters by name.
    """

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
            The value of each parameter by name, in the unit of the parameter.
        """
        return {name: item.value for name, item in self.items()}

    def _repr_html_(self) -> str:
        rows = [
            (
                name,
                with_uncertainty(item.value, item.stderr, "1") + SAID[item.state],
                unit_for_people(item.unit).strip(),
            )
            for name, item in self.items()
        ]
        return html_table(("parameter", "value ± standard uncertainty", "unit"), rows)
