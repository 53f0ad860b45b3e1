"""Counts how often a sure answer of a benchmark run is wrong: python -m scripts.count_sure FOLDER.

An answer is sure where its largest probability is above 0.8. Answers are counted by what has this
probability: the name of an effect, ``unknown`` or ``none``. Two of these counts are constants of
``workbench/diagnose/probabilities.py``.
"""

from __future__ import annotations

import argparse
from collections.abc import Iterable, Sequence
from pathlib import Path

from arctrue.studies.benchmark.answers import judged_sets
from arctrue.studies.benchmark.outcome import Judged

SURE = 0.8
KINDS = ("name", "unknown", "none")


def sure_answers(sets: Iterable[Judged]) -> dict[str, tuple[int, int]]:
    """Numbers of wrong and of all sure answers, by kind."""
    right: dict[str, list[bool]] = {kind: [] for kind in KINDS}
    for item in sets:
        stated, kind = item.first_probability(), item.first_kind()
        if stated is not None and kind is not None and stated[0] > SURE:
            right[kind].append(stated[1])
    return {kind: (found.count(False), len(found)) for kind, found in right.items()}


def main(arguments: Sequence[str] | None = None) -> None:
    """Print a line for each kind."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("folder", type=Path, help="folder of the run")
    parser.add_argument("--subject", default="arctrue", help="whose answers")
    given = parser.parse_args(arguments)
    for kind, (wrong, all_) in sure_answers(
        judged_sets([given.folder], given.subject, None)
    ).items():
        print(f"{kind}: {wrong} of {all_} wrong")


if __name__ == "__main__":
    main()
