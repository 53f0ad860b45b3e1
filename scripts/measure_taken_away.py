"""Measures what the exported lanes leave of every effect, and writes docs/data/taken_away.json.

Run ``python -m scripts.measure_taken_away``, some minutes; docs/effects.md is made from the file by
``python -m scripts.make_effects_page``.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections.abc import Sequence
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


def main(arguments: Sequence[str] | None = None) -> int:
    """Measure the effects that are named, or all; returns the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("effects", nargs="*", help="measure these alone", metavar="EFFECT")
    chosen = parser.parse_args(arguments).effects
    unknown = sorted(set(chosen) - set(built_in()))
    if unknown:
        parser.error(f"no effect is named {unknown[0]}; there are: {', '.join(built_in())}")
    rows = stored()["effects"] if chosen and STORED.exists() else {}
    for name in chosen or built_in():
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
