"""Compares the stated uncertainty with the errors of the random calibrations that ``arctrue
monte-carlo`` made."""

from __future__ import annotations

from pathlib import Path
from typing import Any

from arctrue.studies.campaign import read_results
from arctrue.studies.campaign.store import read_header
from arctrue.studies.monte_carlo.inputs import CASES, INPUTS
from arctrue.studies.monte_carlo.score import scored


def drawn_calibrations(folder: Path) -> dict[str, Any]:
    """Return for each case the number of trials, the RMS of the stated u and of the deviation over
    the turn, and the coverage.

    Raises ValueError for a folder without a trial.
    """
    found = scored([(item.task, item.result) for item in read_results([folder])])
    cases = [
        {
            "case": case,
            "title": _title(case),
            "trials": one["trials"],
            "stated_arcsec": one["turn"]["rms_stated_arcsec"],
            "deviation_arcsec": one["turn"]["rms_deviation_arcsec"],
            "coverage": one["turn"]["rate"],
            "stated_uncertainty": one["turn"]["stated_uncertainty"],
        }
        for case, one in found.items()
        if "turn" in one
    ]
    if not cases:
        raise ValueError(f"{folder}: found no trial; make some by 'arctrue monte-carlo {folder}'")
    return {"plan": read_header(folder)["plan"], "cases": cases}


def _title(case: str) -> str:
    """Return the case's title on the Monte Carlo page."""
    if case == "quantisation":
        return "quantisation alone"
    if case == "all":
        return "all"
    return ", ".join(INPUTS[name].title for name in CASES[case])
