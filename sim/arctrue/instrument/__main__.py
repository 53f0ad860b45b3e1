"""Builds the library of one instrument and prints its path: ``python -m arctrue.instrument``."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from arctrue.base.source_tree import ROOT
from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT, LANES_DEFAULT
from arctrue.instrument.build import build
from arctrue.instrument.errors import InstrumentError


def main(arguments: Sequence[str] | None = None) -> None:
    """Build the library of an instrument and print its path; exit code 1 if it cannot be built."""
    parser = argparse.ArgumentParser(prog="arctrue.instrument", description=__doc__)
    parser.add_argument(
        "--lanes", type=int, default=LANES_DEFAULT, help=f"lanes of the core ({LANES_DEFAULT})"
    )
    parser.add_argument(
        "--capture-depth",
        type=int,
        default=CAPTURE_DEPTH_DEFAULT,
        help=f"samples a bank ({CAPTURE_DEPTH_DEFAULT:,})",
    )
    parser.add_argument(
        "--modulators", action="store_true", help="lanes that follow direction, speed or a word"
    )
    asked = parser.parse_args(arguments)
    generics = {"MODULATORS": "true"} if asked.modulators else None
    try:
        library = build(asked.lanes, asked.capture_depth, generics=generics, report_step=print)
    except InstrumentError as error:
        sys.exit(f"instrument: {error}")
    print(f"Instrument: {library.relative_to(ROOT)}")


if __name__ == "__main__":
    main()
