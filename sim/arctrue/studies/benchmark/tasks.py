"""Which worlds, contents and seeds the sets of a plan have."""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.worlds import CONTENTS, WORLDS
from arctrue.studies.campaign.task import Task

SHARES = {"nothing": 0.28, "one": 0.40, "parts": 0.06, "stranger": 0.12, "several": 0.14}
"""Of the sets of each world. Of 6,600 sets: 308 with nothing a world, 2,640 with one cause of the
catalogue, 1,188 with what is in none, 924 with two or three."""


def set_tasks(sets: int, samples: int, seed: int, subject: str) -> list[Task]:
    """Every set as a task, worlds in turn; ``samples`` a run at most, ``subject``: who answers."""
    found: list[Task] = []
    by_world = {
        world: _contents(sets // len(WORLDS) + (place < sets % len(WORLDS)))
        for place, world in enumerate(WORLDS)
    }
    longest = max(len(contents) for contents in by_world.values())
    for number in range(longest):
        for world, contents in by_world.items():
            if number < len(contents):
                entropy = np.random.SeedSequence([seed, len(found)])
                high, low = entropy.generate_state(2, np.uint32)
                found.append(
                    {
                        "world": world,
                        "content": contents[number],
                        # 53 bits: a whole number in every reader of JSON.
                        "seed": (int(high) >> 11) * 2**32 + int(low),
                        "samples": samples,
                        "subject": subject,
                    }
                )
    return found


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
