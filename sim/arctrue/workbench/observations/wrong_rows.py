"""Finds single wrong rows in a model's residual; in the measured values themselves, the errors that
the model explains would hide such rows."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.runs import run_spans
from arctrue.workbench.observations.observations import Observations
from arctrue.workbench.observations.outliers.masked_row import MaskedRow
from arctrue.workbench.observations.outliers.single_rows import MOST_SHARE, capture_outliers
from arctrue.workbench.observations.rows import CaptureRows

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


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
    if rows.channel is None:
        outlying = capture_outliers(
            left_arcsec,
            rows.angle_rad,
            rows.revolution,
            run_spans(rows.run),
            observations.head_separation_rad,
            count,
        )
    else:
        outlying = _of_each_head(rows, rows.channel, left_arcsec, count)
    wrong, away = outlying
    if not wrong.any() or float(wrong.mean()) > MOST_SHARE:
        return None
    # Samples are counted in the order of the file; two heads have one row per sample.
    sample = observations.capture_sample
    number = np.arange(rows.run.size) if sample is None else sample
    once = number if rows.channel is None else number[rows.channel == 0]
    masked = [
        MaskedRow(
            "capture", observations.sample_line(int(once[place])), "outlier", float(away[place])
        )
        for place in np.flatnonzero(wrong).tolist()
    ]
    # If one head of a sample is wrong, the rows of all its heads are omitted.
    kept = ~np.isin(number, once[wrong])
    used = observations.used_capture_rows
    if sample is None:
        used = (number if used is None else used)[kept]
    of_capture = [item for item in observations.masked if item.channel == "capture"]
    of_reference = [item for item in observations.masked if item.channel == "reference"]
    return replace(
        observations,
        capture=rows.part(kept),
        masked=(*sorted([*of_capture, *masked], key=_line), *of_reference),
        used_capture_rows=used,
        capture_sample=None if sample is None else sample[kept],
    )


def _of_each_head(
    rows: CaptureRows, channel: Integer, left_arcsec: Float, count_arcsec: float
) -> tuple[NDArray[np.bool_], Float]:
    """Return True for samples in which Rᵢ − R₁ of any head i is an outlier, and their distances;
    (samples,).

    The residuals of the contrasts give the residuals of the differences, in which an error of a
    single head or of the disc keeps its shape and its place.
    """
    contrasts = np.stack([left_arcsec[channel == number] for number in range(rows.channels)])
    differences = np.linalg.solve(rows.weights, contrasts)
    once = channel == 0
    angle_rad, revolution = rows.angle_rad[once], rows.revolution[once] // rows.channels
    spans = run_spans(rows.run[once])
    wrong, away = np.zeros(angle_rad.size, dtype=bool), np.zeros(angle_rad.size)
    places_rad = (rows.head_separation_rad, *rows.further_places_rad)
    for difference, place_rad in zip(differences, places_rad, strict=True):
        found, by = capture_outliers(
            difference, angle_rad, revolution, spans, place_rad, count_arcsec
        )
        away = np.where(found & ~wrong, by, away)
        wrong |= found
    return wrong, away


def _line(row: MaskedRow) -> int:
    return row.row
