"""Computes the error function of a set at stated angles, with its expanded uncertainty, for a
certificate.

U = k·u with k = 2. u² is the sum of xᵀ·C·x and of the squares of the contributions that the fit
does not contain; C is the covariance of the fitted coefficients, and x contains the values of their
design-matrix columns at the angle (JCGM 100:2008, equations 10 and 13). The sensitivity to the head
separation is computed by further fits (JCGM 100:2008, clause 5.1.4): one for each head except head
1, with a changed place of this head. The mountings of the heads are independent.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.calibration.head_separation import NOMINAL_TOLERANCE_ARCSEC
from arctrue.measurement import MeasurementSet, Table
from arctrue.metrology.budget import (
    CONFIDENCE,
    COVERAGE,
    Contribution,
    count_lines,
    reversal_lines,
)
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.directions import MOST_UNDETERMINED, directions_of
from arctrue.workbench.inference.identifiability import undetermined_names
from arctrue.workbench.inference.left import left_by
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model
from arctrue.workbench.model.predicted import prediction_columns
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

SHIFT_ARCSEC = 10.0
"""Change of the head separation from which its sensitivity is computed; it is small against
mounting errors and large against rounding errors."""


@dataclass(frozen=True, eq=False)
class CertifiedError:
    """Error function ε of head 1 at stated angles: reading minus true angle, as the fitted effects
    predict it.

    It does not contain the constants of the runs. An effect may add a constant: ``hysteresis`` adds
    half the reversal error in one direction.
    """

    angle_deg: Float
    """Angles at which ε is stated, (angles,)."""
    error_arcsec: Float
    """ε at each angle, (angles,)."""
    u_fit_arcsec: Float
    """Standard uncertainty from the covariance of the fit, (angles,)."""
    u_separation_arcsec: Float
    """Standard uncertainty due to the head separation, (angles,); 0 without a capture, or if the
    model fits the separation (effect ``head_angle_error``)."""
    contributions: tuple[Contribution, ...]
    """Uncertainty contributions that have the same size at every angle."""
    solution: Solution
    effects: tuple[str, ...]
    conditions: Mapping[str, float]
    """Conditions under which the error function holds, for example ``direction``."""

    @property
    def u_arcsec(self) -> Float:
        """Combined standard uncertainty, (angles,)."""
        square = self.u_fit_arcsec**2 + self.u_separation_arcsec**2
        return np.asarray(np.sqrt(square + sum(one.u_arcsec**2 for one in self.contributions)))

    @property
    def expanded_arcsec(self) -> Float:
        """Expanded uncertainty U with k = 2, (angles,)."""
        return COVERAGE * self.u_arcsec

    @property
    def coverage_probability(self) -> float:
        """Probability that a normal variable lies within ± k standard deviations, k = 2."""
        return CONFIDENCE


def certified_error(
    measurement: MeasurementSet,
    model: Model,
    effects: Mapping[str, type[Effect]],
    angle_deg: Float,
    conditions: Mapping[str, float],
) -> CertifiedError:
    """Fit ``model`` to the set and state its error function at angles (n,), with the uncertainty.

    ``conditions``: ``direction``, ``temperature_c`` and others that the model's effects need.
    Raises ValueError if the set does not state a quantity that U needs, if a condition is missing,
    or if the rows of the set do not determine the error function at an angle.
    """
    reference = measurement.reference
    if reference is not None and reference.standard_uncertainty_arcsec is None:
        raise ValueError(
            "reference.standard_uncertainty_arcsec is not stated in measurement.toml: the "
            "uncertainty of a certificate includes it"
        )
    if measurement.table.counts_per_rev is None:
        raise ValueError(
            "table.counts_per_rev is not stated in measurement.toml: the uncertainty of a "
            "certificate needs the resolution of the reading"
        )
    solution = _fit(measurement, model, effects)
    error, u_fit = _error_at(solution, angle_deg, conditions)
    separation = np.zeros(angle_deg.size)
    has_separation = "head_angle_error" in model.names()
    if measurement.capture is not None and not has_separation:
        square = np.zeros(angle_deg.size)
        for table in _shifted(measurement.table):
            moved = _fit(replace(measurement, table=table), model, effects)
            square += ((_error_at(moved, angle_deg, conditions)[0] - error) / SHIFT_ARCSEC) ** 2
        separation = np.sqrt(square) * NOMINAL_TOLERANCE_ARCSEC / math.sqrt(3.0)
    return CertifiedError(
        angle_deg,
        error,
        u_fit,
        separation,
        tuple(_contributions(measurement, model, solution)),
        solution,
        tuple(model.names()),
        dict(conditions),
    )


def _fit(
    measurement: MeasurementSet, model: Model, effects: Mapping[str, type[Effect]]
) -> Solution:
    observations = observations_of(
        measurement, reference_temperature_c=model.reference_temperature_c
    )
    return fitted(model, observations, effects)[1]


def _error_at(
    solution: Solution, angle_deg: Float, conditions: Mapping[str, float]
) -> tuple[Float, Float]:
    """Return ε and its standard uncertainty from the covariance, (angles,) each.

    Raises ValueError if an effect needs a condition that is not stated, or if the rows of the set
    do not determine ε at an angle.
    """
    columns = prediction_columns(solution, angle_deg, conditions)
    unknown = directions_of(solution).share(columns) > MOST_UNDETERMINED
    if unknown.any():
        names = undetermined_names(solution)
        which = f" ({', '.join(names[:3])}{', …' if len(names) > 3 else ''})" if names else ""
        raise ValueError(
            f"the set does not determine the error at {angle_deg[unknown][0]:g}°: its rows leave "
            f"coefficients of the model{which} free, and a certificate would state no uncertainty "
            "for them; measure the whole turn, or give a --model of fewer orders, or state "
            "angles that were measured"
        )
    variance = np.einsum("ij,jk,ik->i", columns, solution.with_tangents.covariance, columns)
    return columns[:, : sum(solution.widths)] @ solution.coefficients, np.sqrt(
        np.maximum(variance, 0.0)
    )


def _shifted(table: Table) -> list[Table]:
    """Return one table for each head except head 1, with the place of this head moved away from
    head 1 by ``SHIFT_ARCSEC``."""
    shift_deg = SHIFT_ARCSEC / 3600.0
    if table.head_places_deg is not None:
        places = np.array(table.head_places_deg) + shift_deg * np.eye(len(table.head_places_deg))
        return [
            replace(table, head_separation_deg=None, head_places_deg=tuple(row.tolist()))
            for row in places[1:]
        ]
    assert table.head_separation_deg is not None
    return [replace(table, head_separation_deg=table.head_separation_deg + shift_deg)]


def _contributions(
    measurement: MeasurementSet, model: Model, solution: Solution
) -> list[Contribution]:
    """Return the contributions that the fit and the head separation do not cause; they have the
    same size at every angle."""
    left = left_by(solution)
    channel = "reference" if "reference" in left.rms_arcsec else "capture"
    rms, noise = left.rms_arcsec[channel], left.noise_arcsec[channel]
    found = [
        Contribution(
            "error that the model leaves",
            f"{channel}: RMS of the residual above the scatter of the repeats",
            "A",
            "normal",
            math.sqrt(max(rms**2 - noise**2, 0.0)),
        )
    ]
    reference = measurement.reference
    if reference is not None:
        assert reference.standard_uncertainty_arcsec is not None
        found.append(
            Contribution(
                "reference instrument",
                reference.instrument or "reference.standard_uncertainty_arcsec",
                "B",
                "normal",
                reference.standard_uncertainty_arcsec,
            )
        )
        rows, residual = solution.observations.reference, solution.reference_residual_arcsec()
        if "hysteresis" not in model.names() and rows is not None and residual is not None:
            found += reversal_lines(rows.direction, residual)
    return [*found, *count_lines(measurement.table)]
