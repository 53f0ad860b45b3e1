"""The page on CORDIC cores, without the cores: a model stands for what is measured of them."""

from __future__ import annotations

from collections.abc import Callable
from math import inf
from pathlib import Path

import pytest
from scripts import compare_cordic, flopoco_lanes
from scripts.compare_cordic import CORES, OWN_LANES, measure_fastest
from scripts.flopoco_lanes import NotMadeError
from scripts.lane_measurement import Core, Measured
from scripts.netlist import TimeLimitError, ToolError
from scripts.resources import Resources


def _page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, measure: Callable[..., Measured], *more: str
) -> str:
    monkeypatch.setattr(compare_cordic, "measure", measure)
    monkeypatch.setattr(compare_cordic, "find_ghdl", lambda: ("ghdl", "GHDL 5.0.1"))
    monkeypatch.setattr(compare_cordic, "find_yosys", lambda: ("yosys", "Yosys 0.23"))
    monkeypatch.setattr(compare_cordic, "verilator_version", lambda: "5.006")
    monkeypatch.setattr(compare_cordic, "WORK", tmp_path / "work")
    page = tmp_path / "page.md"
    assert compare_cordic.main(["--output", str(page), *more]) == 0
    return page.read_text(encoding="utf-8")


def test_without_clones_the_page_says_what_was_not_measured(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    used = Resources(lut=560, ff=558, carry4=141, dsp=0)
    found = Measured(used, 4.6, 17, 5.25e-5, 5.27e-5)
    text = _page(tmp_path, monkeypatch, lambda *_: found)
    assert "| ArcTrue quadrant_fold + cordic_rotation | this tree | 24 | 560 | 558 |" in text
    for key, core in CORES.items():
        told = f"- not measured: {core.name}: no folder given; {core.origin}" in text
        assert told == (key not in OWN_LANES)
    assert "- not measured: FloPoCo: no program given" in text
    rows = [line for line in text.splitlines() if line.startswith("| ") and "this tree" in line]
    assert len(rows) == len(OWN_LANES)
    assert rows[0].endswith("| 141 | 0 | 0 | 17 | 4.6 | 5.25e-05 | 5.27e-05 |")


def test_a_missing_tool_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def missing(*_: object) -> Measured:
        raise ToolError("verilator is missing")

    monkeypatch.setattr(compare_cordic, "measure", missing)
    page = tmp_path / "page.md"
    assert compare_cordic.main(["--output", str(page)]) == 2
    assert "verilator is missing" in capsys.readouterr().err
    assert not page.exists()


def _lane(name: str) -> Core:
    return Core(name, "top", "origin", lambda *_: "", 1.0, 17, "")


def _measure_by_name(paths_ns: dict[str, float]) -> Callable[..., Measured]:
    def measure(core: Core, *_: object) -> Measured:
        if core.name not in paths_ns:
            raise NotMadeError(f"{core.name} is refused")
        if paths_ns[core.name] == inf:
            raise TimeLimitError(360.0)
        return Measured(Resources(), paths_ns[core.name], 5, 1e-5, 1e-5)

    return measure


@pytest.mark.parametrize(
    ("paths_ns", "chosen"),
    [
        ({"a": 9.0, "b": 4.9, "c": 4.0}, "b"),  # the first within 5 ns
        ({"a": 9.0, "b": 7.0, "c": 7.5}, "b"),  # none is: the shortest
        ({"a": 9.0, "b": 7.0, "c": 7.0}, "b"),  # of two that are as short, the first
        ({"a": 9.0, "b": 7.0}, "b"),  # none is: the shortest that could be made
        ({"a": 9.0, "b": inf, "c": 4.0}, "a"),  # after the limit of time, none is tried
    ],
)
def test_the_lowest_frequency_that_fits_is_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, paths_ns: dict[str, float], chosen: str
) -> None:
    monkeypatch.setattr(compare_cordic, "measure", _measure_by_name(paths_ns))
    core, measured = measure_fastest(map(_lane, "abc"), tmp_path)
    assert (core.name, measured.path_ns) == (chosen, paths_ns[chosen])


def test_an_operator_that_no_frequency_gives_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(compare_cordic, "measure", _measure_by_name({}))
    with pytest.raises(NotMadeError, match="a is refused"):
        measure_fastest(map(_lane, "abc"), tmp_path)
    told = capsys.readouterr().out.splitlines()
    assert told == [f"left out: {name}, : {name} is refused" for name in "abc"]


def test_cores_that_yosys_does_not_map_in_time_stand_on_the_page(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def measure(core: Core, _clones: object, _folder: object, limit_s: float) -> Measured:
        if core is CORES["cordic_ii"] or "method=1" in core.name:
            raise TimeLimitError(limit_s)
        return Measured(Resources(), 4.6, 17, 1e-5, 1e-5)

    program = tmp_path / "flopoco"
    program.write_text("#!/bin/sh\necho 'FixSinCos: Zynq7000'\n", encoding="utf-8")
    program.chmod(0o755)
    more = ["--map-limit", "6", "--flopoco", f"5.0={program}"]
    text = _page(tmp_path, monkeypatch, measure, *more)
    told = "Yosys did not map it in 6 minutes"
    assert f"- not measured: {CORES['cordic_ii'].name}: {told}\n" in text
    for lsb in flopoco_lanes.LSBS:
        assert f"- not measured: FloPoCo 5.0, FixSinCos lsb={lsb} method=1: {told}\n" in text
        for method in (0, 2):
            assert f"| FloPoCo FixSinCos lsb={lsb} method={method}: " in text
    reasons = [line for line in text.splitlines() if line.startswith("- not measured")]
    assert len(reasons) == 3 + len([key for key in CORES if key not in OWN_LANES])


@pytest.mark.parametrize("limit", ["0", "-1", "nan", "inf", "six"])
def test_a_limit_that_is_no_time_is_refused(capsys: pytest.CaptureFixture[str], limit: str) -> None:
    with pytest.raises(SystemExit):
        compare_cordic.main([f"--map-limit={limit}"])
    assert f"expected minutes above 0, found {limit}" in capsys.readouterr().err


def test_a_missing_flopoco_is_told(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    used = Measured(Resources(), 4.6, 17, 5e-5, 5e-5)
    monkeypatch.setattr(compare_cordic, "measure", lambda *_: used)
    monkeypatch.setattr(compare_cordic, "WORK", tmp_path)
    page = tmp_path / "page.md"
    missing = tmp_path / "nowhere"
    assert compare_cordic.main(["--flopoco", f"5.0={missing}", "--output", str(page)]) == 2
    told = capsys.readouterr().err
    assert f"There is no program {missing}" in told
    assert "--flopoco VERSION=PROGRAM" in told
    assert not page.exists()


def test_a_program_without_its_version_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit):
        compare_cordic.main(["--flopoco", "flopoco"])
    assert "expected VERSION=PROGRAM, found flopoco" in capsys.readouterr().err
