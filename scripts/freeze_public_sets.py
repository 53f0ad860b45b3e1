"""Writes the digests of the public sets anew, after the generator was changed on purpose.

Results of the peers on the earlier sets are worth nothing then: run make peers again.
"""

from __future__ import annotations

import argparse
import json
import os
from collections.abc import Sequence

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.frozen import FILE, TIER, task_digest
from arctrue.studies.benchmark.plan import TIERS, Plan
from arctrue.whole_file import write_whole_text


def main(arguments: Sequence[str] | None = None) -> None:
    """Make all 200 sets, about a minute."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    tier = TIERS[TIER]
    assert tier.seed is not None
    tasks = Plan(TIER, tier.sets, tier.samples, tier.seed, "", "").tasks("")
    digests = {set_name(task): task_digest(task) for task in tasks}
    text = json.dumps({"tier": TIER, "seed": tier.seed, "sets": digests}, indent=1, sort_keys=True)
    write_whole_text(FILE, text + "\n")
    print(f"{len(digests)} digests: {FILE}")


if __name__ == "__main__":
    main()
