"""Builds the firmware's C sources as a shared library for this machine, and calls it through cffi.

``ARCTRUE_SANITIZE=address`` adds AddressSanitizer, which the process must preload, see
test_sanitizers.py. UBSan is always included and ends the process at an error.
``ARCTRUE_COVERAGE=FOLDER`` builds the library in FOLDER with gcc's coverage counters; the line
counts are written there, see scripts/firmware_coverage.py.
"""

from __future__ import annotations

import functools
import hashlib
import os
import re
import subprocess
from pathlib import Path
from typing import Any

from cffi import FFI

ROOT = Path(__file__).resolve().parents[3]
FIRMWARE = ROOT / "firmware"
FOLDERS = ("calibration", "application", "console", "zynq")
GENERATED = ROOT / "build" / "generated" / "c"
BUILT = ROOT / "build" / "firmware" / "host"
COVERAGE = "ARCTRUE_COVERAGE"
FLAGS = (
    *("-std=c11", "-O1", "-g", "-fPIC", "-shared", "-Wall", "-Wextra", "-Wconversion", "-Werror"),
    *("-fsanitize=undefined", "-fno-sanitize-recover=all"),
)


def sources() -> list[Path]:
    """Return every C file that needs no hardware."""
    return sorted(path for folder in FOLDERS for path in (FIRMWARE / folder).glob("*.c"))


def flags() -> list[str]:
    """Return the compiler flags for the sanitizer and the coverage that the environment
    requests."""
    includes = [f"-I{FIRMWARE / folder}" for folder in FOLDERS] + [f"-I{GENERATED}"]
    asked = os.environ.get("ARCTRUE_SANITIZE")
    sanitize = [f"-fsanitize={asked}"] if asked else []
    coverage = ["--coverage", "-fprofile-update=atomic"] if os.environ.get(COVERAGE) else []
    return [*FLAGS, *includes, *sanitize, *coverage]


@functools.cache
def shared_library() -> Path:
    """Return the path of the library; compile it again if a source, a header or a flag has
    changed."""
    digest = hashlib.sha256(" ".join(flags()).encode())
    headers = [path for folder in FOLDERS for path in (FIRMWARE / folder).glob("*.h")]
    for path in sorted([*sources(), *headers, *GENERATED.glob("*.h")]):
        digest.update(path.read_bytes())
    folder = Path(os.environ.get(COVERAGE) or BUILT)
    library = folder / f"firmware-{digest.hexdigest()[:16]}.so"
    if not library.exists():
        folder.mkdir(parents=True, exist_ok=True)
        made = library.with_suffix(f".{os.getpid()}")
        command = ["gcc", *flags(), *map(str, sources()), "-o", str(made), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        assert done.returncode == 0, f"the firmware does not compile:\n{done.stderr}"
        made.replace(library)
    return library


def _headers_in_order() -> list[Path]:
    """Return the headers in an order in which each header follows the headers that it includes."""
    by_name = {path.name: path for folder in FOLDERS for path in (FIRMWARE / folder).glob("*.h")}
    order: list[Path] = []

    def add(path: Path) -> None:
        if path in order:
            return
        for name in re.findall(r'#include "([\w./]+)"', path.read_text("utf-8")):
            if name in by_name:
                add(by_name[name])
        order.append(path)

    for path in sorted(by_name.values()):
        add(path)
    return order


def _declarations(text: str) -> str:
    """Return the part of a header that cffi can read, without comments, preprocessor directives,
    inline functions and static assertions."""
    text = re.sub(r"/\*.*?\*/", "", text, flags=re.DOTALL)
    text = re.sub(r"^#(?:.*\\\n)*.*$", "", text, flags=re.MULTILINE)
    text = re.sub(r"_Static_assert\(.*?\);", "", text, flags=re.DOTALL)
    return re.sub(r"^static inline .*?^}\n", "", text, flags=re.DOTALL | re.MULTILINE)


@functools.cache
def firmware() -> tuple[FFI, Any]:
    """Return cffi's interface with the declarations of all headers, and the loaded library."""
    ffi = FFI()
    formats = (GENERATED / "arctrue_number_formats.h").read_text("utf-8")
    ffi.cdef("\n".join(re.findall(r"^#define \w+ \d+$", formats, re.MULTILINE)))
    ffi.cdef("\n".join(_declarations(path.read_text("utf-8")) for path in _headers_in_order()))
    return ffi, ffi.dlopen(str(shared_library()))
