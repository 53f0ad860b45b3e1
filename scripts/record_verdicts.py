"""Records the diagnosis of 40 benchmark sets: python -m scripts.record_verdicts.

``--check`` compares the diagnosis of all sets with the record and writes nothing; use ``--check``
after a change of the code that must not change verdicts. After a change that is meant to change
verdicts, write a new record and review its differences.
"""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from sim.tests.workbench.recorded_verdicts import (
    RECORD,
    differences,
    line_of,
    recorded,
    tasks,
    verdict_of,
)

from arctrue.base.whole_file import write_whole_text


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the record, or compare the diagnosis with it; return exit code 1 if a verdict
    differs."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="compare, write nothing")
    parser.add_argument("--workers", type=int, default=1, help="processes (default: 1)")
    given = parser.parse_args(arguments)
    with ProcessPoolExecutor(given.workers) as pool:
        found = list(pool.map(verdict_of, tasks()))
    if not given.check:
        write_whole_text(RECORD, "".join(line_of(item) + "\n" for item in found))
        print(f"{len(found)} verdicts: {RECORD}")
        return 0
    before = recorded()
    wrong = [
        f"{item['set']}{text}"
        for item in found
        for text in differences(before.get(item["set"], {}), item)
    ]
    print("\n".join(wrong) or f"{len(found)} verdicts are as recorded")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
