"""Which sets a benchmark holds: tiers, seeds, and the seal of what was fixed before the seeds."""

from __future__ import annotations

import hashlib
import json
import secrets
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.studies.benchmark.subject import SUBJECTS
from arctrue.studies.benchmark.worlds import CONTENTS, SAMPLES_A_RUN, WORLDS
from arctrue.studies.campaign import Campaign, Sources, Task
from arctrue.whole_file import write_whole_text

PACKAGE = Path(__file__).resolve().parents[2]
GENERATOR = (
    "table",
    "studies/simulate",
    "studies/benchmark/worlds.py",
    "studies/benchmark/sets.py",
    "studies/benchmark/plan.py",
)
SCORING = tuple(
    f"studies/benchmark/{name}.py" for name in ("oracle", "outcome", "intervals", "score")
)
FILE = "plan.json"
WORK = "arctrue.studies.benchmark.work:run_set"
SHARES = {"nothing": 0.28, "one": 0.40, "parts": 0.06, "stranger": 0.12, "several": 0.14}
"""Of the sets of each world. Of 6,600 sets: 308 with nothing a world, 2,640 with one cause of the
catalogue, 1,188 with what is in none, 924 with two or three."""


@dataclass(frozen=True, slots=True)
class Tier:
    """How many sets, how large, and from which seed."""

    sets: int
    samples: int
    """A run."""
    seed: int | None
    """None: drawn when the plan is made, after everything else is fixed."""


TIERS = {
    "quick": Tier(60, SAMPLES_A_RUN // 4, 1),
    "dev": Tier(600, SAMPLES_A_RUN, 2),
    "public": Tier(200, SAMPLES_A_RUN, 3),
    "sealed": Tier(6_600, SAMPLES_A_RUN, None),
}


class PlanError(ValueError):
    """A plan that is not there, or was made by another state of the generator or the scoring."""


@dataclass(frozen=True, slots=True)
class Plan:
    """A tier with its seed, and the digests of what was fixed before the seed was drawn."""

    tier: str
    sets: int
    samples: int
    seed: int
    generator: str
    """Causes, noise, experiments, worlds, priors and shares."""
    scoring: str
    """The oracle and the thresholds."""

    def tasks(self, subject: str) -> list[Task]:
        """Every set as a task, worlds in turn."""
        found: list[Task] = []
        by_world = {
            world: _contents(self.sets // len(WORLDS) + (place < self.sets % len(WORLDS)))
            for place, world in enumerate(WORLDS)
        }
        longest = max(len(contents) for contents in by_world.values())
        for number in range(longest):
            for world, contents in by_world.items():
                if number < len(contents):
                    entropy = np.random.SeedSequence([self.seed, len(found)])
                    high, low = entropy.generate_state(2, np.uint32)
                    found.append(
                        {
                            "world": world,
                            "content": contents[number],
                            # 53 bits: a whole number in every reader of JSON.
                            "seed": (int(high) >> 11) * 2**32 + int(low),
                            "samples": self.samples,
                            "subject": subject,
                        }
                    )
        return found

    def campaign(self, folder: Path, subject: str) -> Campaign:
        """The campaign of one subject. Raises PlanError where the code is another than sealed."""
        self.check()
        facts = {"plan": asdict(self), "subject": subject}
        sources = sources_of(subject)
        return Campaign(WORK, self.tasks(subject), folder / subject, facts, sources=sources)

    def check(self) -> None:
        """Raise PlanError where generator or scoring are not those that the plan was made with."""
        for what, files in (("generator", GENERATOR), ("scoring", SCORING)):
            if getattr(self, what) != files_digest(files):
                raise PlanError(
                    f"the {what} has changed since the plan was made "
                    f"({getattr(self, what)} then, {files_digest(files)} now): make a new plan"
                )


def _contents(number: int) -> list[str]:
    """``number`` contents in their shares, spread evenly (largest remainder at every step)."""
    found: list[str] = []
    given = dict.fromkeys(CONTENTS, 0)
    for step in range(1, number + 1):
        owed = {content: SHARES[content] * step - given[content] for content in CONTENTS}
        content = max(owed, key=owed.__getitem__)
        given[content] += 1
        found.append(content)
    return found


def sources_of(subject: str) -> Sources:
    """What the answers of a subject depend on: for a rival, not on the diagnosis."""
    who = SUBJECTS[subject]
    modules = () if who.whole_package else (WORK.partition(":")[0], who.module)
    return Sources(modules, who.libraries)


def files_digest(names: tuple[str, ...]) -> str:
    """The first 16 hex digits of SHA-256 over the Python files of the package so named."""
    whole = hashlib.sha256()
    for name in names:
        place = PACKAGE / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            whole.update(str(file.relative_to(PACKAGE)).encode() + b"\0" + file.read_bytes())
    return whole.hexdigest()[:16]


def make_plan(tier: str, folder: Path) -> Plan:
    """Write the plan of a tier into ``folder``: digests first, then the seed.

    Raises PlanError where the folder has another plan.
    """
    chosen = TIERS[tier]
    generator, scoring = files_digest(GENERATOR), files_digest(SCORING)
    seed = secrets.randbits(64) if chosen.seed is None else chosen.seed
    plan = Plan(tier, chosen.sets, chosen.samples, seed, generator, scoring)
    path = folder / FILE
    if path.exists() and (chosen.seed is None or read_plan(folder) != plan):
        raise PlanError(f"{path} is there already; take a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    write_whole_text(path, json.dumps(asdict(plan), indent=1) + "\n")
    return plan


def read_plan(folder: Path) -> Plan:
    """The plan of a folder. Raises PlanError where there is none."""
    path = folder / FILE
    try:
        data: dict[str, Any] = json.loads(path.read_text(encoding="utf-8"))
        return Plan(**data)
    except FileNotFoundError:
        raise PlanError(f"{path} is not there: first arctrue benchmark make {folder}") from None
    except (ValueError, TypeError) as error:
        raise PlanError(f"{path}: no plan: {error}") from None
