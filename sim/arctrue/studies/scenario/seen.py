"""Computes the error of the output that a reference instrument with its own errors would
measure."""

from __future__ import annotations

import numpy as np

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.instrument.turn_score import BINS, TURN_RAD, TurnScore
from arctrue.studies.scenario.course import Course
from arctrue.studies.scenario.scenario import Scenario
from arctrue.table.cause import Cause, Stations


def seen_by_reference(
    scenario: Scenario, course: Course, number: int, error: TurnScore | None
) -> TurnScore | None:
    """Return the error of turn ``number`` (first: 1) that a polygon with its own errors measures.

    Returns None if no cause concerns the reference or ``error`` is None. Bins of half a degree
    without a face are NaN.
    """
    causes = [cause.physical for cause in scenario.causes if cause.reference_only]
    if not causes or error is None:
        return None
    faces = np.arange(scenario.faces)
    angle_rad = np.asarray(faces * (TURN_RAD / scenario.faces), dtype=np.float64)
    # Choose the bin of half a degree that begins at the face, independent of the last bit of the
    # face's angle.
    bins = faces * BINS // scenario.faces
    stood_s = np.array([course.time_at_turn(number - 1 + f / scenario.faces) for f in faces])
    state = course.state(stood_s)
    stations = Stations(state.turned(angle_rad), faces)
    deviation_rad = error.error_arcsec[bins] * RAD_PER_ARCSEC
    shown = deviation_rad.copy()
    for cause in causes:
        if isinstance(cause, Cause):
            shown = shown + cause.instrument_error_rad(stations, deviation_rad)
    values = np.full(BINS, np.nan)
    values[bins] = shown / RAD_PER_ARCSEC
    mean = float(np.nanmean(values))
    single = float(np.sqrt(np.nanmean((values - mean) ** 2)))
    return TurnScore.of_means(values - mean, mean, single)
