"""Predicts the error of head 1 from a fitted model, at any angle and condition."""

from __future__ import annotations

from collections.abc import Mapping
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.base.similar import did_you_mean
from arctrue.importing.file_rows import KELVIN_AT_0
from arctrue.workbench.effects.base import FitContext
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.inference.tangents import Tangent, refined_names
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.rows import ReferenceRows

Float = NDArray[np.float64]
UNITS = {"temperature_c": "K", "time_s": "s", "direction": "1", "speed_deg_s": "deg/s"}
"""Units of the conditions that every set may have, to which quantities of astropy are converted;
kelvins are then converted to °C."""
KNOWN = tuple(UNITS)
"""Names of the conditions that every set may have; other conditions are the user's additional
columns."""


def table_rows(
    observations: Observations, angle_deg: ArrayLike, conditions: Mapping[str, ArrayLike]
) -> ReferenceRows:
    """Return n rows at these angles and conditions, as rows of a reference run.

    Raises ValueError for angles in more than one dimension, for a condition that is not known, or
    for a condition that is neither one number nor as long as the angles.
    """
    angle = np.radians(
        np.atleast_1d(np.asarray(plain(angle_deg, "deg", "angle"), dtype=np.float64))
    )
    if angle.ndim != 1:
        raise ValueError(f"angle: expected a row of numbers, found an array {angle.shape}")
    known = {*KNOWN, *_own_conditions(observations)}
    columns: dict[str, Float] = {}
    for name, values in conditions.items():
        if name not in known:
            raise ValueError(
                f"condition {name} is not known.{did_you_mean(name, known)} There are: "
                f"{', '.join(sorted(known))}"
            )
        array = np.asarray(
            plain(values, UNITS.get(name, ""), f"condition {name}"), dtype=np.float64
        )
        if array.ndim > 1 or (array.ndim == 1 and array.size not in (1, angle.size)):
            raise ValueError(
                f"condition {name}: expected one number or {angle.size}, as many as angles, found "
                f"an array {array.shape}"
            )
        columns[name] = np.broadcast_to(array, angle.shape).copy()
    speed, time_s = columns.get("speed_deg_s"), columns.get("time_s")
    direction = columns.get("direction")
    if direction is not None and (wrong := np.flatnonzero(np.abs(direction) != 1.0)).size:
        raise ValueError(f"condition direction: expected +1 or -1, found {direction[wrong[0]]:g}")
    if direction is None and speed is not None:
        direction = np.sign(speed)
    start_s, middle_s = _set_times(observations)
    return ReferenceRows(
        run=np.zeros(angle.size, dtype=np.int64),
        cycle=None,
        time_s=time_s,
        temperature_c=columns.get("temperature_c"),
        direction=direction,
        target_rad=angle,
        angle_rad=angle,
        line_rad=angle,
        face=None,
        faces=None,
        electrical1_rad=None
        if observations.grating_lines is None
        else np.mod(angle * observations.grating_lines, 2.0 * np.pi),
        teeth=observations.drive_gear_teeth,
        speed_rad_s=None if speed is None else np.radians(speed),
        run_start_s=None if time_s is None else np.full(angle.size, start_s),
        set_start_s=start_s,
        session_start_s=_session_start_s(observations),
        middle_time_s=middle_s,
        reference_temperature_c=observations.reference_temperature_c,
        error_arcsec=np.zeros(angle.size),
        heads=observations.heads,
        conditions={name: column for name, column in columns.items() if name not in KNOWN},
    )


def plain(values: Any, unit: str, place: str) -> Any:
    """Return the numbers of a quantity of astropy in ``unit``; everything else is returned
    unchanged.

    ``unit``: "" for the quantity's own unit; a temperature in kelvins is returned in °C. Raises
    ValueError, which begins with ``place``, if the quantity has a unit of another kind.
    """
    if not (hasattr(values, "unit") and hasattr(values, "to_value")):
        return values
    if not unit:
        return values.value
    equivalencies = import_module("astropy.units").temperature() if unit == "K" else []
    try:
        found = values.to_value("" if unit == "1" else unit, equivalencies=equivalencies)
    except (TypeError, ValueError) as error:
        raise ValueError(
            f"{place}: expected a unit that can be converted to {unit}, found {str(values.unit)!r}"
        ) from error
    return found - KELVIN_AT_0 if unit == "K" else found


def _own_conditions(observations: Observations) -> set[str]:
    return {
        name
        for rows in (observations.capture, observations.reference)
        if rows is not None
        for name in rows.conditions
    }


def _set_times(observations: Observations) -> tuple[float, float]:
    """Return the first time and the middle of the times of the reference, seconds.

    Without times of a reference, return the first and the mean time of the capture, or 0.
    """
    reference, capture = observations.reference, observations.capture
    if reference is not None and reference.time_s is not None:
        return reference.set_start_s, reference.middle_time_s
    if capture is not None:
        return capture.set_start_s, float(capture.time_s.mean())
    return 0.0, 0.0


def _session_start_s(observations: Observations) -> float:
    reference = observations.reference
    timed = reference is not None and reference.time_s is not None
    rows = reference if timed else observations.capture
    return 0.0 if rows is None else rows.session_start_s


def term_values(
    term: Term, rows: ReferenceRows, context: FitContext, conditions: Mapping[str, ArrayLike]
) -> Float | None:
    """Return each coefficient's contribution to ε of head 1, (n, coefficients); None if the effect
    makes no contribution.

    Raises ValueError if the effect needs a condition that was not given.
    """
    if term.effect.compensation == "reference":
        return None
    lacking = _needs(term, rows, context) - set(conditions)
    if lacking:
        needed = ", ".join(sorted(lacking))
        raise ValueError(
            f"{term.effect.name} needs {needed}: predict(angle, {{'{sorted(lacking)[0]}': ...}})"
        )
    return term.effect.reference_columns(rows, term.nonlinear, context)


def prediction_columns(
    solution: Solution, angle_deg: ArrayLike, conditions: Mapping[str, ArrayLike]
) -> Float:
    """Return the factor of each unknown of a fit in ε of head 1, (n, unknowns).

    The unknowns are the coefficients of all terms and, after them, the continuous search parameters
    of each term, whose factors are derivatives of ε. Raises ValueError as :func:`table_rows` and
    :func:`term_values` do.
    """
    rows = table_rows(solution.observations, angle_deg, conditions)
    size = rows.run.size
    blocks, tangents = [], []
    for number, term in enumerate(solution.terms):
        found = term_values(term, rows, solution.context, conditions)
        blocks.append(np.zeros((size, solution.widths[number])) if found is None else found)
        names = refined_names(term.effect)
        if not names:
            continue
        slopes = None
        if found is not None:
            own = solution.coefficients[solution.part(number)]
            tangent = Tangent(term, own, solution.observations)
            slopes = tangent.reference_columns(rows, {}, solution.context)
        tangents.append(np.zeros((size, len(names))) if slopes is None else slopes)
    return np.concatenate([*blocks, *tangents], axis=1)


def _needs(term: Term, rows: ReferenceRows, context: FitContext) -> set[str]:
    """Return the conditions without which the effect cannot predict its contribution."""
    zeros = np.zeros(rows.run.size)
    every = {
        "temperature_c": {"temperature_c": zeros},
        "time_s": {"time_s": zeros, "run_start_s": zeros},
        "direction": {"direction": zeros + 1.0},
        "speed_deg_s": {"speed_rad_s": zeros},
    }
    full = _changed(rows, {name: value for item in every.values() for name, value in item.items()})
    if not _there(term, full, context):
        return set()
    return {
        name
        for name, item in every.items()
        if not _there(term, _changed(full, dict.fromkeys(item)), context)
    }


def _changed(rows: ReferenceRows, columns: Mapping[str, Float | None]) -> ReferenceRows:
    return ReferenceRows(**{**vars(rows), **columns})


def _there(term: Term, rows: ReferenceRows, context: FitContext) -> bool:
    return term.effect.reference_columns(rows, term.nonlinear, context) is not None
