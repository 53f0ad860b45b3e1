"""Defines motions and settings of the quadrature output for the tests of its model and its VHDL."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Segment:
    clocks: int
    clocks_a_count: int = 0
    """Number of clocks per count; 0 if the table does not move."""
    down: bool = False
    tremble: int = 0
    """Number of counts after which the table reverses, again and again; 0 if it never reverses."""
    jump: int = 0
    """Counts by which position and angle jump in the first clock."""
    angle_jump: int = 0
    """Counts by which only the angle jumps in the first clock, as at the first index."""
    referenced: bool = True
    """Whether the angle counts from an index."""
    phase_of_zero: int = 0
    """Index of (A, B) in 00, 10, 11, 01 at position 0."""
    z_gated: bool = False
    z_state: int = 0
    z_width: int = 0
    enable: bool = True
    reset: bool = False
    clear: bool = False
    """Whether ``clear`` is high in the first clock."""
    minimum_spacing: int = 1
    following_limit: int = 100


@dataclass(frozen=True)
class Scenario:
    segments: list[Segment]
    counts_per_rev: int
    start: int = 0
    """First position in counts; the first angle is this position modulo counts_per_rev."""
    keeps_up: bool = True
    """Whether the enabled output must stay within one count of the position."""


def _up_and_down(clocks_a_count: int, clocks: int = 600) -> list[Segment]:
    return [
        Segment(20),
        Segment(clocks, clocks_a_count),
        Segment(clocks, clocks_a_count, down=True),
        Segment(clocks // 2, clocks_a_count, down=True),
        Segment(clocks, clocks_a_count),
        Segment(30),
    ]


SCENARIOS: dict[str, Scenario] = {
    "edge_every_clock": Scenario(_up_and_down(1), counts_per_rev=64),
    "edge_every_clock_odd_turn": Scenario(_up_and_down(1), counts_per_rev=37, start=-1000),
    "smallest_turn": Scenario(_up_and_down(1), counts_per_rev=4, start=3),
    "turn_of_5": Scenario(_up_and_down(3), counts_per_rev=5),
    "largest_turn": Scenario(_up_and_down(2), counts_per_rev=2**24, start=2**24 - 80),
    "below_zero": Scenario(_up_and_down(2), counts_per_rev=2**24 - 3, start=-17),
    "position_wrap": Scenario(_up_and_down(2), counts_per_rev=1000, start=2**31 - 100),
    "spacing_as_fast_as_the_edges": Scenario(
        [
            Segment(20, minimum_spacing=7),
            Segment(900, 7, minimum_spacing=7),
            Segment(900, 7, down=True, minimum_spacing=7),
            Segment(30, minimum_spacing=7),
        ],
        counts_per_rev=29,
    ),
    "trembling_between_neighbours": Scenario(
        [Segment(40, 3), Segment(600, 2, tremble=1), Segment(300, 1, tremble=1), Segment(40, 3)],
        counts_per_rev=16,
    ),
    "trembling_wider": Scenario(
        [
            Segment(40, 3),
            Segment(600, 2, tremble=2),
            Segment(600, 1, tremble=3),
            Segment(40, 3, down=True),
            Segment(300, 1, tremble=2, down=True),
        ],
        counts_per_rev=16,
    ),
    "too_fast_then_standing": Scenario(
        [
            Segment(600, 1, minimum_spacing=3, following_limit=50),
            # The clear ends the fault: the output continues from the present position, and the
            # fault does not occur again while the table stands.
            Segment(100, minimum_spacing=3, following_limit=50, clear=True),
            Segment(1500, minimum_spacing=3, following_limit=50),
            Segment(200, minimum_spacing=3, following_limit=50, clear=True),
            Segment(600, 1, down=True, minimum_spacing=5, following_limit=50),
            Segment(2500, minimum_spacing=5, following_limit=50),
            Segment(20, minimum_spacing=5, following_limit=50, clear=True),
        ],
        counts_per_rev=1000,
        keeps_up=False,
    ),
    "limit_is_exact": Scenario(
        [
            Segment(30, following_limit=9),
            Segment(40, jump=9, minimum_spacing=4, following_limit=9),
            Segment(40, jump=10, minimum_spacing=4, following_limit=9),
            Segment(40, clear=True, following_limit=9),
            Segment(40, jump=-9, minimum_spacing=4, following_limit=9),
            Segment(40, jump=-10, minimum_spacing=4, following_limit=9),
        ],
        counts_per_rev=1000,
        keeps_up=False,
    ),
    "limit_beyond_two_turns": Scenario(
        [
            Segment(30, following_limit=65_535),
            Segment(130, jump=23, minimum_spacing=4, following_limit=65_535),
            Segment(130, jump=24, minimum_spacing=4, following_limit=65_535),
            Segment(100, clear=True, jump=-30, minimum_spacing=3, following_limit=65_535),
            Segment(200, jump=-24, minimum_spacing=2, following_limit=65_535),
        ],
        counts_per_rev=12,
        keeps_up=False,
    ),
    "spacing_changed": Scenario(
        [
            Segment(20, minimum_spacing=20),
            Segment(300, jump=400, minimum_spacing=20),
            Segment(300, minimum_spacing=3),
            Segment(100, minimum_spacing=1),
            Segment(50, minimum_spacing=0),
            Segment(1000, jump=900, minimum_spacing=65_535),
            Segment(1000, minimum_spacing=2),
        ],
        counts_per_rev=5000,
        keeps_up=False,
    ),
    "far_away_at_once": Scenario(
        [
            Segment(50, minimum_spacing=1000),
            Segment(50, jump=2**31 - 3, minimum_spacing=1000),
            Segment(50, 1, minimum_spacing=1000, clear=True),
            Segment(50, jump=-(2**30), minimum_spacing=1000),
            Segment(90, 1, down=True, minimum_spacing=2, clear=True),
            Segment(50, 1, minimum_spacing=2),
        ],
        counts_per_rev=1000,
        keeps_up=False,
    ),
    "backlog_before_a_standstill": Scenario(
        [
            Segment(20, minimum_spacing=10),
            Segment(8000, 4, minimum_spacing=10),
            Segment(3000, minimum_spacing=10),
            Segment(60, minimum_spacing=10, clear=True),
            Segment(2000, 12, minimum_spacing=10),
        ],
        counts_per_rev=2**24,
        keeps_up=False,
    ),
    "enable_without_burst": Scenario(
        [
            Segment(100, 2, enable=False),
            Segment(100, 2),
            Segment(101, 1, enable=False),
            Segment(100, 1),
            Segment(1, 1, enable=False),
            Segment(50, 1, down=True),
            Segment(2, 1, enable=False, down=True),
            Segment(50, 1, down=True),
            Segment(3, 1, enable=False),
            Segment(50, 1),
            Segment(40, jump=12_345, enable=False),
            Segment(60, 4),
            Segment(200, 1, down=True, enable=False),
            Segment(60),
        ],
        counts_per_rev=30,
        keeps_up=False,
    ),
    "enable_while_far_behind": Scenario(
        [
            Segment(20, minimum_spacing=5, following_limit=2000),
            Segment(60, jump=1000, minimum_spacing=5, following_limit=2000),
            Segment(7, minimum_spacing=5, following_limit=2000, enable=False),
            Segment(60, minimum_spacing=5, following_limit=2000, clear=True),
            Segment(300, 1, minimum_spacing=30, following_limit=2000),
            Segment(4, minimum_spacing=30, following_limit=2000, enable=False),
            Segment(100, 40, minimum_spacing=30, following_limit=2000),
        ],
        counts_per_rev=3000,
        keeps_up=False,
    ),
    "first_index": Scenario(
        [
            Segment(200, 2),
            Segment(200, 2, angle_jump=13),
            Segment(200, 1, down=True, angle_jump=-7),
            Segment(50),
            # While the table stands, only the angle jumps.
            Segment(50, angle_jump=-17),
            Segment(50, angle_jump=5),
            Segment(50, angle_jump=-5),
        ],
        counts_per_rev=41,
    ),
    "no_reference_before_the_index_and_in_a_rearm": Scenario(
        [
            Segment(200, 1, referenced=False),
            Segment(200, 1, angle_jump=13),
            # `referenced` falls, as in a re-arm; here the angle continues to count.
            Segment(100, 2, down=True, referenced=False),
            Segment(100, 2, down=True, angle_jump=5),
            Segment(40, enable=False, referenced=False),
            Segment(60, 1, referenced=False),
            Segment(60, 1),
        ],
        counts_per_rev=23,
        keeps_up=False,
    ),
    **{
        f"z_from_state_{state}_for_{4 >> (2 - width)}_counts": Scenario(
            [
                replace(part, z_gated=True, z_state=state, z_width=width, phase_of_zero=3)
                for part in [Segment(20, enable=False), *_up_and_down(3, 500)]
            ],
            counts_per_rev=40,
            start=-9,
        )
        for state, width in ((0, 0), (1, 1), (2, 2), (3, 0), (2, 0))
    },
    **{
        f"ungated_z_for_{4 >> (2 - width)}_counts": Scenario(
            [replace(part, z_width=width, phase_of_zero=1) for part in _up_and_down(2, 500)],
            counts_per_rev=37,
            start=-9,
        )
        for width in (1, 2)
    },
    "phase_of_the_head_in_a_reset_and_at_each_enable": Scenario(
        [
            Segment(3, reset=True, phase_of_zero=2),
            Segment(40, enable=False, phase_of_zero=2),
            Segment(60, 2, phase_of_zero=2),
            Segment(1, phase_of_zero=3, reset=True),
            Segment(40, 3, phase_of_zero=3),
            Segment(1, phase_of_zero=1, enable=False),
            Segment(40, 3, phase_of_zero=1),
            Segment(30, 3, phase_of_zero=0),
        ],
        counts_per_rev=50,
        keeps_up=False,
    ),
    "reset_in_between": Scenario(
        [
            Segment(101, 1),
            Segment(1, 1, reset=True),
            Segment(50, 1),
            Segment(100, jump=500, minimum_spacing=9),
            Segment(3, reset=True),
            Segment(100, 3, minimum_spacing=2),
        ],
        counts_per_rev=19,
        keeps_up=False,
    ),
}


def random_scenario(seed: int) -> Scenario:
    """Return a scenario of segments with random motion and settings."""
    random = np.random.default_rng(seed)
    segments = [
        Segment(
            clocks=int(random.integers(1, 400)),
            clocks_a_count=int(random.choice([0, 1, 1, 2, 3, 7])),
            down=bool(random.integers(2)),
            tremble=int(random.choice([0, 0, 1, 2, 3])),
            jump=int(random.choice([0, 0, 0, 1, -1, 2, -5, 40])),
            angle_jump=int(random.choice([0, 0, 3])),
            enable=random.random() < 0.9,
            clear=random.random() < 0.3,
            referenced=random.random() < 0.8,
            phase_of_zero=int(random.integers(4)),
            z_gated=bool(random.integers(2)),
            z_state=int(random.integers(4)),
            z_width=int(random.integers(3)),
            reset=random.random() < 0.02,
            minimum_spacing=int(random.choice([0, 1, 1, 2, 3, 4, 11])),
            following_limit=int(random.integers(0, 40)),
        )
        for _ in range(30)
    ]
    return Scenario(
        segments,
        counts_per_rev=int(random.integers(4, 60)),
        start=int(random.integers(-(2**31), 2**31)),
        keeps_up=False,
    )


SCENARIOS |= {f"random_{seed}": random_scenario(seed) for seed in range(5)}


def _moves(segment: Segment) -> NDArray[np.int64]:
    """Return the number of counts by which the position moves in each clock of a segment."""
    moves = np.zeros(segment.clocks, dtype=np.int64)
    if segment.clocks_a_count:
        edges = moves[:: segment.clocks_a_count]
        edges[:] = -1 if segment.down else 1
        if segment.tremble:
            edges[np.arange(len(edges)) // segment.tremble % 2 == 1] *= -1
    moves[0] += segment.jump
    return moves


def _at_start(values: list[int], lengths: list[int]) -> NDArray[np.int64]:
    """Return a number per clock: in the first clock of each segment its value, otherwise 0."""
    pulses = np.zeros(sum(lengths), dtype=np.int64)
    pulses[np.cumsum([0, *lengths[:-1]])] = values
    return pulses


def stimuli(scenario: Scenario) -> dict[str, NDArray[np.int64]]:
    """Return the entity's inputs in each clock of a scenario, by name; shape (clocks,)."""
    lengths = [segment.clocks for segment in scenario.segments]
    turned = scenario.start + np.cumsum(np.concatenate([_moves(s) for s in scenario.segments]))
    offset = np.cumsum(_at_start([s.angle_jump for s in scenario.segments], lengths))
    names = ("phase_of_zero", "z_gated", "z_state", "z_width")
    names += ("enable", "reset", "referenced", "minimum_spacing", "following_limit")
    columns = {
        name: np.repeat([int(getattr(s, name)) for s in scenario.segments], lengths)
        for name in names
    }
    return {
        **columns,
        "clear": _at_start([int(s.clear) for s in scenario.segments], lengths),
        "corrected_position": (turned + 2**31) % 2**32 - 2**31,
        "corrected_angle": (turned + offset) % scenario.counts_per_rev,
        "counts_per_rev": np.full(len(turned), scenario.counts_per_rev),
    }
