"""Tests that pytest workers share a library of compiled VHDL, which never contains a file's old
version."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from tb.support import simulation

UNIT = """entity unit is
end entity unit;

architecture rtl of unit is
begin
  {statement}
end architecture rtl;
"""
CACHES = (
    simulation._files_by_entity,
    simulation.vhdl_sources,
    simulation._flat,
    simulation._built,
)


def forget() -> None:
    """Clear the caches, so that this process behaves like another worker."""
    for cached in CACHES:
        cached.cache_clear()


@pytest.fixture
def tree(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Path]:
    """Yield a source tree with one entity."""
    (tmp_path / "rtl").mkdir()
    monkeypatch.setattr(simulation, "ROOT", tmp_path)
    monkeypatch.setattr(simulation, "GENERATED_VHDL", tmp_path / "generated")
    write(tmp_path, 'assert false report "one" severity note;')
    forget()
    yield tmp_path
    forget()


def write(tree: Path, statement: str) -> None:
    (tree / "rtl" / "unit.vhd").write_text(UNIT.format(statement=statement), encoding="utf-8")


def steps_of(worker: str, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Build the entity as the pytest worker ``worker``; return the GHDL commands that were run."""
    seen: list[str] = []
    run = simulation._ghdl

    def noted(folder: Path, *words: str) -> None:
        seen.append(words[0])
        run(folder, *words)

    with monkeypatch.context() as patch:
        patch.setattr(simulation, "_ghdl", noted)
        patch.setenv("PYTEST_XDIST_WORKER", worker)
        forget()
        simulation._built("unit", "mcode")
    return seen


def test_a_second_worker_uses_what_the_first_has_read(
    tree: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert steps_of("gw0", monkeypatch) == ["-i", "-m"]
    assert steps_of("gw1", monkeypatch) == ["-m"]
    lists = [tree / f"build/tb/unit-mcode-{worker}" / simulation.UNITS for worker in ("gw0", "gw1")]
    assert lists[0].read_bytes() == lists[1].read_bytes()


def test_a_changed_file_is_read_again(tree: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    steps_of("gw0", monkeypatch)
    write(tree, "nonsense")
    with pytest.raises(AssertionError, match="nonsense"):
        steps_of("gw0", monkeypatch)
    write(tree, 'assert false report "two" severity note;')
    assert steps_of("gw0", monkeypatch) == ["-i", "-m"]


def test_a_name_that_no_cocotb_test_has_is_refused() -> None:
    """Otherwise a pytest test that selects cocotb tests would pass after a test was renamed."""
    with pytest.raises(AssertionError, match="no cocotb test has the name every_word_goes_in"):
        simulation.simulate(
            "delay_line",
            "tb.compensation.delay_line_bench",
            generics={"WIDTH": 1, "CLOCKS": 1},
            environment={"WIDTH": "1", "CLOCKS": "1"},
            testcase=("every_word_comes_out_once", "every_word_goes_in"),
        )
