"""Tests to which cells and pins Vivado's constraints apply, and that this does not depend on the
names of instances."""

from __future__ import annotations

import os
import re
import shutil
from collections.abc import Callable, Mapping
from pathlib import Path

import pytest

from arctrue.generated import number_formats
from scripts import bitstream
from scripts.bitstream_constraints import ports_of
from scripts.bitstream_job import TOPS
from scripts.netlist import ROOT, sources_of
from scripts.tests.device_build.fake_tools import VIVADO, FakeTools
from scripts.tests.device_build.vivado_netlist import (
    Cell,
    cells_of,
    relabelled,
    texts_of,
    write_netlist,
)

PRELUDE = Path(__file__).with_name("vivado_prelude.tcl")
DEVICES = ["arctrue_zynq_top", "arctrue_zynq_heads_top", "arctrue_zynq_differential_top"]
TOP_OPTIONS = {"arctrue_zynq_heads_top": ["--heads", "4"]}
HALF_A_CLOCK_NS = 0.5e9 / number_formats.CLOCK_HZ
# These ports are asynchronous inputs, and outputs whose timing matters to the connected device.
TIMED_INPUT = re.compile(r"head[1-4]_[abz](_[pn])?|sync_in|probe_in")
TIMED_OUTPUT = re.compile(r"out_[abz](_[pn])?|trigger_out|compare_out")


class Outcome:
    """Effect of the constraints on one netlist."""

    def __init__(self, cells: list[Cell], ports: list[str], noted: list[list[str]]) -> None:
        self.cells = cells
        self.ports = ports
        self.without_effect = [words[1:] for words in noted if words[0] == "nothing"]
        self.properties = {tuple(words[1:]) for words in noted if words[0] == "property"}
        self.constraints = [words[1:] for words in noted if words[0] == "constraint"]

    def instances(self, entity: str) -> list[str]:
        return [cell.name for cell in self.cells if cell.reference == entity]

    def bounds(self, option: str) -> dict[str, float]:
        """Return, for each object of ``option``, the largest permitted delay in ns."""
        found: dict[str, float] = {}
        for words in self.constraints:
            if words[0] == "set_max_delay" and option in words:
                assert "-datapath_only" in words
                objects = words[words.index(option) + 1].split(",")
                found |= dict.fromkeys(objects, float(words[-1]))
        return found


def run(
    folder: Path,
    monkeypatch: pytest.MonkeyPatch,
    top: str,
    change: Callable[[Mapping[str, str]], dict[str, str]] = dict,
) -> Outcome:
    """Run ``make bitstream FLOW=vivado`` on the netlist of ``top`` after ``change`` of its
    sources."""
    tclsh = shutil.which("tclsh")
    assert tclsh, "tclsh is missing: apt-get install tcl"
    fakes = FakeTools(folder, monkeypatch)
    fakes.set_path(os.path.dirname(tclsh))  # noqa: PTH120
    fakes.add("vivado", VIVADO)
    cells = list(cells_of(change(texts_of(sources_of(top))), top))
    netlist = folder / "netlist"
    write_netlist(netlist, cells, ports_of(top))
    noted = folder / "commands"
    for name, value in (("PRELUDE", PRELUDE), ("COMMANDS", noted), ("NETLIST", netlist)):
        monkeypatch.setenv(f"FAKE_{'VIVADO_' if name == 'PRELUDE' else ''}{name}", str(value))
    pins = folder / "pins.xdc"
    lines = [
        f"set_property {given} [get_ports {port}]"
        for port, place in zip(ports_of(top), places(), strict=False)
        for given in (f"LOC {place}", "IOSTANDARD LVCMOS33")
    ]
    pins.write_text("\n".join(lines) + "\n", encoding="utf-8")
    words = ["--pins", str(pins), "--output", str(folder / "made")]
    words += TOP_OPTIONS.get(top, ["--top", top])
    assert bitstream.main([*words, "--board", "of_the_test", "--part", "xc7z020clg400-1"]) == 0
    read = [line.split() for line in noted.read_text(encoding="utf-8").splitlines()]
    return Outcome(cells, ports_of(top), read)


def places() -> list[str]:
    return [f"{row}{column}" for row in "ABCDEFGH" for column in range(1, 21)]


@pytest.mark.parametrize("top", DEVICES)
@pytest.mark.parametrize("change", [pytest.param(dict, marks=pytest.mark.large), relabelled])
def test_labels_of_instances_do_not_matter(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    top: str,
    change: Callable[[Mapping[str, str]], dict[str, str]],
) -> None:
    made = run(tmp_path, monkeypatch, top, change)
    assert made.without_effect == []
    pads = {f"{path}/{line}_reg" for path in made.instances("quadrature_output") for line in "abz"}
    pads |= {f"{path}/pulse_reg" for path in made.instances("pulse_output")}
    assert len(pads) == 3 + 2
    assert {words for words in made.properties if words[0] == "IOB"} == {
        ("IOB", "TRUE", register) for register in pads
    }
    from_pins, to_pins = made.bounds("-from"), made.bounds("-to")
    inputs = [port for port in made.ports if TIMED_INPUT.fullmatch(port)]
    outputs = [port for port in made.ports if TIMED_OUTPUT.fullmatch(port)]
    assert len(inputs) == (6 if top == "arctrue_zynq_top" else 12) + 2
    assert [from_pins.get(port) for port in inputs] == [HALF_A_CLOCK_NS] * len(inputs)
    assert [to_pins.get(port) for port in outputs] == [HALF_A_CLOCK_NS] * len(outputs)
    (processor,), (identifier,) = made.instances("zynq_processor"), made.instances("chip_dna")
    clocks = {
        words[words.index("-name") + 1]: words[-1]
        for words in made.constraints
        if words[0].startswith("create_")
    }
    assert clocks == {
        "fabric_clock": f"{processor}/ps7_primitive/FCLKCLK[0]",
        "dna_clock": f"{identifier}/port_clock_reg/Q",
    }
    assert f"{identifier}/dna_primitive" in from_pins
    assert f"{identifier}/dna_primitive" in to_pins


INSIDES = {
    "pulse_output": "pulse",
    "quadrature_output": "a",
    "chip_dna": "load",
    "zynq_processor": "ps7_primitive",
}


@pytest.mark.parametrize("entity", INSIDES)
def test_another_name_inside_an_entity_is_noticed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, entity: str
) -> None:
    """If a cell gets another name, the constraints miss it; this shows that the test above can
    fail."""

    def rename(texts: Mapping[str, str]) -> dict[str, str]:
        text = re.sub(rf"\b{INSIDES[entity]}\b", "renamed", texts[entity])
        return {**texts, entity: text}

    made = run(tmp_path, monkeypatch, "arctrue_zynq_top", rename)
    if entity == "quadrature_output":
        assert not any("renamed" in words[2] for words in made.properties)
        assert len([words for words in made.properties if words[0] == "IOB"]) == 4
    elif entity == "chip_dna":
        assert not any("renamed" in name for name in made.bounds("-from"))
    else:
        assert made.without_effect


def test_an_entity_that_is_not_there_stops_the_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def without(texts: Mapping[str, str]) -> dict[str, str]:
        text = re.sub(r"\w+\s*:\s*entity\s+work\.pulse_output\b", "", texts["instrument_signals"])
        return {**texts, "instrument_signals": text}

    with pytest.raises(AssertionError):
        run(tmp_path, monkeypatch, "arctrue_zynq_top", without)
    assert "expected an instance of pulse_output after synthesis" in capsys.readouterr().err


def test_scoped_files_speak_of_the_inside_only() -> None:
    """The file of an entity must not contain names of instances above the entity, or of ports of a
    top."""
    for entity in TOPS["arctrue_zynq_top"].scoped:
        path = ROOT / "constraints" / "vivado" / f"{entity}.xdc"
        text = re.sub(r"^#.*$", "", path.read_text(encoding="utf-8"), flags=re.MULTILINE)
        assert not re.search(r"-hier|NAME|get_ports|all_(in|out)puts|current_instance", text), path
        assert "read_xdc" in path.read_text(encoding="utf-8")
