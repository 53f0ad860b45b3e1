"""Builds a folder that contains the Python packages of a list of requirements, and no others."""

from __future__ import annotations

from collections.abc import Iterable
from importlib.metadata import Distribution, distribution
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name


def required(requirements: Iterable[str]) -> dict[str, Distribution]:
    """Return the installed distributions that the requirements need, directly or indirectly, keyed
    by name.

    Raises importlib.metadata.PackageNotFoundError if one is not installed here, and AssertionError
    if one has another version.
    """
    found: dict[str, Distribution] = {}
    waiting = [(Requirement(text), "") for text in requirements]
    while waiting:
        requirement, extra = waiting.pop()
        if requirement.marker and not requirement.marker.evaluate({"extra": extra}):
            continue
        name = canonicalize_name(requirement.name)
        installed = found.get(name) or distribution(name)
        assert requirement.specifier.contains(installed.version, prereleases=True), requirement
        if name not in found:
            further = [Requirement(text) for text in installed.requires or ()]
            waiting += [(other, "") for other in further]
            waiting += [(other, extra) for other in further for extra in requirement.extras]
        found[name] = installed
    return found


def link(distributions: Iterable[Distribution], folder: Path) -> None:
    """Link every module and package of the distributions into ``folder``."""
    folder.mkdir(parents=True, exist_ok=True)
    for installed in distributions:
        tops = {Path(file).parts[0] for file in installed.files or ()} - {"..", "__pycache__"}
        for top in tops:
            path = folder / top
            if not path.exists():
                path.symlink_to(Path(str(installed.locate_file(top))))
