"""Tests of the picture on the benchmark's page: its matrix of names and its curve of
probabilities."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from arctrue.report.charts.benchmark_picture import confusion_matrix, plot_benchmark

CONFUSION = {
    "flat_track": {"unknown": 2},
    "latency": {"latency": 4, "timing_skew": 1},
    "nothing": {"adequate": 7, "unknown": 1},
    "timing_skew": {"ambiguous (in class)": 1, "timing_skew": 3},
}


def test_right_names_stand_on_the_diagonal_and_every_set_is_counted_once() -> None:
    rows, columns, counts = confusion_matrix(CONFUSION)
    assert rows == ["latency", "timing_skew", "flat_track", "nothing"]
    assert columns == ["latency", "timing_skew", "ambiguous (in class)", "adequate", "unknown"]
    assert np.diag(counts)[:2].tolist() == [4, 3]
    assert counts[0, 1] == 1
    assert counts.sum() == sum(sum(said.values()) for said in CONFUSION.values())


def test_picture_holds_every_count_and_the_curve_only_where_there_is_one(tmp_path: Path) -> None:
    bins = [
        {"mean_probability": 0.5, "hits": 1, "of": 2, "rate": 0.5, "low": 0.013, "high": 0.987},
        {"mean_probability": 0.99, "hits": 17, "of": 17, "rate": 1.0, "low": 0.805, "high": 1.0},
    ]
    shown_text = {}
    for name, stated in (("with", {"reliability": bins}), ("without", None)):
        found = {"confusion": CONFUSION, "probability": stated}
        path = plot_benchmark(found, tmp_path / name)
        tree = ElementTree.parse(path)
        shown_text[name] = [
            "".join(item.itertext()).strip() for item in tree.iter() if "text" in item.tag
        ]
    for name in CONFUSION:
        assert name in shown_text["with"]
    assert shown_text["with"].count("7") == 1
    assert "17 sets" in shown_text["with"]
    assert "17 sets" not in shown_text["without"]
