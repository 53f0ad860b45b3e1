"""Runs the bench of the sampler in GHDL, for banks of several depths."""

import pytest

from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT
from tb.support.simulation import simulate


@pytest.mark.parametrize(
    "depth",
    [
        pytest.param(2, marks=pytest.mark.large),
        pytest.param(13, marks=pytest.mark.large),
        16,
        pytest.param(CAPTURE_DEPTH_DEFAULT, marks=pytest.mark.large),
    ],
)
def test_sampler(depth: int) -> None:
    simulate(
        "sampler",
        "tb.sampler.sampler_bench",
        generics={"DEPTH": depth},
        environment={"CAPTURE_DEPTH": str(depth)},
    )


def test_four_heads() -> None:
    """Heads 3 and 4 are sampled in the same clocks as heads 1 and 2, have their own flags, and are
    read separately."""
    simulate(
        "sampler",
        "tb.sampler.sampler_bench",
        generics={"DEPTH": 13, "HEADS": 4},
        environment={"CAPTURE_DEPTH": "13", "HEADS": "4"},
    )
