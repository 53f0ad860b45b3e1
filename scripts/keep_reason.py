"""Keeps why the diagnosis fails on a case: it then stands beside the failure on docs/blind.md.

python -m scripts.keep_reason --world few_data --content one --seed 123 --said unknown "…"

``--said`` is the answer of which the reason tells, in the words of the page (what stands in
brackets after the outcome); without it that with which the case was kept.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Sequence

from arctrue.studies.benchmark.cases import (
    NoSuchCaseError,
    Reason,
    kept_cases,
    write_reason,
)
from arctrue.studies.benchmark.worlds import CONTENTS, WORLDS


def main(arguments: Sequence[str] | None = None) -> int:
    """Write it; exit code 1 where there is no such case."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--world", choices=list(WORLDS), required=True, help="world of the set")
    parser.add_argument(
        "--content", choices=CONTENTS, required=True, help="what is hidden in the set"
    )
    parser.add_argument("--seed", type=int, required=True, help="seed of the set")
    parser.add_argument("--said", help="the answer that is explained")
    parser.add_argument("why", help="the reason, in one or two sentences")
    given = parser.parse_args(arguments)
    said = given.said or next(
        (case["found"]["said"] for case in kept_cases() if case["seed"] == given.seed), ""
    )
    try:
        case = write_reason(given.world, given.content, given.seed, Reason(said, given.why.strip()))
    except NoSuchCaseError as error:
        print(error, file=sys.stderr)
        return 1
    print(f"{', '.join(case['found']['hidden']) or 'nothing'}, said {said}: {given.why.strip()}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
