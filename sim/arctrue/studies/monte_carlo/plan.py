"""Makes the trials of a Monte Carlo calculation as tasks of a campaign."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from arctrue.studies.campaign import Campaign, Sources, Task
from arctrue.studies.monte_carlo.inputs import CASES

WORK = "arctrue.studies.monte_carlo.trial:run_trial"
BATCH = 10


@dataclass(frozen=True, slots=True)
class TrialPlan:
    """Number of trials of every case, and the size of each measurement."""

    trials: int
    seed: int
    turns: int = 1
    """Number of turns in a run."""
    runs: int = 2
    samples: int = 6_000
    """Number of samples in a turn."""
    method: str = "least_squares"

    def tasks(self) -> list[Task]:
        """Return the tasks; all cases of a trial have the same seed, which determines table and
        inputs."""
        seeds = [
            int(np.random.SeedSequence([self.seed, number]).generate_state(1, np.uint32)[0])
            for number in range(self.trials)
        ]
        return [
            {
                "case": case,
                "trial": number,
                "seed": seed,
                "turns": self.turns,
                "runs": self.runs,
                "samples": self.samples,
                "method": self.method,
            }
            for number, seed in enumerate(seeds)
            for case in CASES
        ]

    def campaign(self, folder: Path) -> Campaign:
        """Return the campaign whose results are in ``folder``."""
        sources = Sources((WORK.partition(":")[0],))
        return Campaign(WORK, self.tasks(), folder, {"plan": asdict(self)}, BATCH, sources)
