"""The ladder of a model's history on the terminal."""

from __future__ import annotations

from collections.abc import Sequence

from rich.table import Table

from arctrue.workbench.model.model import HistoryStep


def ladder_table(history: Sequence[HistoryStep]) -> Table:
    """One row a step: RMS and peak of each channel, fitted and held out, beside the noise."""
    table = Table(title="How the error fell: what the model leaves at each step")
    # Two lines a heading: the table fits into 80 columns.
    for heading in ("step", "effect", "channel", "RMS\n″", "held\nout ″", "peak\n″", "noise\n″"):
        left = heading in ("step", "effect", "channel")
        table.add_column(heading, justify="left" if left else "right", overflow="fold")
    for number, step in enumerate(history, start=1):
        for index, channel in enumerate(step.rms_arcsec):
            first = index == 0
            table.add_row(
                f"{number} {step.action}" if first else "",
                step.effect if first else "",
                channel,
                f"{step.rms_arcsec[channel]:.4f}",
                _figure(step.heldout_rms_arcsec.get(channel)),
                f"{step.peak_arcsec[channel]:.3f}",
                _figure(step.noise_arcsec.get(channel)),
            )
    return table


def _figure(value: float | None) -> str:
    return "–" if value is None else f"{value:.4f}"
