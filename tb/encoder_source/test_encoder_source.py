"""The second board that stands in for the encoder, in GHDL."""

from tb.encoder_source.encoder_source_bench import AMPLITUDES, COUNTS_PER_REV, SEPARATION
from tb.support.simulation import simulate


def test_encoder_source() -> None:
    generics = {
        "COUNTS_PER_REV": COUNTS_PER_REV,
        "COUNTS_PER_SECOND": 20_000_000,
        "HEAD_SEPARATION": SEPARATION,
        "ECCENTRICITY": AMPLITUDES[0],
        "OVALITY": AMPLITUDES[1],
    }
    simulate(
        "encoder_source",
        "tb.encoder_source.encoder_source_bench",
        generics=generics,
        backend="llvm",
    )
