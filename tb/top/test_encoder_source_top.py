from tb.support.simulation import simulate


def test_encoder_source_top() -> None:
    simulate("encoder_source_top", "tb.top.encoder_source_top_bench", backend="llvm")
