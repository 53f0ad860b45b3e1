"""Simulates the hidden effects that depend on a condition, such as the temperature, and writes
their table into docs/hidden-effect.md.

``python -m scripts.conditions_table measure`` runs the effects on the virtual instrument (2¹⁸
counts, some minutes) and writes docs/data/conditions.json and the page; ``page`` writes the page
from the stored figures, and ``check`` compares the page with the stored figures.
"""

from __future__ import annotations

import argparse
import dataclasses
import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Final

from arctrue.base.whole_file import write_whole_text
from arctrue.studies.hidden_effect.cases import CASES
from arctrue.studies.hidden_effect.experiment import run_hidden
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.hidden_effect.settings import HiddenSettings
from scripts.marked_section import MarkedSection

ROOT: Final = Path(__file__).resolve().parents[1]
STORED: Final = ROOT / "docs" / "data" / "conditions.json"
PAGE: Final = ROOT / "docs" / "hidden-effect.md"
SECTION: Final = MarkedSection(PAGE, "<!-- made by scripts/conditions_table.py -->\n")
ROWS: Final = {
    "hysteresis": "polygon faces approached from both directions: error up minus error down",
    "latency": "the speed falls to a half and rises again: largest error",
    "centrifugal_lobes": "0.7 of the measured speed: amplitude of order 3",
    "loose_centre": "turn down: amplitude of order 1",
    "warm_ovality": "2.5 K warmer: amplitude of order 2",
    "all_at_once": "turn down, 2.5 K warmer, speed falls to a half and rises again: largest error",
}
"""Texts of the table for each case: the evaluated turn, and the figures that are compared."""


def small_settings() -> HiddenSettings:
    """Return settings with 2¹⁸ counts a turn and four lanes; a count is 4.9″."""
    settings = HiddenSettings.of_lines(1024, 4, 1200)
    scale = dataclasses.replace(settings.revolution, interpolation=256, orders=12)
    return dataclasses.replace(settings, revolution=scale)


def figures(result: HiddenResult) -> dict[str, Any]:
    """Return the figures of one case that are stored."""
    return {
        "followed": result.export.followed,
        "left_arcsec": {name: round(value, 2) for name, value in result.judged_arcsec().items()},
    }


def measure(names: Sequence[str]) -> dict[str, Any]:
    """Run each case on the virtual instrument; return the figures to store."""
    found = {}
    with tempfile.TemporaryDirectory() as folder:
        for name in names:
            print(f"{name} …", flush=True)
            found[name] = figures(run_hidden(CASES[name], small_settings(), Path(folder) / name))
    return found


def section(stored: dict[str, Any]) -> str:
    """Return the table of the page."""
    lines = [
        "| Hidden effect | Fresh turn: evaluated error | Lanes that follow a condition "
        "| Paper's model | Without these lanes | With these lanes |",
        "|---|---|---|---|---|---|",
    ]
    for name, words in ROWS.items():
        if name in stored:
            row = stored[name]
            left = row["left_arcsec"]
            without = left.get("unit_left_out")
            lanes = "; ".join(text.split(":")[0] for text in row["followed"])
            lines.append(
                f"| `{name}` | {words} | {lanes or 'temperature'} | {left['paper']:.2f}″ | "
                f"{'' if without is None else f'{without:.2f}″'} | {left['corrected']:.2f}″ |"
            )
    return "\n".join(lines) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Do the step that the command line names: measure, write the page, or compare it; return the
    exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "what",
        choices=["measure", "page", "check"],
        help="measure and store; write the table into the page; compare both",
    )
    parser.add_argument("names", nargs="*", choices=[*ROWS, []], help="cases; default: all")
    wanted = parser.parse_args(arguments)
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {}
    if wanted.what == "measure":
        stored |= measure(wanted.names or list(ROWS))
        write_whole_text(STORED, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    lines = section(stored)
    if wanted.what == "check":
        if SECTION.is_current(lines):
            return 0
        print(
            f"{PAGE} differs from {STORED}: python -m scripts.conditions_table page",
            file=sys.stderr,
        )
        return 1
    SECTION.write(lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
