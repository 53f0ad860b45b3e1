"""Imports packages that only an extra of the installation provides, and names the install
command."""

from __future__ import annotations

import importlib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from importlib.util import find_spec
from types import ModuleType
from typing import Any

EXTRA_OF: Mapping[str, str] = {
    "flask": "page",
    "matplotlib": "page",
    "plotly": "page",
    "waitress": "page",
    "h5py": "files",
    "pyarrow": "files",
    "serial": "device",
    "softioc": "epics",
    "bluesky": "bluesky",
    "ophyd_async": "bluesky",
    "sklearn": "studies",
    "distributed": "cluster",
    "xmlschema": "certificate",
}
"""The extra of pyproject.toml that installs each package, by the package's import name."""


class MissingExtraError(ImportError, ValueError):
    """Raised if a package of an extra is needed and not installed; the message contains the install
    command."""


def missing_extra(error: ModuleNotFoundError) -> MissingExtraError | None:
    """Return the error that names the extra of a missing module; None if no extra installs this
    module."""
    package = (error.name or "").partition(".")[0]
    extra = EXTRA_OF.get(package)
    if extra is None:
        return None
    return MissingExtraError(
        f"this needs {package}, which is not installed: pip install 'arctrue[{extra}]'",
        name=error.name,
    )


@contextmanager
def needs_extras() -> Iterator[None]:
    """Convert the error of a missing package of an extra to a sentence with the install command.

    Raises MissingExtraError.
    """
    try:
        yield
    except ModuleNotFoundError as error:
        if isinstance(error, MissingExtraError) or (said := missing_extra(error)) is None:
            raise
        raise said from error


def optional(package: str) -> ModuleType:
    """Return the module ``package`` of an extra. Raises MissingExtraError if it is missing."""
    with needs_extras():
        return importlib.import_module(package)


def installed(package: str) -> bool:
    """Tell whether the package can be imported; nothing is imported."""
    return find_spec(package) is not None


class LazyModule:
    """Imports a module of an extra when one of its names is first used."""

    def __init__(self, name: str) -> None:
        """Store the ``name`` of the module, written as in an import statement."""
        self._name = name

    def __getattr__(self, name: str) -> Any:
        """Return a name of the module. Raises MissingExtraError if the package is not installed."""
        return getattr(optional(self._name), name)
