"""Simulates ten cycles of 24 faces twice: first head 1's signal is the servo's feedback, then the
corrected signal.

The table of ``arctrue revolution`` is calibrated from one captured turn by least squares. The
corrected signal is equation (9), rounded to a count, with the coefficients in the number formats of
the gateware. Polygon and autocollimator are the same as in ``arctrue paper``.
"""

from __future__ import annotations

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.least_squares import least_squares
from arctrue.gateware.coefficients import Coefficients
from arctrue.studies.paper.published import PUBLISHED
from arctrue.studies.paper.station_error import StationErrors, station_errors
from arctrue.studies.revolution import RevolutionSettings
from arctrue.studies.stop_and_go.servo import (
    Axis,
    Controller,
    Feedback,
    Moves,
    Stopped,
    drive,
)
from arctrue.table import HEAD_SEPARATION_RAD, Motion, RotaryTable, TableState

Float = NDArray[np.float64]

TURN_RAD = 2.0 * np.pi
COUNTS_PER_REV = 1 << 24
SAMPLES = 12_000
ORDERS = np.arange(1, 17)


@dataclass(frozen=True)
class StopAndGoSettings:
    """Settings of the study; :mod:`servo` defines axis and controller; the noise acts on every
    sample of the loop."""

    cycles: int = PUBLISHED.cycles
    noise_arcsec: float = 0.1
    scatter_arcsec: float = 0.08
    seed: int = 1
    axis: Axis = dataclasses.field(default_factory=Axis)
    controller: Controller = dataclasses.field(default_factory=Controller)


def run_stop_and_go(settings: StopAndGoSettings | None = None) -> dict[str, Any]:
    """Run the cycles with each of the two feedbacks; return plain values. Raises ValueError for
    fewer than two cycles."""
    settings = settings or StopAndGoSettings()
    if settings.cycles < 2:
        raise ValueError(f"a deviation needs two cycles or more, found {settings.cycles}")
    random = np.random.default_rng(settings.seed)
    table = dataclasses.replace(
        RevolutionSettings(noise_arcsec=0.0).table(),
        noise_rad=settings.noise_arcsec * RAD_PER_ARCSEC,
    )
    coefficients = calibrated(table, random)
    polygon = PUBLISHED.drawn_polygon(random)
    autocollimator = PUBLISHED.drawn_autocollimator(settings.scatter_arcsec, random)
    found: dict[str, Any] = {
        "schema": 1,
        "settings": dataclasses.asdict(settings),
        "published": dataclasses.asdict(PUBLISHED),
        "orders_applied": int(np.count_nonzero(coefficients.amplitudes)),
    }
    for name, held in (("raw", None), ("corrected", coefficients)):
        stopped = _cycles(settings, feedback_of(table, held, random))
        faces = np.tile(np.arange(polygon.faces, dtype=np.intp), settings.cycles)
        target = faces * (TURN_RAD / polygon.faces)
        off = np.remainder(stopped.angle_rad - target + np.pi, TURN_RAD) - np.pi
        common_rad = float(off.mean())
        off -= common_rad
        seen = autocollimator.reading_rad(faces, polygon.direction_rad(faces, off), random)
        errors = station_errors(seen.reshape(settings.cycles, polygon.faces))
        found[name] = _plain(errors, stopped, off) | {"common_arcsec": common_rad * ARCSEC_PER_RAD}
    return found


def calibrated(table: RotaryTable, random: np.random.Generator) -> Coefficients:
    """Calibrate by least squares from one captured turn at 30°/s; return coefficients in the
    gateware's number formats."""
    speed = float(np.radians(30.0))
    motion = Motion.steady(speed, TURN_RAD / speed, ripple_rad=0.002, ripple_order=7)
    state = motion.state(np.arange(SAMPLES) * np.float64(motion.duration_s / SAMPLES))
    counts = [table.counts(head, state, random) for head in (0, 1)]
    turn = WholeTurns(0, 1, counts[0], counts[1], table.counts_per_rev / SAMPLES)
    estimate, _ = least_squares(
        [turn], table.counts_per_rev, HEAD_SEPARATION_RAD, ORDERS, "measured"
    )
    applied = estimate.amplitude_arcsec > 3.7 * estimate.u_component_arcsec
    return Coefficients.from_harmonics(
        estimate.orders[applied],
        estimate.amplitude_arcsec[applied] / arcsec_per_count(table.counts_per_rev),
        estimate.phase_rad[applied],
        table.counts_per_rev,
    )


def feedback_of(
    table: RotaryTable, coefficients: Coefficients | None, random: np.random.Generator
) -> Feedback:
    """Return the servo's feedback: a function that returns the counts of head 1 or, with
    ``coefficients``, the corrected counts, as an angle."""

    def shown(angle_rad: Float) -> Float:
        counts = table.counts(0, TableState.at_rest(angle_rad), random)
        if coefficients is not None:
            wrapped = np.remainder(counts, table.counts_per_rev)
            counts = np.rint(counts - coefficients.error_counts(wrapped)).astype(np.int64)
        return np.asarray(counts * table.count_rad)

    return shown


def _cycles(settings: StopAndGoSettings, feedback: Feedback) -> Stopped:
    """Simulate all moves in parallel; each begins at rest at the previous face."""
    faces = PUBLISHED.faces
    target = np.tile(np.arange(faces), settings.cycles) * np.float64(TURN_RAD / faces)
    moves = Moves(target - TURN_RAD / faces, target)
    return drive(settings.axis, settings.controller, moves, feedback, TURN_RAD / COUNTS_PER_REV)


def _plain(errors: StationErrors, stopped: Stopped, off_rad: Float) -> dict[str, Any]:
    # The sign is the same as in ``station_errors``: if the table stands beyond its target, the
    # error is negative.
    by_cycle = -off_rad.reshape(-1, errors.mean_arcsec.size) * ARCSEC_PER_RAD
    true = by_cycle.mean(axis=0)
    return {
        "span_arcsec": list(errors.span_arcsec),
        "mean_arcsec": errors.mean_arcsec.tolist(),
        "deviation_arcsec": errors.deviation_arcsec.tolist(),
        "true_mean_arcsec": true.tolist(),
        "true_deviation_arcsec": by_cycle.std(axis=0, ddof=1).tolist(),
        "expanded_arcsec": errors.budget(PUBLISHED).expanded_arcsec,
        "repeatability_arcsec": errors.budget(PUBLISHED).repeatability_arcsec,
        "tremble_arcsec": float(np.median(stopped.tremble_rad)) * ARCSEC_PER_RAD,
        "following_arcsec": stopped.following_rad * ARCSEC_PER_RAD,
        "settled_s": float(np.median(stopped.settled_s)),
    }
