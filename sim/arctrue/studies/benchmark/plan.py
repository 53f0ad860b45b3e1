"""Plans the sets of a benchmark: the tier, the seed, and digests of the code that are fixed before
the seed is drawn."""

from __future__ import annotations

import hashlib
import json
import secrets
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from arctrue.base.read_errors import unreadable
from arctrue.base.typed_content import ContentError, read_json
from arctrue.base.whole_file import write_whole_text
from arctrue.studies.benchmark.cases import case_tasks, kept_cases
from arctrue.studies.benchmark.score import INDEPENDENT, SIMULATED
from arctrue.studies.benchmark.subject import SUBJECTS
from arctrue.studies.benchmark.tasks import independent_tasks, mixed_tasks, set_tasks
from arctrue.studies.benchmark.worlds import SAMPLES_A_RUN
from arctrue.studies.campaign import Campaign, Sources, Task

PACKAGE = Path(__file__).resolve().parents[2]
GENERATOR = (
    "table",
    "studies/simulate",
    "studies/benchmark/worlds.py",
    "studies/benchmark/sets.py",
    "studies/benchmark/tasks.py",
    "studies/benchmark/independent",
)
SCORING = tuple(
    f"studies/benchmark/{name}.py" for name in ("oracle", "outcome", "intervals", "score")
)
FILE = "plan.json"
WORK = "arctrue.studies.benchmark.work:run_set"


@dataclass(frozen=True, slots=True)
class Tier:
    """Tier of the benchmark: the number of sets, their size, and the seed."""

    sets: int
    samples: int
    """Largest number of samples in a run."""
    seed: int | None
    """Seed; if None, it is drawn when the plan is made, after the code's digests are fixed."""
    frozen: bool = False
    """Whether digests identify the sets, so that a change of the generator's code is permitted."""


CASES = "cases"
"""Name of the tier with the sets on which the diagnosis once failed."""
TIERS = {
    "quick": Tier(65, SAMPLES_A_RUN // 4, 1),
    "dev": Tier(650, SAMPLES_A_RUN, 2),
    "calibration": Tier(195, SAMPLES_A_RUN, 4),
    "public": Tier(216, SAMPLES_A_RUN, 3, frozen=True),
    "sealed": Tier(7_150, SAMPLES_A_RUN, None),
    CASES: Tier(len(kept_cases()), SAMPLES_A_RUN, 0),
}


SOURCES = {SIMULATED: set_tasks, INDEPENDENT: independent_tasks, "both": mixed_tasks}
"""Functions that return the tasks, by the name of the generator: the simulated table, the package
``independent``, or both."""


class PlanError(ValueError):
    """Raised if there is no valid plan, if the arguments of a new plan are not permitted, or if the
    code of the generator or of the scoring has changed since the plan was made."""


@dataclass(frozen=True, slots=True)
class TierPlan:
    """Tier with its seed, and the digests of the code that were computed before the seed was
    drawn."""

    tier: str
    sets: int
    samples: int
    seed: int
    generator: str
    """Digest of the code for causes, noise, experiments, worlds, priors and shares."""
    scoring: str
    """Digest of the code for the oracle and the thresholds."""
    source: str = SIMULATED
    """Generator that makes the sets: one of SOURCES."""

    def tasks(self, subject: str) -> list[Task]:
        """Return every set as a task; the worlds alternate."""
        if self.tier == CASES:
            return case_tasks(subject)
        if self.source not in SOURCES:
            raise PlanError(f"source: expected one of {', '.join(SOURCES)}, found {self.source!r}")
        return SOURCES[self.source](self.sets, self.samples, self.seed, subject)

    def campaign(self, folder: Path, subject: str) -> Campaign:
        """Make the campaign of one subject. Raises PlanError if the code has changed since the plan
        was made."""
        self.check()
        facts = {"plan": asdict(self), "subject": subject}
        sources = sources_of(subject)
        return Campaign(WORK, self.tasks(subject), folder / subject, facts, sources=sources)

    def check(self) -> None:
        """Raise PlanError if the code has changed since the plan was made.

        The method compares the code of the generator and, if the seed was drawn, also the code of
        the scoring; a tier with a public seed may be scored again with new code. Frozen sets are
        identified by their digests.
        """
        sealed: list[tuple[str, tuple[str, ...]]] = []
        if not TIERS[self.tier].frozen:
            sealed.append(("generator", GENERATOR))
        if TIERS[self.tier].seed is None:
            sealed.append(("scoring", SCORING))
        for what, files in sealed:
            if getattr(self, what) != files_digest(files):
                raise PlanError(
                    f"the {what} has changed since the plan was made "
                    f"({getattr(self, what)} then, {files_digest(files)} now): make a new plan"
                )


def sources_of(subject: str) -> Sources:
    """Return the code on which a subject's answers to given sets depend.

    The answers of a rival do not depend on the diagnosis.
    """
    who = SUBJECTS[subject]
    return Sources(() if who.whole_package else (who.module,), who.libraries)


def files_digest(names: tuple[str, ...]) -> str:
    """Return the first 16 hex digits of SHA-256 over the named Python files of the package."""
    whole = hashlib.sha256()
    for name in names:
        place = PACKAGE / name
        for file in sorted(place.rglob("*.py")) if place.is_dir() else [place]:
            whole.update(str(file.relative_to(PACKAGE)).encode() + b"\0" + file.read_bytes())
    return whole.hexdigest()[:16]


def make_plan(
    tier: str,
    folder: Path,
    source: str = SIMULATED,
    limit: int | None = None,
    seed: int | None = None,
    samples: int | None = None,
) -> TierPlan:
    """Write the plan of a tier into ``folder``: digests first, then the seed.

    ``limit`` keeps only the first sets; ``seed`` and ``samples`` replace the values of the tier.
    Raises PlanError in three cases: the folder has another plan, or any plan if the seed is drawn;
    an argument would change the sets of a frozen tier or of the tier of cases; a seed is given for
    a tier whose seed is drawn.
    """
    chosen = TIERS[tier]
    changed = source != SIMULATED or (limit, seed, samples) != (None, None, None)
    if changed and (chosen.frozen or tier == CASES):
        raise PlanError(
            f"the sets of the tier {tier} are given: no generator, limit, samples or seed"
        )
    if seed is not None:
        if chosen.seed is None:
            raise PlanError(f"the seed of the tier {tier} is drawn after everything else is fixed")
        chosen = replace(chosen, seed=seed)
    if samples is not None:
        chosen = replace(chosen, samples=samples)
    if limit is not None:
        chosen = replace(chosen, sets=min(limit, chosen.sets))
    generator, scoring = files_digest(GENERATOR), files_digest(SCORING)
    found = secrets.randbits(64) if chosen.seed is None else chosen.seed
    plan = TierPlan(tier, chosen.sets, chosen.samples, found, generator, scoring, source)
    path = folder / FILE
    if path.exists() and (chosen.seed is None or read_plan(folder) != plan):
        raise PlanError(f"{path} is there already; take a new folder")
    folder.mkdir(parents=True, exist_ok=True)
    write_whole_text(path, json.dumps(asdict(plan), indent=1) + "\n")
    return plan


def read_plan(folder: Path) -> TierPlan:
    """Read the plan of a folder. Raises PlanError if there is none or if it is invalid."""
    path = folder / FILE
    try:
        return read_json(path, TierPlan)
    except OSError as error:
        why = unreadable(error, f"first arctrue benchmark make {folder}")
        raise PlanError(f"{path}: {why}") from None
    except ContentError as error:
        raise PlanError(str(error)) from None
