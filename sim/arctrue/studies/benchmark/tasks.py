"""Lists the tasks of a benchmark: each task names a world (the disturbances of a set), a content
(its hidden causes) and a seed, from which one set is simulated.

Two generators simulate the sets. The first one uses the causes of ``arctrue.table`` and the worlds
of ``worlds.py``; the second one, the package ``independent``, has its own code and worlds.
"""

from __future__ import annotations

import numpy as np

from arctrue.studies.benchmark.independent.world import HIDDEN, NOTHING, independent_worlds
from arctrue.studies.benchmark.worlds import CONTENTS, FOUR_HEADS, WORLDS
from arctrue.studies.campaign.task import Task

SHARES = {"nothing": 0.28, "one": 0.40, "parts": 0.06, "stranger": 0.12, "several": 0.14}
"""Share of each content in the sets of a world of the first generator: no cause, one cause of the
catalogue, one cause that is a product of parts, one cause that the catalogue does not contain
("stranger"), or two or three causes.

Of 6,600 sets in six worlds, 1,848 have no cause, 2,640 have one cause of the catalogue, 396 have a
product of parts, 792 have a stranger, and 924 have two or three causes.
"""
EVERY_FOUR_HEADS = 13
"""Number n: every n-th set of the first generator has four heads. They are added to the tier with
seeds of their own, so that all other sets stay as they were without four heads."""
FOUR_HEADS_STREAM = 3
"""Number that makes the seeds of the sets of four heads differ from all others."""

EVERY_NULL = 3
"""Number n: in every n-th cycle through the second generator's worlds, a set has no hidden cause if
its world permits sets without one."""
EVERY_INDEPENDENT = 5
"""Number n: if both generators make sets, the second generator makes every n-th set."""
INDEPENDENT_STREAM = 2
"""Number that makes the seeds of the second generator's sets differ from the seeds of the first
generator's sets."""


def set_tasks(sets: int, samples: int, seed: int, subject: str) -> list[Task]:
    """Return every set as a task; the worlds with two heads alternate, and every 13th set has four
    heads. ``samples``: the largest number of samples in a run."""
    of_four: list[Task] = [
        {
            "world": FOUR_HEADS,
            "content": content,
            "seed": _set_seed([seed, number, FOUR_HEADS_STREAM]),
            "samples": samples,
            "subject": subject,
        }
        for number, content in enumerate(_contents(sets // EVERY_FOUR_HEADS))
    ]
    of_two = _two_heads_tasks(sets - len(of_four), samples, seed, subject)
    return _merged(of_two, of_four, EVERY_FOUR_HEADS)


def _two_heads_tasks(sets: int, samples: int, seed: int, subject: str) -> list[Task]:
    worlds = [world for world in WORLDS if world != FOUR_HEADS]
    found: list[Task] = []
    by_world = {
        world: _contents(sets // len(worlds) + (place < sets % len(worlds)))
        for place, world in enumerate(worlds)
    }
    longest = max(len(contents) for contents in by_world.values())
    for number in range(longest):
        for world, contents in by_world.items():
            if number < len(contents):
                found.append(
                    {
                        "world": world,
                        "content": contents[number],
                        "seed": _set_seed([seed, len(found)]),
                        "samples": samples,
                        "subject": subject,
                    }
                )
    return found


def independent_tasks(sets: int, samples: int, seed: int, subject: str) -> list[Task]:
    """Return sets of the second generator as tasks.

    The worlds alternate. In every third cycle through the worlds, a set has no hidden cause if its
    world permits sets without one.
    """
    worlds = list(independent_worlds().values())
    found: list[Task] = []
    for number in range(sets):
        turn, place = divmod(number, len(worlds))
        world = worlds[place]
        content = NOTHING if turn % EVERY_NULL == 0 else HIDDEN
        found.append(
            {
                "world": world.name,
                "content": content if content in world.contents else world.contents[0],
                "seed": _set_seed([seed, number, INDEPENDENT_STREAM]),
                "samples": samples,
                "subject": subject,
            }
        )
    return found


def mixed_tasks(sets: int, samples: int, seed: int, subject: str) -> list[Task]:
    """Return sets of both generators as tasks; the second generator makes every fifth set."""
    second = independent_tasks(sets // EVERY_INDEPENDENT, samples, seed, subject)
    first = set_tasks(sets - len(second), samples, seed, subject)
    return _merged(first, second, EVERY_INDEPENDENT)


def _merged(first: list[Task], second: list[Task], every: int) -> list[Task]:
    """Return the tasks of both lists in their order; every ``every``-th is of the second list."""
    found: list[Task] = []
    while first or second:
        found += first[: every - 1] + second[:1]
        first, second = first[every - 1 :], second[1:]
    return found


def _set_seed(entropy: list[int]) -> int:
    """Return a seed of at most 53 bits, because every reader of JSON represents such an integer
    exactly."""
    high, low = np.random.SeedSequence(entropy).generate_state(2, np.uint32)
    return (int(high) >> 11) * 2**32 + int(low)


def _contents(number: int) -> list[str]:
    """Return ``number`` contents in an even mixture by SHARES (largest remainder at every step)."""
    found: list[str] = []
    given = dict.fromkeys(CONTENTS, 0)
    for step in range(1, number + 1):
        owed = {content: SHARES[content] * step - given[content] for content in CONTENTS}
        content = max(owed, key=owed.__getitem__)
        given[content] += 1
        found.append(content)
    return found
