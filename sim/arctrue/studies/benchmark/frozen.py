"""Makes the frozen public sets from their seeds and compares their digests with the stored ones."""

from __future__ import annotations

import json
import tempfile
from collections.abc import Mapping
from pathlib import Path

from arctrue.base.whole_file import write_whole_text
from arctrue.measurement import write_measurement_set
from arctrue.studies.benchmark.digests import folder_digest
from arctrue.studies.benchmark.plan import TIERS, TierPlan
from arctrue.studies.benchmark.sets import make_set
from arctrue.studies.campaign import Task

TIER = "public"
FILE = Path(__file__).with_name("public_sets.json")


def task_digest(task: Task) -> str:
    """Make the set of a task, delete it, and return its digest."""
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place) / "set"
        write_measurement_set(folder, make_set(task).measurement)
        return folder_digest(folder)


def frozen_digests() -> dict[str, str]:
    """Return the digest of each frozen set by its name."""
    found: dict[str, str] = json.loads(FILE.read_text(encoding="utf-8"))["sets"]
    return found


def freeze(digests: Mapping[str, str]) -> None:
    """Store these digests of the frozen sets; stored answers of peers to earlier sets become
    invalid.

    Raises ValueError if the number of digests is not the number of sets of the tier.
    """
    tier = TIERS[TIER]
    if len(digests) != tier.sets:
        raise ValueError(f"{len(digests)} sets cannot be frozen: the tier has {tier.sets}")
    content = {"tier": TIER, "seed": tier.seed, "sets": digests}
    write_whole_text(FILE, json.dumps(content, indent=1, sort_keys=True) + "\n")


def is_public(plan: TierPlan) -> bool:
    """Tell whether a plan has exactly the sets of the public tier."""
    tier = TIERS[TIER]
    return (plan.tier, plan.sets, plan.samples, plan.seed) == (
        TIER,
        tier.sets,
        tier.samples,
        tier.seed,
    )


def differing(digests: Mapping[str, str]) -> list[str]:
    """Return the names of the sets whose digests differ from those of the frozen sets."""
    frozen = frozen_digests()
    return sorted(name for name, found in digests.items() if frozen.get(name) != found)
