"""Writes the uncertainty budget as a report."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.metrology.budget import BY_ANGLE_DEG, COVERAGE, Budget
from arctrue.report.budget_text import freedom, outcome
from arctrue.report.document import Block, Document, Picture, Rows, Text, write_document
from arctrue.report.numbers import decimal
from arctrue.report.svg import AFTER, house_style

HEADINGS = ("quantity", "source", "type", "distribution", "size ″", "divisor", "cᵢ", "uᵢ ″", "νᵢ")


def budget_rows(budget: Budget) -> list[list[str]]:
    """Return one row of texts per contribution; the columns are those of ``HEADINGS``."""
    return [
        [
            one.quantity,
            one.source,
            one.evaluation,
            one.distribution,
            decimal(one.size_arcsec, 4),
            decimal(one.divisor),
            f"{one.sensitivity:.3g}",
            decimal(one.u_arcsec, 4),
            freedom(one.degrees_of_freedom),
        ]
        for one in budget.contributions
    ]


def _by_angle(u_arcsec: NDArray[np.float64]) -> Figure:
    """Draw the expanded uncertainty U over the reading; U follows from the full covariance."""
    with house_style():
        figure = Figure(figsize=(8.0, 3.0), layout="constrained")
        axes = figure.subplots()
        axes.plot(BY_ANGLE_DEG, COVERAGE * u_arcsec, color=AFTER)
        axes.set_xlim(0, 360)
        axes.set_ylim(bottom=0.0)
        axes.set_xticks(range(0, 361, 45))
        axes.set_xlabel("reading, °")
        axes.set_ylabel("U (k = 2), ″")
    return figure


def write_budget_report(
    budget: Budget, facts: Sequence[tuple[str, str]], folder: Path
) -> list[Path]:
    """Write budget.md, .html and .pdf; ``facts`` names set, model and program. Raises OSError."""
    blocks: list[Block] = [
        Text(
            "Measurand: the error of indication of head 1 after the correction, at any angle; "
            "contributions that change over the turn enter with their root mean square."
        ),
        Rows("Budget", HEADINGS, budget_rows(budget), names=4),
        Text(outcome(budget) + "."),
    ]
    if budget.u_by_angle_arcsec is not None:
        blocks.append(Picture("U (k = 2) over the reading", _by_angle(budget.u_by_angle_arcsec)))
    blocks += [Text(f"Not stated: {text}.") for text in budget.missing]
    blocks += [Text(f"Not evaluated: {text}.") for text in budget.not_evaluated]
    blocks += [Text(f"Check: {text}.") for text in budget.checks]
    document = Document(
        "Uncertainty budget of an angle calibration",
        [*facts, ("calibration", budget.method)],
        blocks,
    )
    return write_document(document, folder, "budget")
