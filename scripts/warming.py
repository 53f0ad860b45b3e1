"""Simulates a rotary table that warms and has thermal eccentricity, and writes the results into
docs/hidden-effect.md.

``python -m scripts.warming full`` measures at the paper's scale (2²⁴ counts, 32 lanes; half an hour
of one processor core), ``python -m scripts.warming small`` at 2¹⁸ counts; ``page`` writes the
stored figures into the page, and ``check`` compares the page with the stored figures. Figures:
docs/data/warming.json.
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
from arctrue.studies.hidden_effect.follow import BY_FIRMWARE, HELD, follow_warming
from arctrue.studies.hidden_effect.settings import HiddenSettings
from scripts.marked_section import MarkedSection

ROOT: Final = Path(__file__).resolve().parents[1]
STORED: Final = ROOT / "docs" / "data" / "warming.json"
PAGE: Final = ROOT / "docs" / "hidden-effect.md"
SECTION: Final = MarkedSection(PAGE, "<!-- made by scripts/warming.py -->\n")
SCALES: Final = {
    "small": (1024, 256, 4, 1200),
    "full": (16384, 1024, 32, 12000),
}
"""Numbers of lines, counts per line, lanes, and samples per turn, by the name of the scale."""
TURNS: Final = 3
LAG_S: Final = 60.0
RUNS: Final = {
    HELD: "the coefficients of the first turn stay active",
    BY_FIRMWARE: "the firmware follows its thermometer",
    "lagging": "the firmware follows a thermometer that lags by 60 s",
}


def measure(scale: str) -> dict[str, Any]:
    """Measure the amplitude of order 1 of the corrected output in each turn, in arcseconds."""
    lines, interpolation, lanes, samples = SCALES[scale]
    settings = HiddenSettings.of_lines(lines, lanes, samples)
    revolution = dataclasses.replace(settings.revolution, interpolation=interpolation)
    settings = dataclasses.replace(settings, revolution=revolution)
    with tempfile.TemporaryDirectory() as folder:
        result = run_hidden(
            CASES["thermal_eccentricity"], settings, Path(folder), report_step=print
        )
        found = follow_warming(result, TURNS, ways=(HELD, BY_FIRMWARE))
        late = follow_warming(result, TURNS, ways=(BY_FIRMWARE,), sensor_lag_s=LAG_S)
    turns = {**found, "lagging": late[BY_FIRMWARE]}
    return {
        "counts_per_rev": lines * interpolation,
        "lanes": lanes,
        "temperature_c": [round(turn.temperature_c, 2) for turn in turns[HELD]],
        "order1_arcsec": {
            run: [round(turn.order1_arcsec, 3) for turn in turns[run]] for run in RUNS
        },
    }


def section(stored: dict[str, Any]) -> str:
    """Return the table of the page."""
    lines = []
    for scale in SCALES:
        if scale not in stored:
            continue
        row = stored[scale]
        heads = " | ".join(f"{celsius:.2f} °C" for celsius in row["temperature_c"])
        title = f"{row['counts_per_rev']:,} counts, {row['lanes']} lanes"
        lines += ["", f"| {title} | {heads} |", f"|---|{'---|' * len(row['temperature_c'])}"]
        for run, words in RUNS.items():
            figures = " | ".join(f"{value:.2f}″" for value in row["order1_arcsec"][run])
            lines.append(f"| {words} | {figures} |")
    return "\n".join(lines[1:]) + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Do the step that the command line names: measure, write the page, or compare it; return the
    exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument(
        "what",
        choices=[*SCALES, "page", "check"],
        help="scale that is measured; or only write the page, or compare it",
    )
    wanted = parser.parse_args(arguments).what
    measured = {wanted: measure(wanted)} if wanted in SCALES else {}
    # Read the file only after the measurement, because a run at the other scale may have added its
    # results meanwhile.
    stored = json.loads(STORED.read_text(encoding="utf-8")) if STORED.exists() else {}
    stored |= measured
    if measured:
        write_whole_text(STORED, json.dumps(stored, indent=1, ensure_ascii=False) + "\n")
    lines = section(stored)
    if wanted == "check":
        if SECTION.is_current(lines):
            return 0
        print(f"{PAGE} differs from {STORED}: python -m scripts.warming page", file=sys.stderr)
        return 1
    SECTION.write(lines)
    return 0


if __name__ == "__main__":
    sys.exit(main())
