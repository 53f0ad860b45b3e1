"""Prints the table of a model's history on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from arctrue.base.figures import figure
from arctrue.cli._tables import number, table, words
from arctrue.workbench.model.model import HistoryStep
from arctrue.workbench.model.noise_floor import with_one_floor


def ladder_table(history: Sequence[HistoryStep]) -> Table:
    """Return a table with a row per step: RMS and peak residual of each channel, held-out RMS, and
    the noise."""
    ladder = table(
        "Residual of the model after each step",
        *(words(heading) for heading in ("step", "effect", "channel")),
        *(number(heading) for heading in ("RMS\n″", "held\nout ″", "peak\n″", "noise\n″")),
    )
    for place, step in enumerate(with_one_floor(history), start=1):
        for index, channel in enumerate(step.rms_arcsec):
            first = index == 0
            ladder.add_row(
                f"{place} {step.action}" if first else "",
                step.effect if first else "",
                channel,
                figure(step.rms_arcsec[channel], 4),
                figure(step.heldout_rms_arcsec.get(channel), 4),
                figure(step.peak_arcsec[channel], 3),
                figure(step.noise_arcsec.get(channel), 4),
            )
    return ladder
