"""Defines motions, faults and settings of the decoder for the tests of its model and its VHDL.

A scenario includes the true place of the disc in every clock, in fractions of a count. The expected
outputs of the decoder follow from this place, so the tests need not decode the pins themselves.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from fractions import Fraction

import numpy as np
from numpy.typing import NDArray

UNITS = 2520
"""Number of parts of a count in which places are expressed. With this number every speed of 1 to 10
clocks per count is exact."""


@dataclass(frozen=True)
class Segment:
    clocks: int
    clocks_a_count: int = 0
    """Number of clocks per count; 0 if the disc does not move."""
    down: bool = False
    wander: bool = False
    """Whether the speed is random, at most a count per clock in either direction, and changes at
    random times."""
    jitter: Fraction = Fraction(0)
    """Largest displacement of the disc in counts; a random displacement is drawn in each clock."""
    jump: int = 0
    """Counts by which the disc jumps in the first clock."""
    glitch_clocks: int = 0
    """Number of clocks for which a glitch inverts A, B or Z; glitches come at random times, not
    near edges."""
    filter_length: int = 1
    minimum_edge_spacing: int = 0
    index_tolerance: int = 0
    counts_per_rev: int = 0
    """Setting of the counts per turn in this segment; 0 for the value of the scenario."""
    clear: bool = False
    """Whether ``clear`` is high in the first clock."""
    rearm: bool = False
    zero_again: bool = False
    heal: bool = False
    other_head_agrees: bool = False
    reset: bool = False


RESET = Segment(3, reset=True)


@dataclass(frozen=True)
class Scenario:
    segments: list[Segment]
    counts_per_rev: int
    start: int = 0
    """Place of the disc at the start, in counts from the edge at count 0."""
    index_at: Fraction = Fraction(0)
    """Distance in counts from the edge of A or B at count 0 to the index edge; 0: both coincide."""
    index_width: Fraction = Fraction(1)
    """Number of counts for which Z is high."""
    index_scatter: int = 0
    """Largest displacement of the index mark in whole counts; a random displacement is drawn at
    each passage."""
    skew_clocks: tuple[int, int, int] = (0, 0, 0)
    """Number of clocks by which A, B and Z are delayed."""
    first_timestamp: int = 0
    seed: int = 1


@dataclass(frozen=True)
class Stimuli:
    """Inputs of the decoder and true places in each clock; arrays of shape (clocks,)."""

    columns: dict[str, NDArray[np.int64]] = field(repr=False)
    """Inputs of the entity by name."""
    timestamp: NDArray[np.uint64] = field(repr=False)
    place: NDArray[np.int64] = field(repr=False)
    """Place of the disc in each clock, from the edge at count 0, in 1 / UNITS count."""

    mark_scatter: NDArray[np.int64] = field(
        repr=False, default_factory=lambda: np.zeros(0, np.int64)
    )
    """Displacement in counts of the nearest index mark, in each clock."""

    @property
    def count(self) -> NDArray[np.int64]:
        """Return the true count: the number of edges of A and B after the edge at count 0, up to
        the place."""
        return self.place // UNITS


def _there_and_back(clocks_a_count: int, counts: int, **settings: object) -> list[Segment]:
    """Return segments that move up, down beyond the start, and up to the start again; each stretch
    crosses the index.

    The disc turns back in the middle of a count, unless a count lasts only one clock.
    """
    clocks = clocks_a_count * counts
    return [
        RESET,
        Segment(10, **settings),  # type: ignore[arg-type]
        Segment(clocks + clocks_a_count // 2, clocks_a_count, **settings),  # type: ignore[arg-type]
        Segment(2 * clocks, clocks_a_count, down=True, **settings),  # type: ignore[arg-type]
        Segment(clocks, clocks_a_count, **settings),  # type: ignore[arg-type]
        Segment(20, **settings),  # type: ignore[arg-type]
    ]


HALF = Fraction(1, 2)

LOSSLESS: dict[str, Scenario] = {
    "edge_every_clock_turn_of_4": Scenario(_there_and_back(1, 41), 4, start=-1),
    "edge_every_clock_turn_of_5": Scenario(_there_and_back(1, 43), 5, start=3),
    "edge_every_clock_turn_of_7": Scenario(_there_and_back(1, 60), 7, start=-2),
    "edge_every_clock_turn_of_64": Scenario(_there_and_back(1, 200), 64, start=-30),
    "turn_of_12000": Scenario(
        [RESET, Segment(10), Segment(12_400, 1), Segment(500, 1, down=True), Segment(20)],
        12_000,
        start=-200,
    ),
    "largest_turn": Scenario(_there_and_back(1, 70), 2**24, start=-30),
    "largest_odd_turn_at_3_clocks": Scenario(_there_and_back(3, 50), 2**24 - 1, start=25),
    "index_inside_a_count": Scenario(
        _there_and_back(10, 60), 37, start=-3, index_at=HALF, index_width=Fraction(7, 10)
    ),
    "index_inside_a_count_filtered": Scenario(
        _there_and_back(10, 60, filter_length=6), 23, index_at=Fraction(1, 10), start=5
    ),
    "wide_index": Scenario(_there_and_back(2, 60), 50, start=-9, index_width=Fraction(17)),
    "index_of_half_a_turn": Scenario(_there_and_back(1, 60), 12, start=3, index_width=Fraction(6)),
    "trembles_at_the_index": Scenario(
        [RESET, Segment(5), *[Segment(9, 3), Segment(9, 3, down=True)] * 20, Segment(30)],
        1000,
        start=-1,
    ),
    "reverses_in_every_clock": Scenario(
        [RESET, Segment(5), *[Segment(1, 1), Segment(1, 1, down=True)] * 60, Segment(20)],
        5,
        start=-1,
    ),
    "jitter": Scenario(
        [
            RESET,
            Segment(8),
            Segment(1000, 10, jitter=Fraction(2, 5)),
            Segment(300, jitter=Fraction(2, 5)),
            Segment(1500, 10, down=True, jitter=Fraction(2, 5)),
            Segment(10),
        ],
        29,
        start=-10,
    ),
    "glitches_are_filtered": Scenario(
        _there_and_back(40, 25, filter_length=9, glitch_clocks=8), 11, start=-4
    ),
    "long_filter": Scenario(_there_and_back(300, 5, filter_length=255), 6, start=-3),
    "filter_of_zero_is_off": Scenario(_there_and_back(2, 30, filter_length=0), 13, start=-3),
    "wanders_turn_of_5": Scenario([RESET, Segment(3000, wander=True)], 5, start=2, seed=2),
    "wanders_turn_of_100": Scenario([RESET, Segment(4000, wander=True)], 100, start=-20, seed=3),
    "timestamp_wraps": Scenario(_there_and_back(3, 40), 100, start=-5, first_timestamp=2**64 - 150),
}
"""Scenarios in which no edge is lost: the decoder's position, angle and index must equal those of
the disc."""

SCATTERED: dict[str, Scenario] = {
    "index_repeats_to_1_count": Scenario(
        [
            RESET,
            *[
                Segment(clocks, 1, down=down, index_tolerance=2)
                for clocks, down in (
                    (400, False),
                    (150, True),
                    (31, False),
                    (260, True),
                    (700, False),
                )
            ],
            Segment(20, index_tolerance=2),
        ],
        40,
        start=-9,
        index_scatter=1,
        seed=5,
    ),
    "index_repeats_to_3_counts_at_half_counts": Scenario(
        _there_and_back(10, 230, index_tolerance=6),
        51,
        start=-20,
        index_at=HALF,
        index_scatter=3,
        seed=12,
    ),
    "tolerance_changes_with_every_clock": Scenario(
        [RESET, *[Segment(1, 1, index_tolerance=clock % 6) for clock in range(2500)]],
        20,
        start=-3,
        index_scatter=2,
        seed=7,
    ),
}
"""Scenarios in which the places of the index marks scatter and no count is lost."""

FAULTY: dict[str, Scenario] = {
    "lost_count_between_index_marks": Scenario(
        [
            RESET,
            Segment(200, 1),
            Segment(20, 2, jump=2),
            Segment(200, 1),
            Segment(20, 2, jump=-2),
            Segment(300, 1),
            Segment(100, 1, clear=True),
            Segment(20),
        ],
        50,
        start=-4,
    ),
    "faults_of_every_kind": Scenario(
        [
            RESET,
            Segment(20, minimum_edge_spacing=2),
            Segment(41, 1, minimum_edge_spacing=2),
            *[Segment(40, 1, jump=2, minimum_edge_spacing=2)] * 4,
            Segment(20, minimum_edge_spacing=2),
        ],
        20,
        start=-6,
    ),
    "a_lost_period_shows_only_at_the_index": Scenario(
        [RESET, Segment(100, 1), Segment(100, 1, jump=4), Segment(60, 1, down=True), Segment(10)],
        31,
        start=-7,
    ),
    "lost_counts_and_the_zero_found_again": Scenario(
        [
            RESET,
            *[
                Segment(clocks, 3, down=down, jump=jump, index_tolerance=2, zero_again=again)
                for clocks, jump, down, again in (
                    (500, 0, False, True),
                    (700, 4, False, True),
                    (700, -8, False, True),
                    (600, 0, True, True),
                    (700, 12, True, False),
                    (700, 0, True, False),
                    (700, 0, True, True),
                )
            ],
            Segment(20, zero_again=True, index_tolerance=2),
        ],
        60,
        start=-17,
    ),
    "the_other_head_agrees": Scenario(
        [
            RESET,
            *[
                Segment(
                    clocks,
                    3,
                    down=down,
                    jump=jump,
                    index_tolerance=2,
                    zero_again=True,
                    heal=heal,
                    other_head_agrees=agrees,
                )
                for clocks, jump, down, heal, agrees in (
                    (500, 0, False, False, True),
                    (400, 4, False, False, True),
                    (400, -8, False, True, True),
                    (300, 12, False, True, False),
                    (500, 0, False, True, True),
                    (600, 0, True, False, True),
                    (700, 12, True, True, True),
                )
            ],
            Segment(20, zero_again=True, index_tolerance=2),
        ],
        60,
        start=-17,
    ),
    "zero_again_in_every_clock": Scenario(
        [
            RESET,
            *[
                Segment(clocks, 1, jump=jump, down=down, zero_again=True)
                for clocks, jump, down in (
                    (40, 0, False),
                    (60, 4, False),
                    (70, 4, True),
                    (60, 0, True),
                )
            ]
            * 3,
        ],
        9,
        start=-3,
    ),
    "a_lost_period_within_the_tolerance_of_a_bad_index": Scenario(
        [
            RESET,
            *[
                Segment(100, 1, jump=jump, index_tolerance=tolerance, clear=True)
                for tolerance in (3, 4)
                for jump in (0, 4, 0, -4)
            ],
            Segment(10),
        ],
        31,
        start=-17,
    ),
    "illegal_in_every_clock": Scenario(
        [RESET, Segment(5), *[Segment(1, jump=2)] * 12, Segment(1, jump=2, clear=True), Segment(9)],
        1000,
        start=200,
    ),
    "overspeed": Scenario(
        [
            RESET,
            Segment(60, 6, minimum_edge_spacing=6),
            Segment(60, 6, minimum_edge_spacing=7),
            Segment(60, 6, minimum_edge_spacing=6),
            Segment(20, minimum_edge_spacing=6, clear=True),
            Segment(40, 5, minimum_edge_spacing=6),
            Segment(40, 1, minimum_edge_spacing=1),
            Segment(40, 1, clear=True),
            Segment(40, 1, minimum_edge_spacing=2),
            Segment(40, 1, minimum_edge_spacing=2, clear=True),
            Segment(20),
        ],
        1000,
        start=200,
    ),
    "edges_65535_clocks_apart": Scenario(
        [
            RESET,
            Segment(5, minimum_edge_spacing=65_535),
            Segment(1, 1, minimum_edge_spacing=65_535),
            Segment(65_533, minimum_edge_spacing=65_535),
            Segment(1, 1, minimum_edge_spacing=65_535),
            Segment(65_534, minimum_edge_spacing=65_535),
            Segment(1, 1, minimum_edge_spacing=65_535),
            Segment(66_000, minimum_edge_spacing=65_535),
            Segment(1, 1, minimum_edge_spacing=65_535),
            Segment(20),
        ],
        1000,
        start=200,
    ),
    "faster_than_the_filter": Scenario(
        [
            RESET,
            Segment(20, filter_length=16),
            # Each level lasts 18 clocks at first, then 14, then 10; the filter suppresses levels of
            # 14 and 10 clocks.
            Segment(180, 9, filter_length=16),
            Segment(280, 7, filter_length=16),
            Segment(60, filter_length=16),
            Segment(1, filter_length=16, clear=True),
            Segment(200, 5, filter_length=16, down=True),
            Segment(60, filter_length=16),
        ],
        1000,
        start=200,
    ),
    "two_counts_a_clock_after_the_filter": Scenario(
        [
            RESET,
            Segment(9, filter_length=3),
            *[Segment(1, filter_length=3, jump=2)] * 30,
            Segment(20, filter_length=3),
        ],
        1000,
        start=200,
    ),
    "glitches_are_counted_without_filter": Scenario(
        _there_and_back(40, 25, glitch_clocks=2), 11, start=-4
    ),
    "filter_length_changes": Scenario(
        [
            RESET,
            *[
                Segment(clocks, 12, filter_length=length, glitch_clocks=3)
                for clocks, length in ((200, 1), (217, 10), (205, 3), (118, 20), (300, 4))
            ],
            *[Segment(clocks, 12, filter_length=clocks % 12) for clocks in range(1, 40)],
        ],
        16,
        start=-6,
    ),
    "rearm_with_new_turns": Scenario(
        [
            RESET,
            Segment(100, 1),
            Segment(30, 1, rearm=True),
            Segment(70, 1),
            Segment(1, 1, rearm=True, counts_per_rev=9),
            Segment(80, 1, counts_per_rev=9),
            Segment(1, 1, down=True, rearm=True, counts_per_rev=2**24),
            Segment(80, 1, down=True, counts_per_rev=2**24),
            Segment(80, 1, down=True, counts_per_rev=77),
            Segment(1, 1, rearm=True, counts_per_rev=4, clear=True),
            Segment(80, 1, counts_per_rev=4),
        ],
        40,
        start=-3,
    ),
    "reset_of_one_clock_while_moving": Scenario(
        [
            Segment(1, reset=True),
            *[
                segment
                for down in (False, True, False)
                for segment in (
                    Segment(60, 1, down=down),
                    Segment(1, 1, down=down, reset=True),
                    Segment(45, 2, down=down, filter_length=2),
                    Segment(1, 1, down=down, reset=True, counts_per_rev=25),
                    Segment(60, 1, down=down, counts_per_rev=25),
                )
            ],
        ],
        17,
        start=-5,
    ),
}
"""Scenarios with faults, or with settings that change during the run."""

RANDOM_SEEDS: dict[str, int] = {f"random_pins_{seed}": seed for seed in range(4)}
"""Seeds of random pins and settings, which are used only to compare model and VHDL."""


def skewed(
    skew_clocks: tuple[int, int, int], width: int = 17, dwell: int = 4, half_count_clocks: int = 8
) -> Scenario:
    """Return a scenario in which the disc passes a mark from both sides and moves to and fro over
    both edges of the mark.

    ``dwell`` is the number of half counts of a movement to and fro.
    """

    def way(half_counts: int) -> Segment:
        return Segment(
            half_count_clocks * abs(half_counts), 2 * half_count_clocks, down=half_counts < 0
        )

    def tremble(first: int) -> list[Segment]:
        return [way(first * sign) for sign in (1, -1) * 6]

    segments = [way(5), *tremble(dwell)]  # from count -2 to the middle of count 0, the mark's first
    segments += [way(2 * width), *tremble(-dwell), *tremble(dwell)]
    segments += [way(30), way(-30), *tremble(dwell), *tremble(-dwell)]
    segments += [way(-2 * width), *tremble(-dwell), way(-8)]
    return Scenario(
        [RESET, Segment(10), *segments, Segment(40)],
        1000,
        start=-2,
        index_width=Fraction(width),
        skew_clocks=skew_clocks,
    )


SKEWED: dict[str, Scenario] = {
    f"skewed_pins_{a}{b}{z}_mark_of_{width}": skewed((a, b, z), width)
    for a, b, z, width in ((0, 3, 1, 17), (3, 0, 2, 17), (1, 1, 0, 2), (2, 3, 3, 1), (1, 0, 3, 17))
} | {
    # These spacings lie just above and below the smallest spacing at which the skew displaces no
    # mark.
    f"skewed_pins_330_{2 * half_count}_clocks_a_count": skewed(
        (3, 3, 0), 17, half_count_clocks=half_count
    )
    for half_count in (4, 3, 2)
}
"""Scenarios in which A, B and Z have different delays of up to three clocks."""


def scenarios_to_run(default_generics: bool) -> list[str]:
    """Return the names of the scenarios for a bench: all scenarios for the default generics, and
    for other generics only those whose result depends on the generics."""
    if default_generics:
        return [*LOSSLESS, *SCATTERED, *FAULTY, *SKEWED, *RANDOM_SEEDS]
    return [
        "edge_every_clock_turn_of_7",
        "wanders_turn_of_100",
        "reset_of_one_clock_while_moving",
        *RANDOM_SEEDS,
    ]


def _moves(segment: Segment, random: np.random.Generator) -> NDArray[np.int64]:
    """Return the number of units by which the disc moves in each clock, without jitter."""
    moves = np.zeros(segment.clocks, dtype=np.int64)
    if segment.wander:
        lengths = random.integers(1, 40, segment.clocks)
        speeds = random.integers(-UNITS, UNITS + 1, segment.clocks)
        speeds[random.random(segment.clocks) < 0.3] = UNITS
        speeds[random.random(segment.clocks) < 0.3] = -UNITS
        moves[:] = np.repeat(speeds, lengths)[: segment.clocks]
    elif segment.clocks_a_count:
        moves[:] = UNITS // segment.clocks_a_count * (-1 if segment.down else 1)
        if UNITS % segment.clocks_a_count:
            whole = np.arange(segment.clocks + 1) * UNITS // segment.clocks_a_count
            moves[:] = np.diff(whole) * (-1 if segment.down else 1)
    moves[:1] += segment.jump * UNITS
    return moves


def _jitter(segment: Segment, random: np.random.Generator) -> NDArray[np.int64]:
    most = int(segment.jitter * UNITS)
    return random.integers(-most, most + 1, segment.clocks)


def _glitches(
    pins: NDArray[np.int64], scenario: Scenario, random: np.random.Generator
) -> NDArray[np.int64]:
    """Return a mask of the pins that glitches invert in each clock, shape (clocks, 3). Glitches do
    not come near a true change."""
    changes = np.flatnonzero((np.diff(pins, axis=0) != 0).any(axis=1)) + 1
    turned_over = np.zeros_like(pins)
    end = 0
    for segment in scenario.segments:
        clock, end = end, end + segment.clocks
        quiet = segment.filter_length + 2
        while segment.glitch_clocks and clock + segment.glitch_clocks + quiet < end:
            stop = clock + segment.glitch_clocks
            near = np.searchsorted(changes, [clock - quiet, stop + quiet])
            if near[0] == near[1]:
                turned_over[clock:stop, random.integers(3)] = 1
                clock = stop + quiet
            clock += int(random.integers(1, 4))
    return turned_over


def stimuli_of(scenario: Scenario) -> Stimuli:
    random = np.random.default_rng(scenario.seed)
    segments = scenario.segments
    lengths = [segment.clocks for segment in segments]
    place = scenario.start * UNITS + np.cumsum(
        np.concatenate([_moves(s, random) for s in segments])
    )
    place += np.concatenate([_jitter(s, random) for s in segments])

    # The counts per turn of the disc do not change within a scenario; only the setting
    # counts_per_rev does.
    from_index = place - int(scenario.index_at * UNITS)
    turn = scenario.counts_per_rev * UNITS
    # A visit to a mark lasts while the disc is within half a turn of it; each visit has a
    # displacement of its own.
    visit = np.cumsum(np.diff((from_index + turn // 2) // turn, prepend=0) != 0)
    scatter = random.integers(-scenario.index_scatter, scenario.index_scatter + 1, visit[-1] + 1)[
        visit
    ]
    in_turn = (from_index - scatter * UNITS) % turn
    # (A, B) follow figure 4 of the paper: 00, 10, 11, 01 as the count rises.
    quarter = place // UNITS % 4
    pins = np.column_stack(
        [
            (quarter == 1) | (quarter == 2),
            (quarter == 2) | (quarter == 3),
            in_turn < int(scenario.index_width * UNITS),
        ]
    ).astype(np.int64)
    for pin, skew in enumerate(scenario.skew_clocks):
        pins[skew:, pin] = pins[: len(pins) - skew, pin].copy()
    pins ^= _glitches(pins, scenario, random)

    def each_clock(values: list[int]) -> NDArray[np.int64]:
        return np.repeat(np.array(values, dtype=np.int64), lengths)

    clear = np.zeros(len(place), dtype=np.int64)
    clear[np.cumsum([0, *lengths[:-1]])] = [int(s.clear) for s in segments]
    columns = {
        "a": pins[:, 0],
        "b": pins[:, 1],
        "z": pins[:, 2],
        "counts_per_rev": each_clock(
            [s.counts_per_rev or scenario.counts_per_rev for s in segments]
        ),
        "filter_length": each_clock([s.filter_length for s in segments]),
        "minimum_edge_spacing": each_clock([s.minimum_edge_spacing for s in segments]),
        "index_tolerance": each_clock([s.index_tolerance for s in segments]),
        "clear": clear,
        "zero_again": each_clock([int(s.zero_again) for s in segments]),
        "heal": each_clock([int(s.heal) for s in segments]),
        "other_head_agrees": each_clock([int(s.other_head_agrees) for s in segments]),
        "rearm": each_clock([int(s.rearm) for s in segments]),
        "reset": each_clock([int(s.reset) for s in segments]),
    }
    # Additions of uint64 wrap like the counter.
    timestamp = np.uint64(scenario.first_timestamp) + np.arange(len(place), dtype=np.uint64)
    return Stimuli(columns, timestamp, place, scatter)


def _held(
    random: np.random.Generator, values: list[int], clocks: int, mean: int
) -> NDArray[np.int64]:
    """Return a random value for each clock; a value lasts for a random time of ``mean`` clocks on
    average."""
    changes = random.random(clocks) < 1 / mean
    return random.choice(values, clocks + 1)[np.cumsum(changes)]


def _at_random(seed: int, clocks: int = 8000) -> Stimuli:
    random = np.random.default_rng(seed)

    def at_times(mean: int) -> NDArray[np.int64]:
        return (random.random(clocks) < 1 / mean).astype(np.int64)

    bit_hold = [1, 2, 5, 9][seed]
    columns = {pin: _held(random, [0, 1], clocks, bit_hold) for pin in "abz"}
    columns |= {
        "counts_per_rev": _held(random, [4, 5, 6, 7, 9, 2**24], clocks, 30),
        "filter_length": _held(random, [0, 1, 1, 1, 2, 3, 5], clocks, 100),
        "minimum_edge_spacing": _held(random, [0, 1, 2, 3, 7], clocks, 100),
        "index_tolerance": _held(random, [0, 0, 1, 2, 3, 2**16 - 1], clocks, 60),
        "clear": at_times(25),
        "zero_again": _held(random, [0, 1], clocks, 200),
        "heal": _held(random, [0, 1], clocks, 150),
        "other_head_agrees": _held(random, [0, 0, 1], clocks, 50),
        "rearm": at_times(40) | _held(random, [0, 0, 0, 0, 1], clocks, 20),
        "reset": at_times(150),
    }
    columns["reset"][0] = 1
    timestamp = random.integers(0, 2**64, clocks, dtype=np.uint64)
    return Stimuli(columns, timestamp, np.zeros(clocks, dtype=np.int64))


def stimuli(name: str) -> Stimuli:
    """Return the inputs of a scenario and the true places of the disc; for random pins the places
    are 0."""
    if name in RANDOM_SEEDS:
        return _at_random(RANDOM_SEEDS[name])
    return stimuli_of((LOSSLESS | SCATTERED | FAULTY | SKEWED)[name])
