"""The sampler in GHDL, for banks of several depths."""

import pytest

from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT
from tb.support.simulation import simulate


@pytest.mark.parametrize("depth", [2, 13, 16, CAPTURE_DEPTH_DEFAULT])
def test_sampler(depth: int) -> None:
    simulate(
        "sampler",
        "tb.sampler.sampler_bench",
        generics={"DEPTH": depth},
        environment={"CAPTURE_DEPTH": str(depth)},
    )
