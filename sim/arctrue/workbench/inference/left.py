"""Computes two figures of a model's residual on a set: *left* (RMS of the residual) and *held out*
(RMS of the errors with which each row is predicted by a fit without that row).

The history of a model, diagnosis, comparison, page and report show these figures; no other module
computes such figures.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.workbench.inference.every_row import channel_figures
from arctrue.workbench.inference.held_out import HeldOut, Improvement, falls, held_out
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.repeats import row_noise_arcsec

CHANNELS = ("capture", "reference")


@dataclass(frozen=True, eq=False)
class Left:
    """Figures of a fitted model by channel; a channel that the set lacks has no figures."""

    rms_arcsec: Mapping[str, float]
    """*Left*: RMS of the residual over every row that the commands use."""
    peak_arcsec: Mapping[str, float]
    heldout_rms_arcsec: Mapping[str, float]
    """*Held out*: RMS of the errors with which each row that the statistics use is predicted by a
    fit without that row (:func:`held_out`).
    """
    noise_arcsec: Mapping[str, float]
    """RMS scatter of the repeats (:func:`row_noise_arcsec`)."""
    held_out: HeldOut
    solution: Solution
    rows: Mapping[str, int]

    def fall_from(self, before: Left) -> dict[str, Improvement]:
        """Return the fall of *held out* from the model of ``before``, by channel; both residuals
        are weighted with the noise of this model."""
        return falls(before.held_out, self.held_out, self.solution.noise)

    def mean_log_ratio(self, before: Left) -> float:
        """Return the mean over all rows of log(RMS after/RMS before), each row with the RMS of its
        channel.

        A result above 0 means that the residual has grown. The mean is the fall per row of the log
        likelihood of white noise with a free variance in each channel.
        """
        rows = {name: self.rows[name] for name in self.rms_arcsec if name in before.rms_arcsec}
        total = sum(
            count * float(np.log(self.rms_arcsec[name] / max(before.rms_arcsec[name], 1e-300)))
            for name, count in rows.items()
        )
        return total / max(sum(rows.values()), 1)


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
