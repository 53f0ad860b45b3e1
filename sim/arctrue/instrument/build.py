"""Builds the instrument's shared library from GHDL's netlist, Verilator's C++, the harness and the
firmware.

Results are stored in build/instrument under a digest of all inputs: sources,
generics, tools and flags. ``python -m arctrue.instrument`` builds the 32-lane core.
"""

from __future__ import annotations

import fcntl
import hashlib
import re
import shutil
import subprocess
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from functools import cache
from pathlib import Path

from arctrue.base.netlist import ToolError, find_ghdl, sources_of, write_netlist
from arctrue.base.progress import ReportStep
from arctrue.base.source_tree import ROOT, lack_of_source_tree
from arctrue.generated.number_formats import CAPTURE_DEPTH_DEFAULT, LANES_DEFAULT
from arctrue.generated.registers import CAPTURE_ADDRESS, FURTHER_CAPTURE_ADDRESS
from arctrue.instrument.errors import InstrumentError

NATIVE = Path(__file__).resolve().parent / "native"
BUILT = ROOT / "build" / "instrument"
FIRMWARE = ROOT / "firmware"
FIRMWARE_FOLDERS = ("calibration", "application", "console")
GENERATED_C = ROOT / "build" / "generated" / "c"
OF_THE_MODEL = ("abi.cpp", "bus.cpp", "harness.cpp")
"""Source files of the harness that include the C++ model of the core."""
OLDEST_VERILATOR = 5

# Verilator sets registers to the initial values of the VHDL, which the netlist contains; a register
# without one starts at 0.
VERILATOR_FLAGS = (
    *("--cc", "-O3", "--x-assign", "fast", "--x-initial", "fast", "--no-assert"),
    *("-Wno-fatal", "-Wno-lint", "-Wno-style", "-Wno-SYMRSVDWORD"),
)
CXX_FLAGS = ("-std=gnu++17", "-O3", "-fPIC", "-fvisibility=hidden", "-fno-gnu-unique")
# The warnings apply to this project's sources only, not to the C++ code that Verilator generates.
CXX_WARNINGS = ("-Wall", "-Wextra", "-Wconversion", "-Wshadow", "-Werror")
# Code that runs only once, at the start, is compiled without optimisation.
SLOW_CXX_FLAGS = ("-O0",)
CXX_DEFINES = ("-DVM_COVERAGE=0", "-DVM_SC=0", "-DVM_TRACE=0")
C_FLAGS = ("-std=c11", "-O2", "-fPIC", "-fvisibility=hidden", "-Wall", "-Wextra", "-Werror")
LINK_FLAGS = ("-shared", "-Wl,-Bsymbolic", "-lm", "-lpthread", "-latomic")


def _version(command: str) -> str:
    try:
        done = subprocess.run([command, "--version"], capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.splitlines()[0] if done.stdout else ""


@cache
def tool_versions() -> dict[str, str]:
    """Return the versions of GHDL, Verilator, g++ and gcc by the tools' names.

    Raises InstrumentError naming all missing tools.
    """
    if lack := lack_of_source_tree():
        raise InstrumentError(lack)
    missing, versions = [], {}
    try:
        versions["ghdl"] = find_ghdl()[1]
    except ToolError as error:
        missing.append(str(error))
    found = re.match(r"Verilator (\d+)\.", _version("verilator"))
    if found and int(found[1]) >= OLDEST_VERILATOR:
        versions["verilator"] = _version("verilator")
    else:
        missing.append(
            f"Verilator {OLDEST_VERILATOR}.0 or newer is missing: apt-get install verilator"
        )
    for compiler in ("g++", "gcc"):
        versions[compiler] = _version(compiler)
        if not versions[compiler]:
            missing.append(f"{compiler} is missing: apt-get install {compiler}")
    if missing:
        raise InstrumentError(
            "The instrument cannot be built ('make setup' installs what it needs).\n  "
            + "\n  ".join(missing)
        )
    return versions


@cache
def verilator_include() -> Path:
    """Return the folder of the C++ runtime sources that Verilator provides. Raises InstrumentError
    if the folder does not contain them."""
    done = subprocess.run(
        ["verilator", "--getenv", "VERILATOR_ROOT"], capture_output=True, text=True, check=False
    )
    folder = Path(done.stdout.strip()) / "include"
    if not (folder / "verilated.cpp").exists():
        raise InstrumentError(f"Verilator's runtime is not in {folder}: install verilator anew")
    return folder


def digest(texts: Iterable[str], files: Iterable[Path]) -> str:
    """Return a digest of ``texts`` and of the names and contents of ``files``, as sixteen
    hexadecimal digits."""
    made = hashlib.sha256()
    for text in texts:
        made.update(f"{text}\0".encode())
    for path in files:
        made.update(f"{path.name}\0".encode())
        made.update(path.read_bytes())
    return made.hexdigest()[:16]


def run_tool(command: Sequence[str], log: Path, what: str) -> None:
    """Run a tool. Raises InstrumentError with the last lines of ``log`` if the tool fails."""
    with log.open("a", encoding="utf-8") as text:
        text.write(f"$ {' '.join(command)}\n")
        text.flush()
        done = subprocess.run(command, stdout=text, stderr=text, check=False)
    if done.returncode:
        tail = "\n".join(log.read_text(encoding="utf-8", errors="replace").splitlines()[-15:])
        raise InstrumentError(f"{what} failed ({command[0]}). The end of {log}:\n{tail}")


@contextmanager
def building(target: Path, log: Path) -> Iterator[Path | None]:
    """Yield a temporary folder that is renamed to ``target`` if the block succeeds; yield None if
    ``target`` exists.

    A second process that builds the same target waits for the first process.
    """
    if target.exists():
        yield None
        return
    target.parent.mkdir(parents=True, exist_ok=True)
    with target.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if target.exists():
            yield None
            return
        log.unlink(missing_ok=True)
        folder = Path(tempfile.mkdtemp(prefix=f"{target.name}.", dir=target.parent))
        try:
            yield folder
            folder.replace(target)
        finally:
            shutil.rmtree(folder, ignore_errors=True)


def compile_all(
    sources: Sequence[Path], folder: Path, options: Sequence[str], log: Path, jobs: int = 2
) -> list[Path]:
    """Compile C++ and C sources to object files, which are stored in ``folder``."""

    def one(source: Path) -> Path:
        made = folder / f"{source.name}.o"
        if source.suffix == ".c":
            command = ["gcc", *C_FLAGS]
        else:
            slow = SLOW_CXX_FLAGS if source.stem.endswith(("__Slow", "__Syms")) else ()
            warnings = CXX_WARNINGS if source.parent == NATIVE else ("-w",)
            command = ["g++", *CXX_FLAGS, *CXX_DEFINES, *warnings, *slow]
        mine = log.with_name(f"{log.stem}.{source.stem}.log")
        mine.unlink(missing_ok=True)
        run_tool([*command, *options, "-c", str(source), "-o", str(made)], mine, source.name)
        mine.unlink()
        return made

    with ThreadPoolExecutor(jobs) as pool:
        return list(pool.map(one, sources))


def runtime() -> list[Path]:
    """Return the object files of Verilator's runtime; they are stored in build/instrument."""
    key = digest([tool_versions()["verilator"], tool_versions()["g++"], *CXX_FLAGS], [])
    target = BUILT / f"runtime-{key}"
    log = BUILT / f"runtime-{key}.log"
    with building(target, log) as folder:
        if folder is not None:
            include = verilator_include()
            names = ("verilated.cpp", "verilated_threads.cpp")
            compile_all([include / name for name in names], folder, [f"-I{include}"], log)
    return sorted(target.glob("*.o"))


def verilate(netlist: Path, folder: Path, log: Path) -> None:
    """Convert a netlist to C++ in ``folder``; the C++ class is called V<entity>."""
    top = netlist.stem
    command = ["verilator", *VERILATOR_FLAGS, "--top-module", top, "--prefix", f"V{top}"]
    run_tool([*command, "--Mdir", str(folder), str(netlist)], log, f"Verilating {top}")


def _model(
    lanes: int, capture_depth: int, generics: Mapping[str, int | str], report_step: ReportStep
) -> Path:
    """Return the folder of the compiled core: object files, headers and the netlist from which they
    were made."""
    versions = tool_versions()
    values = {"LANES": lanes, "CAPTURE_DEPTH": capture_depth, **generics}
    try:
        sources = sources_of("arctrue_core")
    except ToolError as error:
        raise InstrumentError(str(error)) from error
    texts = [*(f"{name}={value}" for name, value in sorted(values.items())), *versions.values()]
    key = digest([*texts, *VERILATOR_FLAGS, *CXX_FLAGS, *SLOW_CXX_FLAGS], sources)
    target = BUILT / f"core-{lanes}-{capture_depth}-{key}"
    log = target.with_suffix(".log")
    with building(target, log) as folder:
        if folder is None:
            return target
        report_step(f"Instrument: netlist of the core with {lanes} lanes ({versions['ghdl']})")
        try:
            netlist = write_netlist("arctrue_core", folder / "netlist", generics=values)
        except ToolError as error:
            raise InstrumentError(str(error)) from error
        verilate(netlist, folder / "verilated", log)
        generated = sorted((folder / "verilated").glob("*.cpp"))
        report_step(
            f"Instrument: compiling {len(generated)} files of C++ (about a minute for 32 lanes)"
        )
        include = verilator_include()
        options = [f"-I{folder / 'verilated'}", f"-I{include}", f"-I{include / 'vltstd'}"]
        compile_all(generated, folder, options, log)
        for path in generated:
            path.unlink()
    return target


def _interrupt_port(model: Path) -> str:
    header = (model / "verilated" / "Varctrue_core.h").read_text(encoding="utf-8")
    found = re.search(r"&(\w*interrupt)\b", header)
    if found is None:
        raise InstrumentError(f"{model}: the core has no port 'interrupt'")
    return found[1]


def firmware_sources() -> list[Path]:
    """Return the C files of the firmware that need no hardware."""
    return sorted(path for folder in FIRMWARE_FOLDERS for path in (FIRMWARE / folder).glob("*.c"))


def _headers() -> list[Path]:
    return [
        *NATIVE.glob("*.h"),
        *(path for folder in FIRMWARE_FOLDERS for path in (FIRMWARE / folder).glob("*.h")),
        *GENERATED_C.glob("*.h"),
    ]


def _include_options() -> list[str]:
    folders = (*(FIRMWARE / name for name in FIRMWARE_FOLDERS), GENERATED_C, NATIVE)
    return [f"-I{folder}" for folder in folders]


def _of_every_core() -> list[Path]:
    """Return the object files of the firmware and of the harness sources without the model.

    All instruments share these files, which are compiled once, into build/instrument.
    """
    natives = (path for path in NATIVE.iterdir() if path.suffix in (".cpp", ".c"))
    sources = sorted(path for path in natives if path.name not in OF_THE_MODEL)
    sources += firmware_sources()
    flags = [*CXX_FLAGS, *CXX_WARNINGS, *C_FLAGS]
    key = digest([tool_versions()["gcc"], *flags], [*sources, *sorted(_headers())])
    target = BUILT / f"firmware-{key}"
    log = target.with_suffix(".log")
    with building(target, log) as folder:
        if folder is not None:
            compile_all(sources, folder, _include_options(), log)
    return sorted(target.glob("*.o"))


def build(
    lanes: int = LANES_DEFAULT,
    capture_depth: int = CAPTURE_DEPTH_DEFAULT,
    *,
    generics: Mapping[str, int | str] | None = None,
    report_step: ReportStep | None = None,
) -> Path:
    """Return the shared library of an instrument; build it if it does not exist.

    Parameters
    ----------
    lanes : int
        Lanes of the gateware.
    capture_depth : int
        Samples of a capture bank.
    generics : mapping, optional
        Further generics of arctrue_core by name.
    report_step : callable, optional
        Function that receives a line of text for the user at each step.

    Returns
    -------
    Path
        The library.

    Raises
    ------
    InstrumentError
        If a tool is missing or fails.
    """
    report_step = report_step or (lambda _: None)
    versions = tool_versions()
    model = _model(lanes, capture_depth, generics or {}, report_step)
    natives = sorted(path for path in NATIVE.iterdir() if path.suffix in (".cpp", ".c"))
    sources = [*natives, *firmware_sources()]
    flags = [*CXX_FLAGS, *CXX_WARNINGS, *C_FLAGS, *LINK_FLAGS]
    windows = (str(CAPTURE_ADDRESS), str(FURTHER_CAPTURE_ADDRESS))
    texts = [model.name, versions["gcc"], *flags, *windows]
    key = digest(texts, [*sources, *sorted(_headers())])
    target = BUILT / f"instrument-{lanes}-{capture_depth}-{key}"
    log = target.with_suffix(".log")
    with building(target, log) as folder:
        if folder is not None:
            report_step("Instrument: compiling harness and firmware")
            include = verilator_include()
            options = [
                *(f"-isystem{path}" for path in (model / "verilated", include)),
                f"-isystem{include / 'vltstd'}",
                *_include_options(),
                f"-DINTERRUPT_PORT={_interrupt_port(model)}",
                f"-DCAPTURE_ADDRESS={CAPTURE_ADDRESS}U",
                f"-DFURTHER_CAPTURE_ADDRESS={FURTHER_CAPTURE_ADDRESS}U",
                f"-DBUILT_HEADS={(generics or {}).get('HEADS', 2)}",
            ]
            objects = compile_all([NATIVE / name for name in OF_THE_MODEL], folder, options, log)
            objects += [*_of_every_core(), *sorted(model.glob("*.o")), *runtime()]
            library = folder / "instrument.so"
            command = ["g++", *map(str, objects), "-o", str(library), *LINK_FLAGS]
            run_tool(command, log, "Linking the instrument")
            for path in folder.glob("*.o"):
                path.unlink()
    return target / "instrument.so"
