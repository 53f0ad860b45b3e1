"""Tests how the script reads GHDL's counts: sums over simulations, files in no simulation, and the
budget."""

from __future__ import annotations

import json
import re
import subprocess
from pathlib import Path

import pytest
from tb.support.simulation import vhdl_sources

from scripts.gateware_coverage import (
    BENCHES,
    faults,
    has_body,
    has_statements,
    read_results,
    share,
    table,
)
from scripts.netlist import ROOT, find_ghdl
from scripts.tests.synth.test_netlist import needs_tools

NAMES = re.compile(r'"(\w+)"')

ENTITY = """
entity half_run is
end entity half_run;

architecture rtl of half_run is
begin
  process is
    variable count : natural := 0;
  begin
    count := count + 1;
    if count = 2 then
      count := 7;
    end if;
    wait;
  end process;
end architecture rtl;
"""


def write_result(path: Path, source: Path, lines: dict[int, int], mode: str = "stmt") -> None:
    counted = {str(line): times for line, times in lines.items()}
    entry = {"file": source.name, "dir": str(source.parent), "mode": mode, "result": counted}
    path.write_text(json.dumps({"outputs": [entry]}), encoding="utf-8")


@pytest.fixture
def sources(tmp_path: Path) -> Path:
    folder = tmp_path / "rtl"
    folder.mkdir()
    (folder / "half_run.vhd").write_text(ENTITY, encoding="utf-8")
    return folder


def test_simulations_are_added_up(tmp_path: Path, sources: Path) -> None:
    source = sources / "half_run.vhd"
    write_result(tmp_path / "a.json", source, {9: 1, 10: 0, 11: 0})
    write_result(tmp_path / "b.json", source, {9: 1, 10: 1, 11: 0})
    write_result(tmp_path / "c.json", tmp_path / "bench.vhd", {1: 0})
    found = read_results(tmp_path, sources)
    assert found[source].executed == {9, 10}
    assert found[source].missed == [11]
    assert share(found) == pytest.approx(2 / 3)
    assert faults(found, sources, budget=0.6) == []
    (message,) = faults(found, sources, budget=0.7)
    assert "66.7%" in message
    assert "70%" in message
    assert "| rtl/half_run.vhd | 3 | 2 | 66.7% | 11 |" in table(found, tmp_path)


def test_an_entity_that_only_instantiates_has_no_lines() -> None:
    without = {path.name for path in (ROOT / "rtl").rglob("*.vhd") if not has_statements(path)}
    tops = {
        *("arctrue_zynq_top.vhd", "arctrue_zynq_heads_top.vhd"),
        *("encoder_source_top.vhd", "encoder_source_heads_top.vhd"),
    }
    assert tops <= without
    assert all(name.endswith("_pkg.vhd") for name in without - tops)


def test_a_file_that_nothing_ran_is_named(tmp_path: Path, sources: Path) -> None:
    (sources / "constants_pkg.vhd").write_text("package constants_pkg is end;", encoding="utf-8")
    messages = faults(read_results(tmp_path, sources), sources)
    assert messages[0] == "rtl/half_run.vhd was in no simulation"
    assert not any("constants_pkg" in fault for fault in messages)
    assert "0.0%" in messages[1]


@pytest.mark.parametrize("text", ['{"outputs": [', '{"outputs": [{"file": "a"}]}', "[]"])
def test_half_a_result_is_refused(tmp_path: Path, sources: Path, text: str) -> None:
    (tmp_path / "half.json").write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=r"half\.json"):
        read_results(tmp_path, sources)


def test_benches_that_are_left_out_are_there() -> None:
    for option in BENCHES[1:]:
        file, _, function = option.partition("=")[2].partition("::")
        assert (ROOT / file).exists(), option
        if function:
            assert f"def {function}(" in (ROOT / file).read_text(encoding="utf-8"), option


def test_every_file_is_below_a_bench_that_is_counted() -> None:
    left_out = [ROOT / option.partition("=")[2] for option in BENCHES if "--ignore" in option]
    tests = [
        path
        for path in (ROOT / "tb").rglob("test_*.py")
        if not any(folder in path.parents for folder in left_out)
    ]
    named = {name for path in tests for name in NAMES.findall(path.read_text(encoding="utf-8"))}
    entities = {path.stem for top in ("rtl", "tb") for path in (ROOT / top).rglob("*.vhd")}
    reached = {source for name in named & entities for source in vhdl_sources(name)}
    missing = {path for path in (ROOT / "rtl").rglob("*.vhd") if has_body(path)} - reached
    assert not missing


@needs_tools
def test_what_ghdl_writes_is_read(tmp_path: Path, sources: Path) -> None:
    ghdl, _ = find_ghdl()
    source = sources / "half_run.vhd"
    common = ["--std=08", f"--workdir={tmp_path}"]
    for command in (
        [ghdl, "-a", *common, str(source)],
        [ghdl, "-r", *common, "--coverage", f"--coverage-output={tmp_path}/a.json", "half_run"],
    ):
        subprocess.run(command, check=True, cwd=tmp_path, timeout=60)
    entry = read_results(tmp_path, sources)[source]
    text = ENTITY.splitlines()
    assert [text[line - 1].strip() for line in entry.missed] == ["count := 7;"]
