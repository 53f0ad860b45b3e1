"""Makes random inputs, within the ranges of the ports, to compare netlists with the VHDL."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from arctrue.generated.number_formats import (
    AMPLITUDE_SWEEP_CLOCKS,
    AMPLITUDE_WIDTH,
    COUNTS_PER_REV_MAX,
    HEADS_MAX,
    LOCAL_VALUE_WIDTH,
    MEAN_TERM_FRACTION,
    MEAN_TERM_WIDTH,
    PAIR_WIDTH,
    PHASE_STEP_WIDTH,
    PHASE_WIDTH,
    TURN_NUMBER_WIDTH,
)

Stimulus = dict[str, list[int]]
LANES = 3
"""Number of lanes, which is odd, so that one pair has only one lane."""
FOLD = 2
DEPTH = 8


@dataclass(frozen=True)
class Case:
    """Entity with its generics and inputs; from clock ``settled`` on its outputs have no unknown
    bits."""

    entity: str
    generics: dict[str, int | str]
    stimulus: Callable[[np.random.Generator], Stimulus]
    settled: int
    in_core: bool = False
    """Whether the cores in ``test_equal.py`` contain this entity with these generics too."""

    def __str__(self) -> str:
        return "-".join([self.entity, *(f"{name}{value}" for name, value in self.generics.items())])


def bits(random: np.random.Generator, width: int, clocks: int) -> list[int]:
    """Return a random word per clock; in some words all bits are 0, all bits are 1, or one bit is
    1."""
    data = random.bytes(clocks * (width // 8 + 1))
    size = width // 8 + 1
    mask = 2**width - 1
    words = [int.from_bytes(data[at : at + size], "big") & mask for at in range(0, len(data), size)]
    kinds = random.integers(0, 16, clocks)
    places = random.integers(0, width, clocks)
    special = {0: lambda _: 0, 1: lambda _: mask, 2: lambda place: 1 << place}
    return [
        special[kind](place) if kind in special else word
        for word, kind, place in zip(words, kinds.tolist(), places.tolist(), strict=True)
    ]


def held(values: list[int], clocks: int) -> list[int]:
    """Return the values, each repeated for this number of clocks."""
    return [value for value in values for _ in range(clocks)]


def pulses(random: np.random.Generator, share: float, clocks: int) -> list[int]:
    return (random.random(clocks) < share).astype(int).tolist()


def reset_first(clocks: int, random: np.random.Generator, share: float = 0.002) -> list[int]:
    """Return a reset that is high in the first clocks, then in a ``share`` of the clocks."""
    return [1] * 4 + pulses(random, share, clocks - 4)


def walk(random: np.random.Generator, clocks: int, most: int = 1) -> np.ndarray:
    """Return positions that move to and fro, by up to ``most`` counts per clock."""
    direction = np.repeat(random.choice([-1, 1], clocks // 40 + 1), 40)[:clocks]
    return np.cumsum(direction * random.integers(0, most + 1, clocks))


def phase_unit(random: np.random.Generator) -> Stimulus:
    clocks = 600
    return {
        "angle": bits(random, 24, clocks),
        "phase_steps": held(bits(random, LANES * PHASE_STEP_WIDTH, clocks // 4), 4),
        "phase_offsets": bits(random, LANES * PHASE_WIDTH, clocks),
    }


def harmonic_unit(random: np.random.Generator) -> Stimulus:
    clocks = 1200
    return {
        "phases": bits(random, LANES * PHASE_WIDTH, clocks),
        "amplitudes": bits(random, LANES * AMPLITUDE_WIDTH, clocks),
    }


def cordic_rotation(random: np.random.Generator) -> Stimulus:
    return {"place": bits(random, 22, 2000), "mirrored": bits(random, 1, 2000)}


def table_rotation(random: np.random.Generator) -> Stimulus:
    return {"folded": bits(random, 22, 2000)}


def error_compensation(random: np.random.Generator) -> Stimulus:
    clocks = 1500
    turn = COUNTS_PER_REV_MAX - 12345
    pairs = (LANES + 1) // 2
    # Some sums are far beyond the limit and are clipped; most sums are small, so that the ramp
    # ends.
    small = [word >> 20 for word in bits(random, PAIR_WIDTH, clocks * pairs)]
    large = bits(random, PAIR_WIDTH, clocks * pairs)
    which = random.random(clocks * pairs) < 0.05
    words = [big if one else little for one, big, little in zip(which, large, small, strict=True)]
    flat = [
        sum(words[clock * pairs + pair] << (PAIR_WIDTH * pair) for pair in range(pairs))
        for clock in range(clocks)
    ]
    given = {
        "reset": reset_first(clocks, random),
        "pair_sums": flat,
        "offset": held(bits(random, AMPLITUDE_WIDTH, clocks // 50), 50),
        "angle": random.integers(0, turn, clocks).tolist(),
        "position": bits(random, 32, clocks),
        "apply": held(pulses(random, 0.7, clocks // 30), 30),
        "swap_marker": pulses(random, 0.02, clocks),
        "zero_moved": held(pulses(random, 0.5, clocks // 60), 60),
        "put_back": held(bits(random, 16, clocks // 60), 60),
        "referenced": pulses(random, 0.5, clocks),
        "counts_per_rev": [turn] * clocks,
        "ramp_rate": held(bits(random, 32, clocks // 100), 100),
        # The acceleration of the ramp is unlimited (0) in some stretches and limited in others.
        "ramp_acceleration": held([0, 2**32 - 1, 2**29, 0, 2**31], clocks // 5),
        "first_sums": [1] * clocks,
        "last_sums": [1] * clocks,
        "local_value": bits(random, LOCAL_VALUE_WIDTH, clocks),
    }
    return given | changes_of_carrier(random, given["swap_marker"])


def changes_of_carrier(random: np.random.Generator, swap_marker: list[int]) -> Stimulus:
    """Return the inputs for the mean; the carrier changes at some of the swaps only."""
    clocks = len(swap_marker)
    # Most terms are below a count, so that the ramp ends; some reach the limit of weighted_mean.
    most = 3 * 2**17 + 1 << MEAN_TERM_FRACTION
    large = random.random(clocks) < 0.05
    terms = np.where(
        large,
        random.integers(-most, most + 1, clocks),
        random.integers(-(2**MEAN_TERM_FRACTION), 2**MEAN_TERM_FRACTION + 1, clocks),
    )
    return {
        "mean_term": (terms % 2**MEAN_TERM_WIDTH).tolist(),
        "jumped": (np.array(swap_marker) & pulses(random, 0.5, clocks)).tolist(),
        "jump": bits(random, 16, clocks),
    }


def folded_error_compensation(random: np.random.Generator) -> Stimulus:
    """Return inputs in which the pair sums of an angle come in FOLD consecutive clocks; the reading
    stays constant in these clocks."""
    given = error_compensation(random)
    clocks = len(given["reset"])
    for name in (
        "angle",
        "position",
        "apply",
        "swap_marker",
        "zero_moved",
        "put_back",
        "referenced",
        "mean_term",
        "jumped",
        "jump",
    ):
        given[name] = held(given[name][::FOLD], FOLD)
    given["first_sums"] = [int(clock % FOLD == 0) for clock in range(clocks)]
    given["last_sums"] = [int(clock % FOLD == FOLD - 1) for clock in range(clocks)]
    return given


def delay_line(random: np.random.Generator) -> Stimulus:
    return {"undelayed": bits(random, 57, 200)}


def quadrature_decoder(random: np.random.Generator) -> Stimulus:
    clocks, turn = 4000, 20
    position = walk(random, clocks)
    levels = np.array([0b00, 0b01, 0b11, 0b10])[position % 4]
    levels ^= np.where(random.random(clocks) < 0.01, random.integers(0, 4, clocks), 0)
    index = (position % turn < 2).astype(int) ^ (random.random(clocks) < 0.004)
    return {
        "reset": reset_first(clocks, random, 0.0005),
        "a": (levels & 1).tolist(),
        "b": (levels >> 1).tolist(),
        "z": index.tolist(),
        "counts_per_rev": held([turn, turn, turn + 3, turn], clocks // 4),
        "filter_length": held([1, 0, 2, 1, 3, 1, 1, 5], clocks // 8),
        "minimum_edge_spacing": held([0, 2, 5, 0], clocks // 4),
        "index_tolerance": held([0, 1, 0, 60000], clocks // 4),
        "timestamp": list(range(2**40, 2**40 + clocks)),
        "clear": pulses(random, 0.004, clocks),
        "zero_again": held([0, 1, 1, 1], clocks // 4),
        "heal": held([0, 1, 0, 1], clocks // 4),
        "other_head_agrees": pulses(random, 0.3, clocks),
        "rearm": held(pulses(random, 0.05, clocks // 10), 10),
        "delay": held([0, 1, 2, *random.integers(3, 256, 5).tolist()], clocks // 8),
    }


def quadrature_output(random: np.random.Generator) -> Stimulus:
    clocks, turn = 4000, 37
    position = walk(random, clocks, 2) // 2 + 2**31 - 200
    position += np.where(np.arange(clocks) > clocks // 2, 300, 0)
    pins = {
        name: held(pulses(random, 0.5, clocks // 100), 100)
        for name in ("invert_a", "invert_b", "invert_z", "swap_ab")
    }
    return {
        "reset": reset_first(clocks, random, 0.0005),
        "enable": held(pulses(random, 0.9, clocks // 50), 50),
        "clear": pulses(random, 0.005, clocks),
        **pins,
        "corrected_position": (position % 2**32).tolist(),
        "corrected_angle": (position % turn).tolist(),
        "referenced": held(pulses(random, 0.8, clocks // 50), 50),
        "phase_of_zero": held(random.integers(0, 4, clocks // 400).tolist(), 400),
        "z_gated": held(pulses(random, 0.5, clocks // 400), 400),
        "z_state": held(random.integers(0, 4, clocks // 400).tolist(), 400),
        "z_width": held(random.integers(0, 3, clocks // 400).tolist(), 400),
        "counts_per_rev": [turn] * clocks,
        "minimum_spacing": held([0, 1, 2, 3, 1, 7, 0, 1], clocks // 8),
        "following_limit": held([100, 4, 2, 60000], clocks // 4),
    }


def sampler(random: np.random.Generator) -> Stimulus:
    clocks, turn = 5000, 40
    first = np.cumsum(random.integers(0, 2, clocks))
    second = first + 3 + random.integers(0, 2, clocks)
    flags = {
        f"{name}{head}": pulses(random, 0.02, clocks)
        for name in ("index_error", "illegal", "overspeed")
        for head in (1, 2)
    }
    given = {
        "reset": reset_first(clocks, random, 0.0005),
        "enable": held(pulses(random, 0.9, clocks // 100), 100),
        # The modes are sampling at equal times (0), at equal angles (1), on request (2), and no
        # sampling (3).
        "mode": held([0, 1, 2, 0, 1, 2, 3, 1, 2, 1], clocks // 10),
        "external": pulses(random, 0.1, clocks),
        "sample_period": held([11, 1, 5, 7, 15], clocks // 5),
        "angle_step": held([7, 5, 5, 11, 1], clocks // 5),
        "counts_per_rev": [turn] * clocks,
        "timestamp": list(range(2**33, 2**33 + clocks)),
        "turn_position1": (first % 2**32).tolist(),
        "turn_position2": (second % 2**32).tolist(),
        "index_seen1": [int(clock > 30) for clock in range(clocks)],
        "index_seen2": [int(clock > 20) for clock in range(clocks)],
        **flags,
        "release_bank": pulses(random, 0.02, clocks),
        "read_enable": pulses(random, 0.3, clocks),
        "read_address": random.integers(0, 2 * DEPTH, clocks).tolist(),
        "zero_moved1": (np.cumsum(pulses(random, 0.005, clocks)) % 2).tolist(),
    }
    return given | further_heads(random, second)


def further_heads(random: np.random.Generator, reference: np.ndarray) -> Stimulus:
    """Return the sampler's inputs for heads 3 and 4; ``reference`` has the reference head's
    positions."""
    clocks = reference.size
    third = (reference + 5 + random.integers(0, 2, clocks)) % 2**32
    fourth = (reference - 9 + random.integers(0, 2, clocks)) % 2**32
    flags = sum(np.array(pulses(random, 0.02, clocks)) << flag for flag in range(8))
    return {
        "reference_position": (reference % 2**32).tolist(),
        "reference_zero_moved": (np.cumsum(pulses(random, 0.005, clocks)) % 2).tolist(),
        "further_positions": [
            high << 32 | low for high, low in zip(fourth.tolist(), third.tolist(), strict=True)
        ],
        "further_flags": flags.tolist(),
        "read_further": pulses(random, 0.5, clocks),
    }


def coefficient_memory(random: np.random.Generator, apart: int = 60) -> Stimulus:
    clocks = 60 * apart
    # A write waits while the idle bank is being filled. The next write must come after the
    # acknowledge, so writes are ``apart`` clocks apart.
    slots = random.random(clocks // apart) < 0.8
    offsets = random.random(clocks // apart) < 0.2
    first = [1] + [0] * (apart - 1)
    write = [bit if slot else 0 for slot in slots & ~offsets for bit in first]
    write_offset = [bit if slot else 0 for slot in slots & offsets for bit in first]
    return {
        "reset": reset_first(clocks, random, 0.001),
        "write_enable": write,
        "write_offset": write_offset,
        "write_address": held(random.integers(0, 4 * (LANES + 1), clocks // apart).tolist(), apart),
        "write_data": held(bits(random, 32, clocks // apart), apart),
        "read_address": random.integers(0, 4 * (LANES + 1), clocks).tolist(),
        "swap_allowed": [int(clock % 3 != 1) for clock in range(clocks)],
        "slot": [0] * clocks,
        "swap": np.eye(apart, dtype=int)[random.integers(0, 11, clocks // apart)].ravel().tolist(),
        "sweep_step": (np.arange(clocks) % AMPLITUDE_SWEEP_CLOCKS).tolist(),
        "write_turn_step": [0] * clocks,
        "read_turn_step": random.integers(0, 2, clocks).tolist(),
        "turn": held(bits(random, TURN_NUMBER_WIDTH, clocks // 500 + 1), 500)[:clocks],
        "turn_select": held(bits(random, 2, clocks // 500 + 1), 500)[:clocks],
        **{
            name: held(bits(random, 18, clocks // 100 + 1), 100)[:clocks]
            for name in ("direction", "speed", "idle_speed", "word_a", "word_b")
        },
    }


def folded_coefficient_memory(random: np.random.Generator) -> Stimulus:
    stimulus = coefficient_memory(random)
    clocks = len(stimulus["slot"])
    slots = np.arange(clocks) % FOLD
    return {**stimulus, "slot": slots.tolist(), "swap_allowed": (slots == FOLD - 1).tolist()}


def modulated_coefficient_memory(random: np.random.Generator) -> Stimulus:
    """Return inputs whose writes are so far apart that a swap can wait for a whole sweep, and the
    next write can wait for the swap."""
    return coefficient_memory(random, 3 * AMPLITUDE_SWEEP_CLOCKS)


def real_order_coefficient_memory(random: np.random.Generator) -> Stimulus:
    """Return inputs that also write turn steps; all writes are 400 clocks apart."""
    stimulus = coefficient_memory(random, 400)
    write = np.array(stimulus["write_enable"])
    of_turn_step = random.random(write.size) < 0.4
    return {
        **stimulus,
        "write_enable": (write * ~of_turn_step).tolist(),
        "write_turn_step": (write * of_turn_step).tolist(),
        "write_address": [word % (2 * LANES) for word in stimulus["write_address"]],
    }


def table_conditions(random: np.random.Generator) -> Stimulus:
    """Return readings of a table that moves to and fro, swaps that hold the writes for up to 60
    clocks, and writes of registers, which are frequent at the start and rare later."""
    clocks = 24_000
    place = np.cumsum(held(random.integers(-1, 2, clocks // 800).tolist(), 800))
    place = place // 3
    writes = np.zeros(clocks, dtype=np.int64)
    writes[60:2000:90] = 1
    writes[2000::1700] = 1
    holds = np.array(held(pulses(random, 0.1, clocks // 60), 60))
    return {
        "reset": reset_first(clocks, random, 0.0),
        "position": (place % 2**32).tolist(),
        "put_back": held(random.integers(0, 3, clocks // 4000).tolist(), 4000),
        "corrected_position": (place % 2**32).tolist(),
        "correction": (random.integers(0, 2048, clocks)).tolist(),
        "read_enable": pulses(random, 0.1, clocks),
        "write_enable": writes.tolist(),
        "address": held(random.integers(0, 10, clocks // 30).tolist(), 30),
        "write_data": held([word >> 12 for word in bits(random, 32, clocks // 30)], 30),
        "hold_writes": holds.tolist(),
        # A swap takes effect in the last clock that holds the writes.
        "swap_comes": (holds & ~np.append(holds[1:], 0)).tolist(),
        "speed_squared": held(bits(random, 18, clocks // 100), 100),
    }


CASES = (
    Case("table_conditions", {"WINDOW": 7, "LONGEST": 11}, table_conditions, 80),
    Case(
        "coefficient_memory",
        {"LANES": LANES, "MODULATORS": "true"},
        modulated_coefficient_memory,
        300,
    ),
    Case(
        "coefficient_memory",
        {"LANES": LANES, "REAL_ORDERS": "true"},
        real_order_coefficient_memory,
        300,
    ),
    Case("phase_unit", {"LANES": LANES}, phase_unit, 10, in_core=True),
    Case("cordic_rotation", {}, cordic_rotation, 30, in_core=True),
    Case("table_rotation", {}, table_rotation, 30, in_core=True),
    Case("harmonic_unit", {"LANES": LANES}, harmonic_unit, 40, in_core=True),
    Case("error_compensation", {"LANES": LANES}, error_compensation, 20, in_core=True),
    Case(
        "error_compensation",
        {"LANES": LANES, "FOLD": FOLD},
        folded_error_compensation,
        20,
        in_core=True,
    ),
    Case("error_compensation", {"LANES": LANES, "MEAN": "true"}, error_compensation, 20),
    Case("error_compensation", {"LANES": LANES, "LOCAL_TABLE": "true"}, error_compensation, 20),
    Case("delay_line", {"WIDTH": 57, "CLOCKS": 25}, delay_line, 30, in_core=True),
    Case("quadrature_decoder", {}, quadrature_decoder, 20, in_core=True),
    Case("quadrature_decoder", {"DELAYED": "true"}, quadrature_decoder, 20),
    Case("quadrature_output", {}, quadrature_output, 20, in_core=True),
    Case("sampler", {"DEPTH": DEPTH}, sampler, 200, in_core=True),
    Case("sampler", {"DEPTH": DEPTH, "HEADS": HEADS_MAX}, sampler, 200),
    Case("coefficient_memory", {"LANES": LANES}, coefficient_memory, 20, in_core=True),
    Case(
        "coefficient_memory",
        {"LANES": LANES * FOLD, "FOLD": FOLD},
        folded_coefficient_memory,
        20,
        in_core=True,
    ),
)
