"""Models ``rtl/decoder/quadrature_decoder.vhd`` bit by bit: every output in every clock.

The model computes registers as sums and latest values of whole arrays, without a loop over the
clocks.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import ArrayLike

from arctrue.gateware.edge_counter import EdgeCounterTrace, counted_edges, edge_counter
from arctrue.gateware.glitch_filter import glitch_filter
from arctrue.gateware.index_zero import IndexZeroTrace, index_zero
from arctrue.gateware.input_synchroniser import input_synchroniser
from arctrue.gateware.latest import clock_before, latest
from arctrue.gateware.plausibility_check import PlausibilityTrace, plausibility_check
from arctrue.generated.number_formats import SYNCHRONISER_STAGES_DEFAULT


def latency_clocks(filter_length: int = 1, stages: int = SYNCHRONISER_STAGES_DEFAULT) -> int:
    """Return the number of clocks from the change of a pin to the change of the position."""
    return stages + max(filter_length, 1) + 2


@dataclass(frozen=True)
class DecoderInputs:
    """Inputs of the decoder; each is one value per clock, or one value for all clocks."""

    a: ArrayLike
    b: ArrayLike
    z: ArrayLike = 0
    counts_per_rev: ArrayLike = 2**24
    """Counts per turn, 4 to 2**24."""
    filter_length: ArrayLike = 1
    """Length of the input filter, clocks; 1 switches the filter off."""
    minimum_edge_spacing: ArrayLike = 0
    """Smallest permitted spacing of edges, clocks; 0 switches the check off."""
    index_tolerance: ArrayLike = 0
    """Tolerance of the index position, counts."""
    timestamp: ArrayLike = 0
    """Present time, clocks, 0 to 2**64 - 1."""
    clear: ArrayLike = False
    rearm: ArrayLike = False
    zero_again: ArrayLike = False
    heal: ArrayLike = False
    other_head_agrees: ArrayLike = False
    reset: ArrayLike = False


@dataclass(frozen=True)
class DecoderTrace(EdgeCounterTrace, IndexZeroTrace, PlausibilityTrace):
    """Every output in every clock, shape (clocks + 1,), in counts unless another unit is stated.

    Element t is the output during clock t; the last element follows the last input.
    """


def quadrature_decoder(
    inputs: DecoderInputs,
    synchroniser_stages: int = SYNCHRONISER_STAGES_DEFAULT,
    reset_position: int = 0,
) -> DecoderTrace:
    """Run the decoder over all clocks of ``inputs``, from power-up on.

    ``reset_position``: value of the position after a reset, counts.

    Raises ValueError if the shapes of the inputs do not fit, if there is no clock, or if a
    ``counts_per_rev`` that the decoder samples is outside 4 to 2**24.
    """
    columns = {field.name: np.atleast_1d(getattr(inputs, field.name)) for field in fields(inputs)}
    columns = dict(zip(columns, np.broadcast_arrays(*columns.values()), strict=True))
    timestamp = columns.pop("timestamp").astype(np.uint64)
    levels_of = ("clear", "rearm", "reset", "zero_again", "heal", "other_head_agrees")
    clear, rearm, reset, zero_again, heal, other_agrees = (
        columns.pop(name) != 0 for name in levels_of
    )
    if clear.size == 0:
        raise ValueError("the inputs hold no clock; expected one value per clock")
    column = {name: values.astype(np.int64) for name, values in columns.items()}
    clocks = np.arange(clear.size)

    # filter_reset stays true until the synchroniser outputs the levels of the last clock of the
    # reset; preload stays true one clock longer.
    since_reset = clocks - clock_before(latest(reset))
    preload = since_reset <= synchroniser_stages + 1
    filter_reset = since_reset <= synchroniser_stages
    levels = [input_synchroniser(column[pin], synchroniser_stages) for pin in ("a", "b", "z")]
    a, b, z = (glitch_filter(pin, column["filter_length"], filter_reset)[:-1] for pin in levels)
    edges = counted_edges(a, b, preload, reset)
    counter = edge_counter(a, b, preload, reset, timestamp, reset_position)
    index, misplaced = index_zero(
        z,
        edges,
        counter.position[1:],
        counts_per_rev=column["counts_per_rev"],
        index_tolerance=column["index_tolerance"],
        rearm=rearm,
        zero_again=zero_again,
        heal=heal,
        other_head_agrees=other_agrees,
        preload=preload,
        reset=reset,
    )
    faults = plausibility_check(
        (levels[0], levels[1]),
        edges,
        misplaced,
        filter_length=column["filter_length"],
        minimum_edge_spacing=column["minimum_edge_spacing"],
        clear=clear,
        settling=filter_reset,
        reset=reset,
    )
    return DecoderTrace(**vars(counter), **vars(index), **vars(faults))
