"""Collects the content of the page of ``arctrue paper`` as plain values: equations, tables,
figures, experiment."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from typing import Any

from arctrue.studies.paper.equations import EQUATIONS, Item


def paper_items(experiments: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the content of the page as a mapping for JSON.

    ``experiments``: values of ``ExperimentResult.as_json()``; the experiment with the finest counts
    comes first. Raises ValueError without an experiment.
    """
    if not experiments:
        raise ValueError("the page needs at least one run of the experiment")
    finest_first = sorted(
        experiments, key=lambda one: -one["settings"]["revolution"]["interpolation"]
    )
    return {
        "schema": 1,
        "items": [dataclasses.asdict(item) for item in _items(finest_first[0])],
        "experiments": [dict(one) for one in finest_first],
    }


def _items(experiment: Mapping[str, Any]) -> list[Item]:
    """Return the items in the paper's order; (13), (16), (17) and Table 3 come from the
    experiment."""
    worked_out = [make() for make in EQUATIONS]
    largest = max(experiment["after"]["deviation_arcsec"])
    budget = experiment["budget"]
    measured = [
        Item(
            "(13)",
            "σ of ten readings of a face by Bessel's formula; the largest σ is ≤ 0.2″",
            f"the largest σ of the 24 faces is {largest:.2f}″",
            "`arctrue paper`",
            {"largest_arcsec": largest},
        ),
        Item(
            "(16), (17)",
            "u = 0.23″, U = 0.46″ (k = 2)",
            f"u = {budget['combined_arcsec']:.2f}″, U = {budget['expanded_arcsec']:.2f}″ "
            "(smaller, because u₃, the mean σ of the faces, is smaller)",
            "`arctrue paper`",
            {"u_arcsec": budget["combined_arcsec"], "U_arcsec": budget["expanded_arcsec"]},
        ),
    ]
    by_label = {item.label: item for item in (*worked_out, *measured)}
    order = (
        "(1)", "(2), (3)", "(4), (5)", "(6)", "(7)", "(8)", "(9)", "(10), (11)", "(12)", "(13)",
        "(14), (15)", "(16), (17)", "(A.1)", "(A.2)", "(A.3), (A.4)", "(A.5)", "Table 1",
        "Table 2", "section 4",
    )  # fmt: skip
    return [by_label[label] for label in order]
