"""Every proof holds, and fails on each of its broken variants."""

from __future__ import annotations

from pathlib import Path

import pytest
from scripts.formal import PROOFS, Break, Proof, broken_sources, check
from sim.tests.synth.test_netlist import needs_tools


@needs_tools
@pytest.mark.parametrize("proof", PROOFS, ids=[proof.entity for proof in PROOFS])
def test_proof(proof: Proof, tmp_path: Path) -> None:
    assert check(proof, tmp_path) == []


@needs_tools
def test_a_fault_that_changes_nothing_is_reported(tmp_path: Path) -> None:
    harmless = Break("nothing", "      b <= phase_then(1);\n", "      b <= phase_then(1); --\n")
    (fault,) = check(Proof("quadrature_output", (harmless,)), tmp_path)
    assert fault == "quadrature_output: the proof does not notice that nothing"


def test_a_fault_that_does_not_fit_the_source_is_refused(tmp_path: Path) -> None:
    fault = Break("gone", "no such text", "")
    with pytest.raises(ValueError, match="there 0 times, not once"):
        broken_sources(Proof("quadrature_output", (fault,)), fault, tmp_path / "vhdl")
