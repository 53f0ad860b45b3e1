"""Defines the result of ``arctrue.fit``: statistics, prediction, residuals, report."""

from __future__ import annotations

import html
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.api.model import Model
from arctrue.api.parameters import FitParameters
from arctrue.api.pictures import Pictures
from arctrue.api.results import comparison_pictures
from arctrue.base.figures import figure
from arctrue.workbench.compare.comparison import compare
from arctrue.workbench.inference.constrained import ConstrainedFit
from arctrue.workbench.inference.directions import MOST_UNDETERMINED, Directions
from arctrue.workbench.inference.left import Left, left_by
from arctrue.workbench.inference.profile import slopes_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.predicted import prediction_columns

Float = NDArray[np.float64]


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

        The prediction excludes errors of the reference, because they are not errors of the table,
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
            only if ``return_std`` is True. It is infinite where the rows do not determine the
            error.

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

    def __str__(self) -> str:
        """Return the text of :meth:`fit_report`."""
        return self.fit_report()

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
        return comparison_pictures(self.solution, compare(self.solution, 1))

    def _repr_html_(self) -> str:
        warned = "".join(f"<p>Warning: {html.escape(text)}</p>" for text in self.warnings)
        return (
            f"<p>Model: {html.escape(', '.join(self.model.effects))}</p>"
            + self.params._repr_html_()
            + warned
        )
