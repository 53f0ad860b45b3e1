"""Defines motions and settings of the sampler for the tests of its model and its VHDL.

A scenario is a list of segments. In a segment the settings are constant, and head 1 moves by one
count every few clocks or does not move. The value of head 2 changes in every clock, so that the
tests detect a pair of values from different clocks or samples.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT

INDEX_SEEN = 0b11


@dataclass(frozen=True)
class Segment:
    clocks: int
    clocks_a_count: int = 0
    """Number of clocks per count; 0 if the table does not move."""
    down: bool = False
    enable: bool = True
    mode: int = 0
    sample_period: int = 10
    angle_step: int = 0
    flags: int = INDEX_SEEN
    reset: bool = False
    tremble: bool = False
    """Whether head 1 moves by one count up and down alternately, every clocks_a_count clocks."""
    zero_slip: int = 0
    """Counts by which the position of head 1 jumps in the first clock, because its zero moves."""


@dataclass(frozen=True)
class Scenario:
    segments: list[Segment]
    counts_per_rev: int
    depth: int = 16
    start: int = 0
    """Position of head 1 at the start, in counts."""
    hold: tuple[int, int] = (0, 120)
    """Smallest and largest number of clocks for which the processor keeps a READY bank."""
    expect: dict[str, int] = field(default_factory=dict)
    """Least expected numbers of captures, of overruns, and of banks that were full before their
    turn was complete; 0 means that none are allowed."""


def repeated(count: int, *segments: Segment) -> list[Segment]:
    return list(segments) * count


_UP = Segment(4000, clocks_a_count=2, sample_period=10)
_DOWN = Segment(4000, clocks_a_count=2, down=True, sample_period=10)

SCENARIOS: dict[str, Scenario] = {
    "up": Scenario([_UP], counts_per_rev=60, expect={"captures": 20, "overruns": 0, "full": 0}),
    "down": Scenario([_DOWN], counts_per_rev=60, start=7, expect={"captures": 20, "overruns": 0}),
    "turn_closed_by_the_last_word_of_the_bank": Scenario(
        # Samples come every 4 counts, so that the 16th lies 60 counts after the first.
        [Segment(3000, clocks_a_count=2, sample_period=8)],
        counts_per_rev=60,
        expect={"captures": 20, "full": 0},
    ),
    "full_before_turn": Scenario(
        [Segment(3000, clocks_a_count=2, sample_period=7)],
        counts_per_rev=60,
        expect={"captures": 20, "full": 20},
    ),
    "standing_fills_the_bank": Scenario(
        [Segment(1500, sample_period=3)], counts_per_rev=4, expect={"captures": 10, "full": 10}
    ),
    "processor_too_slow": Scenario(
        [Segment(8000, clocks_a_count=2, sample_period=10)],
        counts_per_rev=60,
        hold=(100, 700),
        expect={"captures": 5, "overruns": 5},
    ),
    "sample_every_clock_edge_every_clock": Scenario(
        [Segment(4000, clocks_a_count=1, sample_period=1)],
        counts_per_rev=13,
        hold=(0, 20),
        expect={"captures": 50, "overruns": 20, "full": 0},
    ),
    "smallest_turn": Scenario(
        [Segment(1000, clocks_a_count=1, sample_period=1)],
        counts_per_rev=4,
        hold=(0, 6),
        expect={"captures": 50, "overruns": 20},
    ),
    "two_words_a_bank": Scenario(
        [Segment(500, clocks_a_count=3, sample_period=1)],
        counts_per_rev=4,
        depth=2,
        hold=(0, 3),
        expect={"captures": 50, "overruns": 10, "full": 50},
    ),
    "sample_period_changed": Scenario(
        [
            Segment(777, clocks_a_count=3, sample_period=25),
            Segment(500, clocks_a_count=3, sample_period=7),
            Segment(300, clocks_a_count=3, sample_period=400),
            # The present interval is already longer than the new period, so it ends at once.
            Segment(400, clocks_a_count=3, sample_period=5),
            Segment(100, clocks_a_count=3, sample_period=1),
            Segment(100, clocks_a_count=3, sample_period=0),
            Segment(900, clocks_a_count=3, sample_period=2**32 - 1),
            Segment(500, clocks_a_count=3, sample_period=16),
        ],
        counts_per_rev=50,
        expect={"captures": 8},
    ),
    "equal_angle_with_reversal": Scenario(
        [
            Segment(2500, clocks_a_count=3, mode=1, angle_step=10),
            Segment(2500, clocks_a_count=3, mode=1, angle_step=10, down=True),
            Segment(1111, clocks_a_count=5, mode=1, angle_step=10),
            Segment(3000, clocks_a_count=2, mode=1, angle_step=10, down=True),
        ],
        counts_per_rev=120,
        # A turn with a reversal is not complete before the bank is full.
        expect={"captures": 15, "full": 1},
    ),
    "equal_angle_step_on_every_clock": Scenario(
        [
            Segment(40, mode=1, angle_step=1),
            Segment(600, clocks_a_count=1, mode=1, angle_step=1),
            Segment(600, clocks_a_count=1, mode=1, angle_step=1, down=True),
        ],
        counts_per_rev=11,
        start=-300,
        hold=(0, 12),
        expect={"captures": 20, "full": 0},
    ),
    "equal_angle_step_changed_while_turning": Scenario(
        [
            Segment(700, clocks_a_count=1, mode=1, angle_step=7),
            Segment(900, clocks_a_count=1, mode=1, angle_step=9),
            Segment(300, clocks_a_count=1, mode=1, angle_step=0),
            Segment(900, clocks_a_count=1, mode=1, angle_step=5, down=True),
            Segment(700, clocks_a_count=4, mode=0, sample_period=15),
            Segment(900, clocks_a_count=1, mode=1, angle_step=2, down=True),
        ],
        counts_per_rev=61,
        start=12_345,
        expect={"captures": 10},
    ),
    "equal_angle_trembling_on_a_step": Scenario(
        [
            Segment(80, mode=1, angle_step=8),
            Segment(64, clocks_a_count=2, mode=1, angle_step=8),
            Segment(400, clocks_a_count=3, mode=1, angle_step=8, tremble=True),
            Segment(300, clocks_a_count=2, mode=1, angle_step=8),
        ],
        counts_per_rev=64,
        start=-5,
        expect={"captures": 2},
    ),
    "equal_angle_zero_moves": Scenario(
        [
            Segment(1203, clocks_a_count=2, mode=1, angle_step=16),
            # The zero moves first by a whole period (4 counts), then by -7 counts, whose two low
            # bits equal those of a step by 1, then by a single count.
            Segment(1201, clocks_a_count=2, mode=1, angle_step=16, zero_slip=4),
            Segment(1203, clocks_a_count=2, mode=1, angle_step=16, zero_slip=-7),
            Segment(1201, clocks_a_count=1, mode=1, angle_step=16, zero_slip=1, down=True),
            # The zero moves again while the entity still determines the multiples of the step.
            Segment(20, clocks_a_count=1, mode=1, angle_step=16, zero_slip=5000, down=True),
            Segment(1203, clocks_a_count=1, mode=1, angle_step=16, zero_slip=2, down=True),
            # While the table stands, the zero moves so that the position lies first on a multiple
            # of the step, then next to it.
            Segment(200, mode=1, angle_step=16, zero_slip=3),
            Segment(800, clocks_a_count=3, mode=1, angle_step=16, zero_slip=-2),
            Segment(300, clocks_a_count=2, sample_period=7, zero_slip=4),
        ],
        counts_per_rev=128,
        start=-50,
        expect={"captures": 15},
    ),
    "equal_angle_across_the_position_wrap": Scenario(
        [
            Segment(1600, clocks_a_count=2, mode=1, angle_step=16),
            Segment(1600, clocks_a_count=2, mode=1, angle_step=16, down=True),
        ],
        counts_per_rev=128,
        start=2**31 - 400,
        expect={"captures": 8, "full": 0},
    ),
    "time_across_the_position_wrap": Scenario(
        [_UP, _DOWN], counts_per_rev=60, start=2**31 - 1000, expect={"captures": 50}
    ),
    "enable_and_index": Scenario(
        [
            Segment(200, clocks_a_count=2, enable=False),
            Segment(203, clocks_a_count=2, flags=0b01),
            Segment(207, clocks_a_count=2, flags=0b10),
            Segment(1000, clocks_a_count=2),
            Segment(1, clocks_a_count=2, enable=False),
            Segment(501, clocks_a_count=2),
            Segment(3, clocks_a_count=2, flags=0b10),
            Segment(902, clocks_a_count=2),
            Segment(100, clocks_a_count=2, flags=0b01),
            Segment(900, clocks_a_count=2, down=True),
        ],
        counts_per_rev=60,
        expect={"captures": 15, "full": 0},
    ),
    "flags": Scenario(
        [
            segment
            for bit in range(2, 8)
            for segment in (
                Segment(171, clocks_a_count=2),
                Segment(1, clocks_a_count=2, flags=INDEX_SEEN | 1 << bit),
                Segment(313, clocks_a_count=2),
                Segment(130, clocks_a_count=2, flags=INDEX_SEEN | 1 << bit),
            )
        ],
        counts_per_rev=60,
        expect={"captures": 15},
    ),
    "reset_in_between": Scenario(
        [
            Segment(733, clocks_a_count=2),
            Segment(2, clocks_a_count=2, reset=True),
            Segment(721, clocks_a_count=2),
            Segment(1, clocks_a_count=2, reset=True),
            Segment(800, clocks_a_count=2, mode=1, angle_step=5),
            Segment(1, clocks_a_count=2, mode=1, angle_step=5, reset=True),
            Segment(800, clocks_a_count=2, mode=1, angle_step=5),
        ],
        counts_per_rev=60,
        expect={"captures": 12},
    ),
}

SCENARIOS["two_banks_of_the_default_depth"] = Scenario(
    [Segment(25_000, clocks_a_count=3, sample_period=1)],
    counts_per_rev=4095,
    depth=CAPTURE_DEPTH_DEFAULT,
    expect={"captures": 2, "overruns": 0, "full": 0},
)


def random_scenario(seed: int) -> Scenario:
    """Return a scenario of segments with random motion and settings; a bank has 13 words, no power
    of two."""
    random = np.random.default_rng(seed)

    def pick(values: list[int]) -> int:
        return int(random.choice(values))

    segments = [
        Segment(
            clocks=int(random.integers(1, 700)),
            clocks_a_count=pick([0, 1, 1, 2, 3, 5]),
            down=bool(random.integers(2)),
            tremble=random.random() < 0.1,
            enable=random.random() < 0.95,
            mode=int(random.integers(2)),
            sample_period=int(random.integers(0, 30)),
            angle_step=int(random.integers(0, 12)),
            flags=INDEX_SEEN | pick([0, 0, 0, 4, 8, 16, 32, 64, 128]),
            reset=random.random() < 0.02,
        )
        for _ in range(20)
    ]
    return Scenario(
        segments,
        counts_per_rev=int(random.integers(4, 90)),
        depth=13,
        start=int(random.integers(-(2**31), 2**31)),
        hold=(0, 150),
        expect={"captures": 5},
    )


SCENARIOS |= {f"random_{seed}": random_scenario(seed) for seed in range(4)}


def _moves(segment: Segment) -> NDArray[np.int64]:
    """Return the number of counts by which head 1 moves in each clock of a segment."""
    moves = np.zeros(segment.clocks, dtype=np.int64)
    if segment.clocks_a_count:
        edges = moves[:: segment.clocks_a_count]
        edges[:] = -1 if segment.down else 1
        if segment.tremble:
            edges[1::2] *= -1
    return moves


def _signed32(counts: NDArray[np.int64]) -> NDArray[np.int64]:
    return (counts + 2**31) % 2**32 - 2**31


def stimuli(scenario: Scenario) -> dict[str, NDArray[np.int64]]:
    """Return the sampler's inputs in each clock of a scenario, by name; shape (clocks,)."""
    lengths = [segment.clocks for segment in scenario.segments]
    first = np.cumsum([0, *lengths[:-1]])
    slips = np.array([segment.zero_slip for segment in scenario.segments])
    moved = np.concatenate([_moves(s) for s in scenario.segments])
    np.add.at(moved, first, slips)
    turned = scenario.start + np.cumsum(moved)
    clock = np.arange(len(turned))
    names = ("enable", "mode", "sample_period", "angle_step", "flags", "reset")
    columns = {
        name: np.repeat([int(getattr(s, name)) for s in scenario.segments], lengths)
        for name in names
    }
    return {
        **columns,
        "turn_position1": _signed32(turned),
        "zero_moved1": np.repeat(np.cumsum(slips != 0) % 2, lengths),
        # The value of head 2 changes in every clock, even if head 1 does not move.
        "turn_position2": _signed32(3 * turned - 7 * clock + 0x1234_5678),
        "counts_per_rev": np.full(len(turned), scenario.counts_per_rev),
        # Both words of the time stamp change during the scenario.
        "timestamp": clock + 2**32 - len(turned) // 2,
    }
