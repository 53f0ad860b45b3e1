"""Computes the number of clocks from an angle to its result, from the latencies of the gateware's
parts."""

from __future__ import annotations

from arctrue.gateware.quadrature_decoder import latency_clocks as decoder_clocks
from arctrue.gateware.quadrature_output import LATENCY as OUTPUT_CLOCKS
from arctrue.generated.number_formats import PIPELINE_LATENCY


def pipeline_clocks(fold: int = 1, heads: int = 2) -> int:
    """Return the number of clocks from an accepted reading to its corrected angle, with this FOLD
    and number of heads. Three or four heads need one clock more, in which head_mean subtracts
    their offsets."""
    return PIPELINE_LATENCY + fold - 1 + (heads > 2)


def pin_to_pin_clocks(fold: int = 1, heads: int = 2) -> tuple[int, int]:
    """Return the smallest and the largest number of clocks from an edge at head 1's pins to the
    edge at the output.

    The numbers apply to the shortest input filter and to an edge that no rule delays at the output.
    The pipeline accepts a reading every FOLD clocks, so that an edge waits for up to FOLD − 1
    clocks.
    """
    least = decoder_clocks() + pipeline_clocks(fold, heads) + OUTPUT_CLOCKS
    return least, least + fold - 1
