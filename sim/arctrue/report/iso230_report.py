"""Writes the figures according to ISO 230-2 as a report."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from arctrue.metrology.iso230 import Positioning
from arctrue.report.document import Block, Document, Picture, Rows, Text, write_document
from arctrue.report.numbers import decimal
from arctrue.report.svg import AFTER, BEFORE, house_style


def write_iso230_report(
    data: Mapping[str, Any], before: Positioning, after: Positioning | None, folder: Path
) -> list[Path]:
    """Write iso230.md, .html and .pdf; ``data`` is the content of the command's JSON file. Raises
    OSError."""
    states = [("measured", before), *([("corrected", after)] if after is not None else [])]
    verdict = (
        "According to ISO 230-2:2014."
        if data["by_the_standard"]
        else f"Not according to ISO 230-2:2014: {'; '.join(data['not_by_the_standard'])}."
    )
    facts = [
        ("measurement set", data["set"]["title"]),
        ("SHA-256 of the set", data["set"]["sha256"]),
        ("model", data["model"] or "none: as measured"),
        ("program", data["program"]),
        ("targets", str(before.target_deg.size)),
        ("smallest number of approaches to a target", str(before.approaches)),
    ]
    uncertainty = data["expanded_uncertainty_arcsec"]
    values = [which.figures() for _, which in states]
    blocks: list[Block] = [
        Text(verdict),
        Text(f"Signs: {data['sign']}."),
        Rows(
            "Over the turn, ″",
            ["figure", *(name for name, _ in states), "U (k = 2)"],
            [
                [name, *(decimal(figures[name]) for figures in values), decimal(uncertainty[name])]
                for name in values[0]
            ],
        ),
        *(Text(note) for note in data["notes"]),
        Text(
            "Uncertainty: the law of propagation (JCGM 100:2008, equation 10) combines the "
            "contributors of ISO/TR 230-9 (reference instrument, environment); docs/reports.md "
            "states the equations."
        ),
    ]
    for name, which in states:
        blocks.append(Picture(f"Positioning deviations, {name}", _figure(which, name)))
        up, down = which.up, which.down
        columns = [
            up.mean_arcsec, down.mean_arcsec, which.mean_arcsec, which.reversal_arcsec,
            up.repeatability_arcsec, down.repeatability_arcsec, which.repeatability_arcsec,
        ]  # fmt: skip
        blocks.append(
            Rows(
                f"Per target, {name}, ″",
                ["target °", "x̄↑", "x̄↓", "x̄", "B", "R↑", "R↓", "R"],
                [
                    [f"{target:.4f}", *(decimal(float(column[i])) for column in columns)]
                    for i, target in enumerate(which.target_deg)
                ],
            )
        )
    return write_document(Document("Positioning after ISO 230-2", facts, blocks), folder, "iso230")


def _figure(which: Positioning, name: str) -> Figure:
    with house_style():
        figure = Figure(figsize=(7.6, 3.4), layout="constrained")
        axes: Axes = figure.subplots()
        for sign, side, colour in (("↑", which.up, BEFORE), ("↓", which.down, AFTER)):
            if not side.approaches.any():
                continue
            bar = np.nan_to_num(2.0 * side.s_arcsec)
            axes.errorbar(
                which.target_deg,
                side.mean_arcsec,
                bar,
                fmt="o-",
                markersize=3,
                linewidth=1,
                capsize=2,
                color=colour,
                label=f"mean {sign}, ± 2 s",
            )
        axes.set_xlabel("target, °")
        axes.set_ylabel("deviation, ″")
        axes.set_title(name)
        axes.legend()
    return figure
