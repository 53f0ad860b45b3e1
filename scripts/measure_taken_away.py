"""Measures what the exported lanes leave of every effect, and writes docs/data/taken_away.json.

Run ``python -m scripts.measure_taken_away``, some minutes; docs/effects.md is made from the file by
``python -m scripts.make_effects_page``. Names of effects as arguments measure these alone.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

from arctrue.studies.taken_away import FRESH_C, SEED, measure
from arctrue.whole_file import write_whole_text
from arctrue.workbench.effects.registry import built_in

STORED = Path(__file__).resolve().parents[1] / "docs" / "data" / "taken_away.json"


def stored() -> dict[str, Any]:
    """What the last run measured."""
    found: dict[str, Any] = json.loads(STORED.read_text(encoding="utf-8"))
    return found


def main() -> int:
    """Measure the effects that are named, or all; returns the exit code."""
    chosen = sys.argv[1:] or list(built_in())
    rows = stored()["effects"] if sys.argv[1:] and STORED.exists() else {}
    for name in chosen:
        row = measure(name).data()
        del row["effect"]
        rows[name] = row
        print(name, row, flush=True)
    ordered = {name: rows[name] for name in built_in() if name in rows}
    found = {"schema": 1, "seed": SEED, "temperature_c": FRESH_C, "effects": ordered}
    write_whole_text(STORED, json.dumps(found, indent=1, ensure_ascii=False) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
