"""Draws the benchmark's confusion matrix, and how reliable the probabilities of the answers are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from arctrue.report.picture_file import save_picture
from arctrue.report.svg import AFTER, INK, LIMIT, house_style

PICTURE = "benchmark.svg"
CLASSES_LAST = ("one of them", "adequate", "cannot_tell", "unknown", "bad_data", "error")
"""Last columns of the matrix, after the columns of ambiguous answers: a right name of one of
several causes, then the answers without a name.
"""


def plot_benchmark(found: Mapping[str, Any], folder: Path) -> Path:
    """Draw the confusion matrix and, if probabilities are stated, the reliability curve.

    ``found``: content of the file that ``arctrue benchmark score --json`` writes.
    """
    stated = found["probability"]
    with house_style():
        figure = Figure(figsize=(9.6, 13.2 if stated else 9.6), layout="constrained")
        heights = [5, 2] if stated else [1]
        panels = figure.subplots(len(heights), 1, squeeze=False, height_ratios=heights)
        matrix, *curve = panels[:, 0]
        _confusion(matrix, found["confusion"])
        if stated:
            _reliability(curve[0], stated["reliability"])
        return save_picture(figure, folder / PICTURE)


def confusion_matrix(
    confusion: Mapping[str, Mapping[str, int]],
) -> tuple[list[str], list[str], NDArray[np.int64]]:
    """Return the number of answers by hidden cause and answer, as an array (hidden, answered).

    Row and column of the same name have the same number, so the right names lie on the diagonal.
    """
    hidden = list(confusion)
    said = {answer for answers in confusion.values() for answer in answers}
    named = [name for name in hidden if name in said]
    classes = sorted(name for name in said if name.startswith("ambiguous"))
    last = [name for name in CLASSES_LAST if name in said]
    others = sorted(said - set(named) - set(classes) - set(last))
    columns = [*named, *others, *classes, *last]
    rows = [*named, *(name for name in hidden if name not in named)]
    counts = [[confusion[row].get(column, 0) for column in columns] for row in rows]
    return rows, columns, np.array(counts, dtype=np.int64).reshape(len(rows), len(columns))


def _confusion(axes: Axes, confusion: Mapping[str, Mapping[str, int]]) -> None:
    rows, columns, counts = confusion_matrix(confusion)
    share = counts / np.maximum(counts.sum(axis=1, keepdims=True), 1)
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto", interpolation="nearest")
    for row, column in np.argwhere(counts):
        axes.text(
            column, row, str(counts[row, column]), ha="center", va="center", fontsize=7,
            color="white" if share[row, column] > 0.6 else INK,
        )  # fmt: skip
    axes.set_xticks(range(len(columns)), columns, rotation=90, fontsize=7)
    axes.set_yticks(range(len(rows)), rows, fontsize=7)
    axes.set_xlabel("said")
    axes.set_ylabel("hidden")
    axes.grid(visible=False)
    axes.set_title(
        "Sets by hidden cause (row) and answer (column), shaded by their share of the row"
    )


def _reliability(axes: Axes, bins: list[Mapping[str, Any]]) -> None:
    at = np.array([item["mean_probability"] for item in bins])
    rate = np.array([item["rate"] for item in bins])
    low, high = (np.array([item[name] for item in bins]) for name in ("low", "high"))
    axes.plot([0.0, 1.0], [0.0, 1.0], color=LIMIT, linewidth=1.0, label="as stated")
    axes.errorbar(
        at, rate, yerr=[rate - low, high - rate], fmt="o-", color=AFTER, capsize=3,
        label="found, with the interval of 95 %",
    )  # fmt: skip
    for place, height, item in zip(at, rate, bins, strict=True):
        axes.annotate(
            f"{item['of']} sets", (place, height), (6, -10), textcoords="offset points", fontsize=7
        )
    axes.set_xlim(0.0, 1.05)
    axes.set_ylim(-0.02, 1.05)
    axes.set_xlabel("largest stated probability, mean of each tenth of the sets")
    axes.set_ylabel("share that is right")
    axes.set_title("Reliability of the probabilities")
    axes.legend(loc="upper left", fontsize=8)
