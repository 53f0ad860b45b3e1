import pytest

from tb.support.simulation import simulate


@pytest.mark.parametrize(
    ("top", "heads"),
    [
        ("encoder_source_top", 2),
        pytest.param("encoder_source_heads_top", 4, marks=pytest.mark.large),
    ],
)
def test_encoder_source_top(top: str, heads: int) -> None:
    simulate(top, "tb.top.encoder_source_top_bench", environment={"HEADS": str(heads)})
