"""Runs in GHDL the bench of encoder_source, the design for a second board that takes the place of
the encoder."""

import pytest

from tb.encoder_source.encoder_source_bench import (
    AHEAD,
    AMPLITUDES,
    COUNTS_PER_REV,
    COUNTS_PER_SECOND,
)
from tb.support.simulation import simulate


@pytest.mark.parametrize("heads", [2, pytest.param(4, marks=pytest.mark.large)])
def test_encoder_source(heads: int) -> None:
    generics = {
        "COUNTS_PER_REV": COUNTS_PER_REV,
        "COUNTS_PER_SECOND": COUNTS_PER_SECOND,
        "HEADS": heads,
        "HEAD_SEPARATION": AHEAD[1],
        "HEAD3_AHEAD": AHEAD[2],
        "HEAD4_AHEAD": AHEAD[3],
        "ECCENTRICITY": AMPLITUDES[0],
        "OVALITY": AMPLITUDES[1],
    }
    simulate(
        "encoder_source",
        "tb.encoder_source.encoder_source_bench",
        generics=generics,
        environment={"HEADS": str(heads)},
    )
