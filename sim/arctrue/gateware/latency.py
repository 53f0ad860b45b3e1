"""How long an angle takes through the gateware, in clocks, from the latencies of its parts."""

from __future__ import annotations

from arctrue.gateware.quadrature_decoder import latency_clocks as decoder_clocks
from arctrue.gateware.quadrature_output import LATENCY as OUTPUT_CLOCKS
from arctrue.generated.number_formats import PIPELINE_LATENCY


def pipeline_clocks(fold: int = 1) -> int:
    """From an accepted reading to its corrected angle, with FOLD lanes in one pipeline."""
    return PIPELINE_LATENCY + fold - 1


def pin_to_pin_clocks(fold: int = 1) -> tuple[int, int]:
    """From an edge at the pins of head 1 to the edge at the output: least and most.

    With the shortest input filter, and nothing that holds the edge back at the output. The
    pipeline accepts a reading every FOLD clocks, so that an edge waits up to FOLD − 1 for its turn.
    """
    least = decoder_clocks() + pipeline_clocks(fold) + OUTPUT_CLOCKS
    return least, least + fold - 1
