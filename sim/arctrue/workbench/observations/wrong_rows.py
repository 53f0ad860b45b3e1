"""Finds single wrong rows in a model's residual; in the measured values themselves, the errors that
the model contains would hide such rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.outliers.masked_row import MaskedRow
from arctrue.workbench.observations.outliers.single_rows import MOST_SHARE, capture_outliers

Float = NDArray[np.float64]


def without_wrong_rows(
    observations: Observations, left_arcsec: Float | None
) -> Observations | None:
    """Return the observations without capture rows that are single outliers in a model's residual.

    ``left_arcsec``: residual of each capture row, (rows,). The result is None if there is no such
    row, if the set itself decides which rows are used, or if so many rows are outliers that the
    recording is faulty. A long capture keeps all rows: one wrong row in 150,000 changes no result.
    """
    rows, count = observations.capture, observations.count_arcsec
    if rows is None or count is None or left_arcsec is None or not observations.may_mask:
        return None
    if observations.stored is not None or rows.revolution.size != rows.run.size:
        return None
    wrong, away = capture_outliers(
        left_arcsec,
        rows.angle_rad,
        rows.revolution,
        run_spans(rows.run),
        observations.head_separation_rad,
        count,
    )
    if not wrong.any() or float(wrong.mean()) > MOST_SHARE:
        return None
    sample = observations.capture_sample
    if sample is not None:
        # If one row of a sample is wrong, the rows of all its channels are omitted; the sample is
        # listed once.
        _, first = np.unique(sample[wrong], return_index=True)
        listed = np.flatnonzero(wrong)[first]
        wrong = np.isin(sample, sample[wrong])
    else:
        listed = np.flatnonzero(wrong)
    masked = [
        MaskedRow("capture", observations.capture_line(row), "outlier", float(away[row]))
        for row in listed.tolist()
    ]
    used = observations.used_capture_rows
    if sample is None:
        used = (np.arange(rows.run.size) if used is None else used)[~wrong]
    of_capture = [item for item in observations.masked if item.channel == "capture"]
    of_reference = [item for item in observations.masked if item.channel == "reference"]
    return replace(
        observations,
        capture=rows.part(~wrong),
        masked=(*sorted([*of_capture, *masked], key=_line), *of_reference),
        used_capture_rows=used,
        capture_sample=None if sample is None else sample[~wrong],
    )


def _line(row: MaskedRow) -> int:
    return row.row
