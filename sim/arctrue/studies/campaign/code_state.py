"""Which state of the code makes a result: every source file and the numerical libraries."""

from __future__ import annotations

import hashlib
from importlib import metadata
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
LIBRARIES = ("numpy", "scipy", "pyarrow")


def code_state(package: Path = PACKAGE) -> dict[str, str]:
    """SHA-256 over all Python files of the package, and the versions of what it calculates with."""
    whole = hashlib.sha256()
    for file in sorted(package.rglob("*.py")):
        whole.update(str(file.relative_to(package)).encode() + b"\0")
        whole.update(hashlib.sha256(file.read_bytes()).digest())
    return {
        "arctrue": whole.hexdigest()[:16],
        **{name: metadata.version(name) for name in LIBRARIES},
    }
