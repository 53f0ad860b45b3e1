"""Runs a module of cocotb tests on a VHDL top level in GHDL.

A pytest function calls :func:`simulate`; a failing cocotb test of the module fails that pytest
function. A VHDL assertion of severity ``error`` or worse also fails the pytest function.

GHDL 2.0 checks only after a timer whether cocotb has finished. If the VHDL makes its own clock, the
last await of a cocotb test must therefore be a ``Timer``; otherwise GHDL runs for ever.
"""

from __future__ import annotations

import fcntl
import functools
import hashlib
import json
import os
import re
import shutil
import subprocess
import uuid
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Literal
from xml.etree import ElementTree

from cocotb_tools.runner import Ghdl, get_runner

from tb.support.flat_ports import wrapper

ROOT = Path(__file__).resolve().parents[2]
GENERATED_VHDL = ROOT / "build" / "generated" / "vhdl"
# GHDL may look for LLVM's library under a name that the system does not have; the set-up then makes
# a link with that name in this folder.
LLVM_NAMES = ROOT / "build" / "llvm_names"

COVERAGE = "ARCTRUE_COVERAGE"
"""Environment variable by which scripts/gateware_coverage.py passes the folder for the counts of
executed lines."""

Backend = Literal["mcode", "llvm"]
"""Code generator of GHDL: with llvm a design runs three times as fast as with mcode, and compiled
units are kept."""

STANDARD = ("--std=08",)
LIBRARY = "top"
UNITS = f"{LIBRARY}-obj08.cf"
"""File with GHDL's list of the library's units, named after library and VHDL standard."""
FLAT_FOLDER = "flat"
"""Folder in build/tb for the wrappers with flat ports."""


@functools.cache
def _files_by_entity() -> dict[str, Path]:
    folders = (GENERATED_VHDL, ROOT / "rtl", ROOT / "tb")
    return {path.stem: path for folder in folders for path in folder.rglob("*.vhd")}


@functools.cache
def vhdl_sources(toplevel: str) -> tuple[Path, ...]:
    """Return the VHDL files that ``toplevel`` needs. Each file contains one entity or package and
    is named after it."""
    files = _files_by_entity()
    needed: set[str] = set()
    waiting = [toplevel]
    while waiting:
        name = waiting.pop()
        if name in needed:
            continue
        if name not in files:
            raise FileNotFoundError(f"{name}: no file {name}.vhd in rtl/, tb/ or {GENERATED_VHDL}")
        needed.add(name)
        used = re.findall(r"\bwork\.(\w+)", files[name].read_text(encoding="utf-8"))
        waiting += [unit.lower() for unit in used]
    return tuple(files[name] for name in sorted(needed))


@functools.cache
def _flat(toplevel: str) -> str | None:
    """Return the VHDL of the wrapper of ``toplevel``, or None if cocotb can access all ports of
    ``toplevel``."""
    texts = {path.stem: path.read_text(encoding="utf-8") for path in vhdl_sources(toplevel)}
    return wrapper(toplevel, texts[toplevel], texts.values())


def _suffix() -> str:
    """Return a suffix for the names of folders, so that runs with coverage have folders of their
    own."""
    return "-coverage" if COVERAGE in os.environ else ""


def _work_folder(toplevel: str, backend: Backend) -> Path:
    # Each pytest worker runs its simulations in its own folder.
    worker = os.environ.get("PYTEST_XDIST_WORKER", "main")
    return ROOT / "build" / "tb" / f"{toplevel}-{backend}-{worker}{_suffix()}"


def _library_folder(backend: Backend) -> Path:
    """Return the folder for the compiled VHDL of all benches, which all pytest workers share."""
    return ROOT / "build" / "tb" / f"library-{backend}{_suffix()}"


def _counting() -> list[str]:
    """Return options with which GHDL counts executed lines, or an empty list if the environment
    variable is not set."""
    folder = os.environ.get(COVERAGE)
    if folder is None:
        return []
    return ["--coverage", f"--coverage-output={Path(folder) / uuid.uuid4().hex}.json"]


def _top(toplevel: str) -> str:
    return f"{toplevel}_flat" if _flat(toplevel) else toplevel


def _ghdl(folder: Path, *words: str) -> None:
    """Run GHDL in ``folder``; raise AssertionError with GHDL's messages if it fails."""
    command = ["ghdl", *words[:1], f"--work={LIBRARY}", *STANDARD, *words[1:]]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{' '.join(command)}:\n{done.stdout}{done.stderr}"


@contextmanager
def _locked(folder: Path) -> Iterator[None]:
    """Lock ``folder``, so that no other process builds there."""
    folder.mkdir(parents=True, exist_ok=True)
    with folder.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        yield


def _known_sources(library: Path) -> dict[str, str]:
    """Return the digest of each file that the library contains, by the file's path."""
    noted = library / "sources.json"
    return json.loads(noted.read_text(encoding="utf-8")) if noted.exists() else {}


def _bring_in(library: Path, sources: Iterable[Path], version: str) -> None:
    """Add the source files to GHDL's library.

    A library that contains an older version of a file, or units of another GHDL, is cleared first.
    """
    known = _known_sources(library)
    wanted = {
        str(path): hashlib.sha256(path.read_bytes() + version.encode()).hexdigest()
        for path in sources
    }
    if any(known.get(path, digest) != digest for path, digest in wanted.items()):
        for path in library.glob("*"):
            path.unlink()
        known = {}
    new = [path for path in wanted if path not in known]
    if new:
        _ghdl(library, "-i", *new)
        text = json.dumps(known | wanted, indent=1)
        (library / "sources.json").write_text(text, encoding="utf-8")


@functools.cache
def _version(backend: Backend) -> str:
    del backend  # ghdl reads the code generator from the environment
    return subprocess.run(["ghdl", "--version"], capture_output=True, text=True, check=True).stdout


@functools.cache
def _built(toplevel: str, backend: Backend) -> Ghdl:
    """Compile ``toplevel`` into the work folder; return a runner for it."""
    runner = get_runner("ghdl")
    assert isinstance(runner, Ghdl)
    os.environ["GHDL_BACKEND"] = backend
    if LLVM_NAMES.is_dir():
        before = os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
        paths = dict.fromkeys([str(LLVM_NAMES), *before])
        os.environ["LD_LIBRARY_PATH"] = os.pathsep.join(filter(None, paths))
    folder, library = _work_folder(toplevel, backend), _library_folder(backend)
    folder.mkdir(parents=True, exist_ok=True)
    sources, flat = list(vhdl_sources(toplevel)), _flat(toplevel)
    with _locked(library):
        if flat:
            sources.append(library.with_name(FLAT_FOLDER) / f"{toplevel}_flat.vhd")
            sources[-1].parent.mkdir(exist_ok=True)
            sources[-1].write_text(flat, encoding="utf-8")
        _bring_in(library, sources, _version(backend))
        _ghdl(library, "-m", _top(toplevel))
        # The simulation uses copies of the list of units and of the program, because another
        # worker's build may replace both.
        for name in (UNITS, _top(toplevel)):
            if (library / name).exists():
                shutil.copy2(library / name, folder / name)
    return runner


def _is_of(name: str, asked: str) -> bool:
    """Tell whether a test that ran is the one asked for, or one of its parameters."""
    return name == asked or name.startswith(f"{asked}/")


def simulate(
    toplevel: str,
    test_module: str,
    *,
    generics: Mapping[str, int | str] | None = None,
    testcase: str | Sequence[str] | None = None,
    environment: Mapping[str, str] | None = None,
    backend: Backend = "llvm",
    waves: bool = False,
) -> Path:
    """Build ``toplevel`` and run the cocotb tests of ``test_module`` (a dotted name) on it.

    If ``toplevel`` has record ports, the tests run on the wrapper that ``flat_ports`` makes.
    ``generics`` are integers, enumerations or strings. ``testcase`` names one or more cocotb tests
    of the module; if it is None, all tests run. The cocotb process gets ``environment`` as
    environment variables. Returns the folder in which the simulation ran. Raises AssertionError
    with the names of the cocotb tests that failed, or with the names in ``testcase`` of which none
    ran.
    """
    os.environ["GHDL_BACKEND"] = backend
    # Remove the previous run's results, because a run that crashes would leave them in place.
    folder = _work_folder(toplevel, backend)
    runner = _built(toplevel, backend)
    results = runner.test(
        hdl_toplevel=_top(toplevel),
        hdl_toplevel_lang="vhdl",
        hdl_toplevel_library=LIBRARY,
        test_module=test_module,
        testcase=testcase,
        parameters=dict(generics or {}),
        test_args=[*STANDARD, *_counting()],
        plusargs=["--assert-level=error", "--max-stack-alloc=0"],
        build_dir=folder,
        test_dir=folder,
        extra_env={
            "PYTHONPATH": os.pathsep.join([str(ROOT), str(ROOT / "sim")]),
            "GHDL_BACKEND": backend,
            **(environment or {}),
        },
        waves=waves,
        results_xml=str(folder / f"{test_module}.results.xml"),
    )
    cases = ElementTree.parse(results).getroot().iter("testcase")
    outcomes = {
        str(case.get("name")): case.find("failure") is None and case.find("error") is None
        for case in cases
    }
    failed = [name for name, passed in outcomes.items() if not passed]
    assert outcomes, f"{test_module}: no cocotb test ran; see {folder}"
    asked = [testcase] if isinstance(testcase, str) else testcase or ()
    absent = [one for one in asked if not any(_is_of(name, one) for name in outcomes)]
    assert not absent, f"{test_module}: no cocotb test has the name {', '.join(absent)}"
    assert not failed, f"{test_module}: failed in the simulation: {', '.join(failed)}"
    return folder
