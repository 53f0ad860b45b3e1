"""Keeps the failures of a run of the benchmark as cases: python -m scripts.keep_failures FOLDER.

``arctrue benchmark make FOLDER --tier cases`` asks them all again.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

from arctrue.studies.benchmark.answers import judged_sets
from arctrue.studies.benchmark.cases import FILE, keep
from arctrue.studies.benchmark.score import is_failure
from arctrue.studies.campaign.store import COMMIT, read_header


def main(arguments: Sequence[str] | None = None) -> None:
    """Add those that are not cases yet."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="of the run")
    parser.add_argument("--subject", default="arctrue", help="whose answers")
    given = parser.parse_args(arguments)
    commit = read_header(given.folder / given.subject).get(COMMIT)
    failures = list(filter(is_failure, judged_sets([given.folder], given.subject, None)))
    new = keep(failures, commit)
    print(f"{len(failures)} failures, {new} of them new cases: {FILE}")


if __name__ == "__main__":
    main()
