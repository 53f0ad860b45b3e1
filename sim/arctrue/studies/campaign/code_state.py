"""Identifies the state of the code that makes a result: source files and libraries."""

from __future__ import annotations

import ast
import hashlib
import subprocess
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path

PACKAGE = Path(__file__).resolve().parents[2]
LIBRARIES = ("numpy", "scipy", "pyarrow")
GIT_S = 10.0


@dataclass(frozen=True, slots=True)
class Sources:
    """Modules and libraries on which a result depends."""

    modules: tuple[str, ...] = ()
    """Modules that count, together with all their imports; empty: the whole package."""
    libraries: tuple[str, ...] = ()
    """Numerical libraries that count, in addition to LIBRARIES."""

    def state(self, package: Path = PACKAGE) -> dict[str, str]:
        """Return 16 hex digits of the Python files' SHA-256, and the versions of the libraries.

        Parameters
        ----------
        package : Path, optional
            Folder of the package.

        Returns
        -------
        dict of str to str
            The digest under ``arctrue``, and the version of each library.
        """
        whole = hashlib.sha256()
        files = (
            import_closure(self.modules, package) if self.modules else sorted(package.rglob("*.py"))
        )
        for file in files:
            whole.update(str(file.relative_to(package)).encode() + b"\0")
            whole.update(hashlib.sha256(file.read_bytes()).digest())
        return {
            "arctrue": whole.hexdigest()[:16],
            **{name: metadata.version(name) for name in (*LIBRARIES, *self.libraries)},
        }


WHOLE_PACKAGE = Sources()


def import_closure(modules: Iterable[str], package: Path = PACKAGE) -> list[Path]:
    """List the files of these modules and of all modules that they import directly or indirectly.

    Only files of the package count. The search reads all import statements of a file; if a file
    reads the ``__path__`` of a package, every module of that package counts. The search does not
    find modules that are imported by a string. Raises ModuleNotFoundError for a module that does
    not exist.
    """
    waiting, found = list(modules), set[Path]()
    for name in waiting:
        if _file(name, package) is None:
            raise ModuleNotFoundError(name)
    while waiting:
        name = waiting.pop()
        file = _file(name, package)
        if file is None or file in found:
            continue
        found.add(file)
        # Python first runs the __init__ of every parent package, so these files count too.
        waiting.append(name.rpartition(".")[0])
        waiting += _imports(file, package)
    return sorted(found)


def _file(module: str, package: Path) -> Path | None:
    place = package.parent.joinpath(*module.split("."))
    if module.split(".")[0] != package.name:
        return None
    return next(
        (file for file in (place.with_suffix(".py"), place / "__init__.py") if file.is_file()), None
    )


def _imports(file: Path, package: Path) -> list[str]:
    found, listed = [], set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found += [item.name for item in node.names]
        elif isinstance(node, ast.ImportFrom) and node.module and not node.level:
            # A name that is imported from a package may be one of its modules.
            found += [node.module, *(f"{node.module}.{item.name}" for item in node.names)]
        elif isinstance(node, ast.Attribute) and node.attr == "__path__":
            listed.add(ast.unparse(node.value))
    for name in [name for name in found if name.rpartition(".")[2] in listed]:
        place = _file(name, package)
        if place is not None:
            found += [f"{name}.{module.stem}" for module in place.parent.glob("*.py")]
    return [name for name in found if name.split(".")[0] == package.name]


def commit(package: Path = PACKAGE) -> str | None:
    """Return the commit of the source tree, with ``-dirty`` if files differ from the commit; None
    without git or outside a repository."""
    command = ["git", "-C", str(package), "describe", "--always", "--dirty", "--abbrev=10"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=GIT_S, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout.strip() or None if done.returncode == 0 else None
