"""Reads which part of the device corrects each effect, as measured on simulated tables by
``scripts/measure_taken_away.py``; docs/effects.md and the demo's last page show the result."""

from __future__ import annotations

import json
from dataclasses import dataclass
from typing import Any

from arctrue.base.source_tree import ROOT

STORED = ROOT / "docs" / "data" / "taken_away.json"

TAKEN = {
    "lanes": "lanes",
    "firmware's model": "the firmware's model: lanes at the table's temperature",
    "lanes by condition": "lanes of a bitstream with `MODULATORS`",
    "lanes of real orders": "lanes of a bitstream with `REAL_ORDERS`",
    "local table": "the table of a bitstream with `LOCAL_TABLE`",
    "the mean": "the weighted mean of a bitstream with four heads",
    "nothing": "nothing",
    "not in the output": (
        "no correction needed: in this simulation only head 2 has the error, and the output does "
        "not contain head 2"
    ),
    "reference": "no correction needed: the reference has the error, the table does not",
}
"""Words for each part of the device, by its name in the export."""


@dataclass(frozen=True, slots=True)
class CorrectedEffect:
    """An effect that a part of the device corrects; errors are RMS values in arcseconds."""

    effect: str
    simulated: str
    """Size and unit of the cause in the simulation."""
    without_arcsec: float
    """Error of head 1 that remains with a model without the effect."""
    left_arcsec: float
    """Error that remains with the effect in the model: of the mean if ``by`` is the mean, otherwise
    of head 1."""
    by: str


@dataclass(frozen=True, slots=True)
class TakenAwayTable:
    """All measured effects, in three groups: corrected, not corrected, no error of the output."""

    corrected: tuple[CorrectedEffect, ...]
    left: tuple[str, ...]
    """Effects that no part of the device corrects."""
    no_error: tuple[str, ...]
    """Effects that add no error to the output."""


def stored() -> dict[str, Any]:
    """Return the figures that the last run of the script stored."""
    found: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return found


def taken_away_table() -> TakenAwayTable:
    """Return the stored figures in the three groups of the table."""
    rows = {name: _with_four_heads(row) for name, row in stored()["effects"].items()}
    none = ("not in the output", "reference")
    return TakenAwayTable(
        tuple(
            CorrectedEffect(
                name,
                row["simulated"],
                row["left_without_arcsec"],
                row["left_with_arcsec"],
                TAKEN[row["taken_away_by"]].replace("`", ""),
            )
            for name, row in rows.items()
            if row["taken_away_by"] not in ("nothing", *none)
        ),
        tuple(name for name, row in rows.items() if row["taken_away_by"] == "nothing"),
        tuple(name for name, row in rows.items() if row["taken_away_by"] in none),
    )


def _with_four_heads(row: dict[str, Any]) -> dict[str, Any]:
    """Return the row with the remaining error of the mean of four heads, if a device with two heads
    does not correct the effect and this error was measured."""
    left = row.get("left_in_mean_arcsec")
    if left is None or row["taken_away_by"] != "nothing":
        return row
    return {**row, "left_with_arcsec": left, "taken_away_by": "the mean"}
