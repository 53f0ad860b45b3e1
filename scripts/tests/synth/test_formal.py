"""Tests that every quick proof succeeds and notices one fault; ``make formal`` tries all faults."""

from __future__ import annotations

import os
import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from scripts import formal
from scripts.formal import (
    DOCUMENT,
    broken_sources,
    check,
    document,
    find_sby,
    prove,
    sources_of_proof,
)
from scripts.formal_proofs import PROOFS, Break, Proof
from scripts.netlist import ROOT, ToolError, find_ghdl
from scripts.tests.synth.tools import tools_missing

MISSING = tools_missing(find_ghdl, find_sby)
needs_tools = pytest.mark.skipif(bool(MISSING), reason=MISSING)
QUICK = [proof for proof in PROOFS if proof.quick]
LONGEST = (
    "amplitude_sweep",
    "axi3_to_axi_lite",
    "coefficient_memory",
    "coefficient_memory_folded",
    "compensation_pipeline",
    "correction_ramp",
    "head_failover",
    "quadrature_decoder",
    "quadrature_output",
    "sampler",
    "stop_operator",
    "table_conditions",
    "turn_counter",
    "turn_difference",
)
OUTPUT = next(proof for proof in PROOFS if proof.name == "quadrature_output")
BRIDGE = next(proof for proof in PROOFS if proof.name == "axi3_to_axi_lite")


@needs_tools
@pytest.mark.parametrize(
    "proof",
    [
        pytest.param(proof, id=proof.name, marks=[pytest.mark.large] * (proof.name in LONGEST))
        for proof in QUICK
    ],
)
def test_proof(proof: Proof, tmp_path: Path) -> None:
    faults, _ = check(replace(proof, breaks=proof.breaks[:1]), tmp_path)
    assert faults == []


@pytest.mark.large
@needs_tools
def test_a_fault_that_changes_nothing_is_reported(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``test_proof`` proves the entity itself; here a few clocks without a counterexample are
    enough."""
    monkeypatch.setattr(formal, "prove", lambda proof, folder: [])
    line = "        when WRITE_ACCESS =>"
    harmless = Break("nothing", f"{line}\n", f"{line} --\n")
    (fault,), _ = check(replace(BRIDGE, breaks=(harmless,), cover_depth=4), tmp_path)
    assert fault == "axi3_to_axi_lite: the proof does not notice that nothing"


@pytest.mark.large
@needs_tools
def test_a_cover_statement_out_of_reach_is_reported(tmp_path: Path) -> None:
    (fault,) = prove(replace(OUTPUT, cover_depth=4), tmp_path)
    assert "a cover statement is out of reach" in fault


@needs_tools
@pytest.mark.parametrize(
    "proof",
    [
        replace(OUTPUT, cut=("glitch_filter*",)),
        replace(OUTPUT, cut_signals=("quadrature_output/w:gone",)),
    ],
    ids=["module", "signal"],
)
def test_what_is_cut_must_be_there(proof: Proof, tmp_path: Path) -> None:
    with pytest.raises(ToolError, match="Assertion failed: selection"):
        prove(proof, tmp_path)


def test_a_fault_that_does_not_fit_the_source_is_refused(tmp_path: Path) -> None:
    fault = Break("gone", "no such text", "")
    with pytest.raises(ValueError, match="occurs 0 times, not once"):
        broken_sources(OUTPUT, fault, tmp_path / "vhdl")


def test_all_faults_fit_their_sources(tmp_path: Path) -> None:
    for proof in PROOFS:
        for fault in proof.breaks:
            broken_sources(proof, fault, tmp_path / "vhdl")


def test_a_constant_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="has no constant LANES_MOST"):
        sources_of_proof(replace(OUTPUT, constants={"LANES_MOST": 2}), tmp_path / "small")


def test_every_rules_file_belongs_to_a_proof_with_covers_and_faults() -> None:
    rules = {path.name for path in (ROOT / "formal").glob("*.sv")}
    assert rules == {f"{proof.rules}.sv" for proof in PROOFS}
    for proof in PROOFS:
        text = (ROOT / "formal" / f"{proof.rules}.sv").read_text(encoding="utf-8")
        assert "cover (" in text, proof.name
        assert proof.breaks, proof.name


def test_the_document_is_that_of_the_proofs() -> None:
    assert DOCUMENT.read_text(encoding="utf-8") == document(PROOFS)


def test_without_symbiyosys_the_command_says_what_to_do(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(shutil, "which", lambda command, path=os.defpath: None)
    assert formal.main(["quadrature_output"]) == 2
    assert "yowasp-sby is missing; make setup" in capsys.readouterr().err
