"""Prints the table of docs/scenarios.md: ``python -m arctrue.studies.scenario RUN.json …``."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import Any


def results_table(files: Sequence[Path]) -> str:
    """Return a table in Markdown: a row for each file of ``arctrue run --json``, with its last
    turn."""
    lines = [
        "| Scenario | Turns | Calibrations applied | Turns refused | Uncorrected, RMS "
        "| Corrected, RMS | Single edges, RMS | Mean | Error by the reference, RMS |",
        "|---|--:|--:|--:|--:|--:|--:|--:|--:|",
    ]
    for file in files:
        stored: dict[str, Any] = json.loads(file.read_text(encoding="utf-8"))
        last = stored["turns"][-1]
        before, after = last["uncorrected"], last["corrected"]
        seen = last["reference"]
        shown = f"{seen['rms_arcsec']:.2f}″" if seen else ""
        # Adding 0 converts a negative zero to 0.
        mean = round(after["mean_arcsec"], 2) + 0.0
        lines.append(
            f"| `{file.stem}` | {len(stored['turns'])} | {stored['applied']} | {stored['refused']} "
            f"| {before['rms_arcsec']:.2f}″ | {after['rms_arcsec']:.2f}″ "
            f"| {after['edges_rms_arcsec']:.2f}″ | {mean:.2f}″ | {shown} |"
        )
    return "\n".join(lines)


def main(arguments: Sequence[str] | None = None) -> None:
    """Print the table for the files on the command line."""
    parser = argparse.ArgumentParser(prog="arctrue.studies.scenario", description=__doc__)
    parser.add_argument(
        "files", nargs="+", type=Path, metavar="RUN.json", help="results of arctrue run"
    )
    print(results_table(parser.parse_args(arguments).files))


if __name__ == "__main__":
    main()
