"""Writes the digests of the public sets anew, after the generator was changed on purpose.

Results of the peers on the earlier sets are worth nothing then: run make peers again.
"""

from __future__ import annotations

import json
import os

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from arctrue.studies.benchmark.digests import set_name
from arctrue.studies.benchmark.frozen import FILE, TIER, task_digest
from arctrue.studies.benchmark.plan import TIERS, Plan
from arctrue.whole_file import write_whole_text


def main() -> None:
    """Make all 200 sets, about a minute."""
    tier = TIERS[TIER]
    assert tier.seed is not None
    tasks = Plan(TIER, tier.sets, tier.samples, tier.seed, "", "").tasks("")
    digests = {set_name(task): task_digest(task) for task in tasks}
    text = json.dumps({"tier": TIER, "seed": tier.seed, "sets": digests}, indent=1, sort_keys=True)
    write_whole_text(FILE, text + "\n")
    print(f"{len(digests)} digests: {FILE}")


if __name__ == "__main__":
    main()
