"""Tests ``make bitstream FLOW=vivado`` with a fake Vivado, which runs the script in a real Tcl
interpreter."""

from __future__ import annotations

import os
import shutil
from pathlib import Path

import pytest

from scripts import bitstream
from scripts.bitstream_job import in_order_of_use
from scripts.bitstream_vivado import SCRIPT
from scripts.netlist import ToolError, sources_of
from scripts.tests.device_build.fake_tools import VIVADO, FakeTools

PRELUDE = Path(__file__).with_name("vivado_prelude.tcl")
STEPS = ["synth_design", "opt_design", "place_design", "route_design", "write_bitstream"]


@pytest.fixture
def fakes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> FakeTools:
    tclsh = shutil.which("tclsh")
    assert tclsh, "tclsh is missing: apt-get install tcl"
    made = FakeTools(tmp_path, monkeypatch)
    made.set_path(os.path.dirname(tclsh))  # noqa: PTH120
    made.add("vivado", VIVADO)
    monkeypatch.setenv("FAKE_VIVADO_PRELUDE", str(PRELUDE))
    monkeypatch.setenv("FAKE_COMMANDS", str(tmp_path / "commands"))
    return made


def run(fakes: FakeTools, *more: str) -> int:
    return bitstream.main(["--output", str(fakes.folder / "made"), *more])


def commands(fakes: FakeTools) -> list[list[str]]:
    lines = (fakes.folder / "commands").read_text(encoding="utf-8").splitlines()
    return [line.split() for line in lines]


def test_the_steps_in_their_order(fakes: FakeTools, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(fakes, "--lanes", "8", "--capture-depth", "1024") == 0
    printed = capsys.readouterr().out
    assert "worst setup slack 0.125 ns, worst hold slack 0.125 ns" in printed
    (call,) = fakes.calls("vivado")
    assert call[:2] == ["-mode", "batch"]
    assert call[call.index("-source") + 1] == str(SCRIPT)
    noted = commands(fakes)
    names = [words[0] for words in noted]
    assert [name for name in names if name in STEPS] == STEPS
    synthesis = noted[names.index("synth_design")]
    assert synthesis[synthesis.index("-top") + 1] == "arctrue_zynq_top"
    assert synthesis[synthesis.index("-part") + 1] == "xc7z020clg400-1"
    generics = [synthesis[n + 1] for n, word in enumerate(synthesis) if word == "-generic"]
    assert generics == ["LANES=8", "CAPTURE_DEPTH=1024", "FOLD=1"]
    read = [words[1:] for words in noted if words[0] == "read_xdc"]
    # The processor's file comes first, because it creates the clock that the other files name.
    entities = ["zynq_processor", "quadrature_output", "pulse_output", "chip_dna"]
    scoped = [["-ref", entity, f"{entity}.xdc"] for entity in entities]
    assert read == [*scoped, ["pynq_z2.xdc"], ["arctrue_zynq_top.xdc"]]
    assert names.index("read_xdc") < names.index("synth_design")
    assert ["set_property", "LOC", "Y18", "get_ports"] in noted
    assert all(words[1] == "-vhdl2008" for words in noted if words[0] == "read_vhdl")
    units = [words[2] for words in noted if words[0] == "read_vhdl"]
    assert sorted(units) == sorted(path.stem for path in sources_of("arctrue_zynq_top"))
    for first, later in (
        ("number_formats_pkg", "arctrue_core"),
        ("arctrue_registers_pkg", "arctrue_registers"),
        ("arctrue_core", "arctrue_zynq_top"),
        ("input_synchroniser", "reset_release"),
    ):
        assert units.index(first) < units.index(later)
    reports = fakes.folder / "made" / "reports"
    assert {"timing.rpt", "utilization.rpt", "cdc.rpt", "drc.rpt"} <= {
        path.name for path in reports.iterdir()
    }


def test_rotation_reaches_the_synthesis(fakes: FakeTools) -> None:
    """The flow passes ROTATION to Vivado's synthesis; Vivado expects quotation marks around the
    value of a string generic."""
    assert run(fakes, "--rotation", "table") == 0
    (synthesis,) = (words for words in commands(fakes) if words[0] == "synth_design")
    assert synthesis[synthesis.index('ROTATION="table"') - 1] == "-generic"


def test_heads_choose_the_top_and_its_pins(fakes: FakeTools) -> None:
    """HEADS of 3 and 4 choose the top level and the pin files of all heads; MEAN is a boolean."""
    assert run(fakes, "--heads", "3") == 0
    noted = commands(fakes)
    (synthesis,) = (words for words in noted if words[0] == "synth_design")
    assert synthesis[synthesis.index("-top") + 1] == "arctrue_zynq_heads_top"
    assert synthesis[synthesis.index("HEADS=3") - 1] == "-generic"
    assert ["set_property", "LOC", "V17", "get_ports"] in noted
    assert run(fakes, "--heads", "2", "--mean", "true") == 0
    *_, synthesis = (words for words in commands(fakes) if words[0] == "synth_design")
    assert synthesis[synthesis.index("-top") + 1] == "arctrue_zynq_top"
    assert synthesis[synthesis.index("MEAN=true") - 1] == "-generic"
    assert not [word for word in synthesis if word.startswith("HEADS")]


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--heads", "4", "--top", "arctrue_zynq_differential_top"], "has two heads"),
        (["--heads", "4", "--mean", "false"], "leave MEAN out"),
    ],
)
def test_heads_that_cannot_be_built_are_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str], words: list[str], expected: str
) -> None:
    with pytest.raises(SystemExit):
        run(fakes, *words)
    assert expected in capsys.readouterr().err


@pytest.mark.parametrize(
    ("variable", "value", "printed"),
    [
        ("FAKE_SLACK_SETUP", "-0.001", "the worst setup slack is -0.001 ns, from core/setup_START"),
        ("FAKE_SLACK_HOLD", "-0.02", "the worst hold slack is -0.02 ns"),
        ("FAKE_SLACK_HOLD", "", "no path was timed for hold"),
        ("FAKE_PATHS", "", "no path was timed for setup"),
        ("FAKE_SUMMARY", "Timing constraints are not met.", "does not say that all user"),
        ("FAKE_CLOCKS", "", "no clock reached the design"),
    ],
)
def test_timing_that_is_not_met_fails(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str], variable: str, value: str, printed: str
) -> None:
    fakes.monkeypatch.setenv(variable, value)
    assert run(fakes) == 1
    error = capsys.readouterr().err
    assert "the timing is not met" in error
    assert printed in error
    assert "write_bitstream" not in [words[0] for words in commands(fakes)]
    assert not (fakes.folder / "made" / "arctrue.bit").exists()
    assert (fakes.folder / "made" / "reports" / "timing.rpt").exists()


def test_a_failure_shows_the_end_of_the_log(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.monkeypatch.setenv("FAKE_FAILURE", "synth")
    assert run(fakes) == 2
    error = capsys.readouterr().err
    assert "Vivado failed. The end of" in error
    assert "[Synth 8-27] fake failure" in error


def test_a_bitstream_of_another_chip_is_refused(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    fakes.monkeypatch.setenv("FAKE_IDCODE", "23722093")
    assert run(fakes) == 2
    assert "expected the code 0x03727093" in capsys.readouterr().err


def test_without_vivado_the_command_says_what_to_do(
    fakes: FakeTools, capsys: pytest.CaptureFixture[str]
) -> None:
    (fakes.programs / "vivado").unlink()
    assert run(fakes) == 2
    error = capsys.readouterr().err
    assert "vivado is not on PATH" in error
    assert "VIVADO=/path/to/vivado" in error
    assert "FLOW=open" in error


def test_a_circle_of_files_is_refused(tmp_path: Path) -> None:
    for name, other in (("one", "two"), ("two", "one")):
        (tmp_path / f"{name}.vhd").write_text(f"use work.{other}.all;", encoding="utf-8")
    with pytest.raises(ToolError, match="in a circle"):
        in_order_of_use(sorted(tmp_path.glob("*.vhd")))
