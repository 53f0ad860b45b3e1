"""Tests that the workbench's statements about correction by the gateware agree with what ``arctrue
export`` can write."""

from __future__ import annotations

from arctrue.cli.effects import CORRECTED_BY
from arctrue.workbench.diagnose.report import COMPENSATION_WORDS
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.effects.scalar_effect import ScalarEffect


def test_effects_with_lanes_by_condition_name_the_bitstream() -> None:
    """Effects whose correction follows a condition state that they need a bitstream with
    MODULATORS."""
    followed = {
        name
        for name, kind in built_in().items()
        if any("conditioned_lanes" in vars(base) for base in kind.__mro__[:1])
        and issubclass(kind, ScalarEffect)
    }
    said = {name for name, kind in built_in().items() if kind.compensation == "modulators"}
    assert followed == said == {"hysteresis", "latency"}
    assert "MODULATORS" in COMPENSATION_WORDS["modulators"]
    assert "MODULATORS" in CORRECTED_BY["modulators"]
    for name in said:
        note = built_in()[name].compensation_note
        assert "default bitstream cannot" in note


def test_effects_of_the_local_table_name_the_bitstream() -> None:
    """Effects with a local error state that they need a bitstream with LOCAL_TABLE."""
    local = {name for name, kind in built_in().items() if "local_error" in vars(kind)}
    said = {name for name, kind in built_in().items() if kind.compensation == "local_table"}
    assert local == said == {"graduation_defect"}
    assert "LOCAL_TABLE" in COMPENSATION_WORDS["local_table"]
    assert "LOCAL_TABLE" in CORRECTED_BY["local_table"]
