"""``make formal``: proves properties of the netlist, and that each proof fails on broken VHDL.

A proof is formal/<entity>_rules.sv round the netlist that GHDL makes of the entity's VHDL. Yosys'
own SAT solver proves the assertions for all input sequences of any length by induction over time
(``sat -tempinduct``). A break is a change of the VHDL after which the proof must fail.
Exit code 1 when a proof fails or a break is not noticed, 2 when a tool is missing.
"""

from __future__ import annotations

import shutil
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from scripts.netlist import ROOT, SOURCE_FOLDERS, ToolError, find_yosys, write_netlist

WORK = ROOT / "build" / "formal"
INDUCTION_LIMIT = 6  # clocks
PROVED = "Induction step proven: SUCCESS!"
TIMEOUT_S = 300


@dataclass(frozen=True)
class Break:
    """A fault of the VHDL: ``old``, there exactly once, becomes ``new``."""

    name: str
    old: str
    new: str


@dataclass(frozen=True)
class Proof:
    """An entity with its rules, and the faults that its proof must notice."""

    entity: str
    breaks: tuple[Break, ...]


PROOFS = (
    Proof(
        "axi3_to_axi_lite",
        (
            Break(
                "an address is withdrawn before it is taken",
                "          if m_axil_awready = '1' then\n",
                "          if m_axil_awready = '1' or m_axil_wready = '1' then\n",
            ),
            Break(
                "write data change while they wait",
                "        when WRITE_ACCESS =>\n",
                "        when WRITE_ACCESS =>\n          m_axil_wdata <= s_axi_wdata;\n",
            ),
            Break(
                "a write answer lasts one clock only",
                "          if s_axi_bready = '1' then\n",
                "          if true then\n",
            ),
            Break(
                "a read beat changes while it waits",
                "        when READ_ANSWER =>\n",
                "        when READ_ANSWER =>\n          s_axi_rdata <= m_axil_rdata;\n",
            ),
            Break(
                "a read address is withdrawn before it is taken",
                "          if m_axil_arready = '1' then\n",
                "          if true then\n",
            ),
            Break(
                "a reset leaves a write address out",
                "        m_axil_awvalid <= '0';\n        m_axil_wvalid  <= '0';\n      end if;",
                "        m_axil_wvalid  <= '0';\n      end if;",
            ),
        ),
    ),
    Proof(
        "quadrature_output",
        (
            Break(
                "B follows the wrong bit of the phase",
                "      b <= phase_then(1);\n",
                "      b <= phase_then(0);\n",
            ),
            Break(
                "the phase is not held while disabled",
                "      if following = '1' then\n        phase := ",
                "      if following = '0' then\n"
                "        phase := u_unsigned(corrected_position(1 downto 0));\n"
                "      else\n        phase := ",
            ),
        ),
    ),
)


def prove(
    entity: str, folder: Path, folders: tuple[Path, ...] = SOURCE_FOLDERS
) -> tuple[bool, str]:
    """Whether the rules of ``entity`` are proved, and the end of Yosys' log.

    Raises ToolError when the netlist cannot be made or Yosys stops without a verdict.
    """
    netlist = write_netlist(entity, folder, folders=folders)
    rules = f"{entity}_rules"
    shutil.copy(ROOT / "formal" / f"{rules}.sv", folder)
    yosys, _ = find_yosys()
    script = "; ".join(
        (
            f"read_verilog {netlist.name}",
            f"read_verilog -sv -formal {rules}.sv",
            f"prep -flatten -top {rules}",
            "memory_map",
            "chformal -assume -early",
            "chformal -assert -early",
            "opt -full",
            f"sat -tempinduct -prove-asserts -set-assumes -maxsteps {INDUCTION_LIMIT}",
        )
    )
    done = subprocess.run(
        [yosys, "-p", script],
        cwd=folder,
        capture_output=True,
        text=True,
        check=False,
        timeout=TIMEOUT_S,
    )
    (folder / "proof.log").write_text(done.stdout + done.stderr, encoding="utf-8")
    end = "\n".join((done.stdout + done.stderr).splitlines()[-8:])
    if done.returncode:
        raise ToolError(f"{entity}: Yosys gave no verdict, see {folder}/proof.log:\n{end}")
    return PROVED in done.stdout, end


def broken_sources(proof: Proof, fault: Break, folder: Path) -> tuple[Path, ...]:
    """Source folders with the fault in the entity; raises ValueError when it does not fit."""
    (source,) = (path for path in ROOT.glob(f"rtl/*/{proof.entity}.vhd"))
    text = source.read_text(encoding="utf-8")
    if text.count(fault.old) != 1:
        raise ValueError(
            f"{source}: '{fault.name}' looks for a text that is there {text.count(fault.old)} "
            f"times, not once; mend it in scripts/formal.py"
        )
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / source.name).write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    return (*SOURCE_FOLDERS, folder)  # the last folder wins


def check(proof: Proof, work: Path = WORK) -> list[str]:
    """Prove, then break and see each proof fail; returns what is not as it should be."""
    faults = []
    proved, end = prove(proof.entity, work / proof.entity)
    print(f"{proof.entity}: {'proved' if proved else 'NOT PROVED'}", flush=True)
    if not proved:
        faults.append(f"{proof.entity} is not proved, see {work / proof.entity}/proof.log:\n{end}")
    for number, fault in enumerate(proof.breaks):
        place = work / f"{proof.entity}-{number}"
        folders = broken_sources(proof, fault, place.with_suffix(".vhdl"))
        noticed = not prove(proof.entity, place, folders)[0]
        print(f"  {'noticed' if noticed else 'NOT NOTICED'}: {fault.name}", flush=True)
        if not noticed:
            faults.append(f"{proof.entity}: the proof does not notice that {fault.name}")
    return faults


def main() -> int:
    """Run all proofs; returns the exit code."""
    try:
        faults = [fault for proof in PROOFS for fault in check(proof)]
    except ToolError as error:
        print(f"formal: {error}", file=sys.stderr)
        return 2
    for fault in faults:
        print(f"formal: {fault}", file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
