"""Computes two figures of a model's residual on a set: *left* (RMS of the residual) and *held out*
(RMS of the prediction errors; each row is predicted by a fit without that row).

The history of a model, diagnosis, comparison, page and report show these figures; no other module
computes such figures.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from arctrue.workbench.inference.every_row import channel_figures
from arctrue.workbench.inference.held_out import HeldOut, Improvement, falls, held_out
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.repeats import row_noise_arcsec
from arctrue.workbench.observations.stations_a_turn import STATION_DECIMALS

CHANNELS = ("capture", "reference")


@dataclass(frozen=True, eq=False)
class Left:
    """Figures of a fitted model by channel; a channel that the set lacks has no figures."""

    rms_arcsec: Mapping[str, float]
    """*Left*: RMS of the residual over every row that the commands use."""
    peak_arcsec: Mapping[str, float]
    heldout_rms_arcsec: Mapping[str, float]
    """*Held out*: RMS of the prediction errors of the rows that the statistics use; each row is
    predicted by a fit without that row (:func:`held_out`).
    """
    noise_arcsec: Mapping[str, float]
    """RMS scatter of the repeats (:func:`row_noise_arcsec`)."""
    held_out: HeldOut
    solution: Solution
    rows: Mapping[str, int]

    @cached_property
    def residuals(self) -> Residuals:
        """Residuals of the model with their tests, which several figures use."""
        return Residuals(self.solution)

    def fall_from(self, before: Left) -> dict[str, Improvement]:
        """Return the fall of *held out* from the model of ``before``, by channel; both residuals
        are weighted with the noise of this model."""
        return falls(before.held_out, self.held_out, self.solution.noise)

    def mean_log_ratio(self, before: Left) -> float:
        """Return the smaller of two means of log(RMS after/RMS before), that of *left* and that of
        *held out*, over the channels in which the last term of this model has columns.

        A result above 0 means that the residual has grown. The weight of a channel is its number of
        passes over the angle, not of rows, because the noise of neighbouring rows is correlated. A
        channel without columns of the term changes only because the shared orders are fitted anew.
        """
        passes = {
            name: count
            for name, count in passes_of(self.solution).items()
            if name in self.rms_arcsec and name in before.rms_arcsec
        }
        figures = (
            (self.rms_arcsec, before.rms_arcsec),
            (self.heldout_rms_arcsec, before.heldout_rms_arcsec),
        )
        return min(_mean_log_ratio(after, former, passes) for after, former in figures)


def passes_of(solution: Solution) -> dict[str, int]:
    """Return the number of passes over the angle of each channel in which the last term of a model
    has columns: revolutions of the capture, and visits of a station of the reference."""
    observations, context = solution.observations, solution.context
    term = solution.terms[-1]
    found: dict[str, int] = {}
    capture, reference = observations.capture, observations.reference
    if capture is not None and capture.run.size:
        columns = term.effect.capture_columns(
            capture.part(slice(0, 2)).of_head(2), term.nonlinear, context
        )
        if columns is not None:
            found["capture"] = np.unique(capture.revolution).size
    if reference is not None and reference.run.size:
        columns = term.effect.reference_columns(reference, term.nonlinear, context)
        if columns is not None:
            station = np.round(reference.target_rad, STATION_DECIMALS)
            found["reference"] = max(1, round(station.size / np.unique(station).size))
    return found


def _mean_log_ratio(
    after: Mapping[str, float], before: Mapping[str, float], passes: Mapping[str, int]
) -> float:
    shared = [name for name in passes if name in after and name in before]
    total = sum(passes[name] * _log_ratio(after[name], before[name]) for name in shared)
    return total / max(sum(passes[name] for name in shared), 1)


def _log_ratio(after: float, before: float) -> float:
    return float(np.log(max(after, 1e-300) / max(before, 1e-300)))


def left_by(solution: Solution) -> Left:
    """Return *left* and *held out* of a solution, with the noise of the repeats."""
    unseen = held_out(solution.terms, solution.observations, solution.context, solution.noise)
    rms: dict[str, float] = {}
    peak: dict[str, float] = {}
    noise: dict[str, float] = {}
    apart: dict[str, float] = {}
    rows: dict[str, int] = {}
    residuals = solution.capture_residual_arcsec(), solution.reference_residual_arcsec()
    unseen_rms = unseen.capture_rms_arcsec, unseen.reference_rms_arcsec
    for channel, values, of_unseen in zip(CHANNELS, residuals, unseen_rms, strict=True):
        figures = channel_figures(solution, channel)
        if figures is None or values is None:
            continue
        rms[channel], peak[channel] = figures.rms_arcsec, figures.peak_arcsec
        rows[channel] = figures.rows
        noise[channel] = row_noise_arcsec(
            solution.observations, values, channel, figures.rms_arcsec
        )
        if of_unseen is not None:
            apart[channel] = of_unseen
    return Left(rms, peak, apart, noise, unseen, solution, rows)
