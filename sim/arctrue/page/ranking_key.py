"""Computes a key for a ranking, a digest of all its inputs; rankings with equal keys are equal."""

from __future__ import annotations

import functools
import hashlib
import inspect
import json
from collections.abc import Mapping
from pathlib import Path

import arctrue
from arctrue.measurement.digest import file_digest, set_digest
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.model.model import Model

_MASK = "mask.csv"
"""Name of the file of masked rows, which the digest of the set does not include."""


def ranking_key(folder: Path, title: str, model: Model, effects: Mapping[str, type[Effect]]) -> str:
    """Return the SHA-256 of set, mask, model, effects, program and title (the device's file
    contains the title).

    The key does not include fitted values, because a fit starts from the settings and search
    parameters alone. Raises OSError, MeasurementError.
    """
    mask = folder / _MASK
    said = {
        "set": set_digest(folder),
        "mask": file_digest(mask) if mask.is_file() else "",
        "title": title,
        "model": [[entry.name, entry.settings, entry.search] for entry in model.effects],
        "reference_temperature_c": model.reference_temperature_c,
        "effects": {name: _of_effect(kind) for name, kind in effects.items()},
        "program": _program(),
    }
    return hashlib.sha256(json.dumps(said, sort_keys=True, default=repr).encode()).hexdigest()


@functools.cache
def _of_effect(kind: type[Effect]) -> list[str]:
    """Return the digests of the files that define the effect; they are computed once."""
    methods = [item for part in kind.__mro__ for item in vars(part).values()]
    files = {
        inspect.unwrap(item).__code__.co_filename for item in filter(inspect.isfunction, methods)
    }
    return [file_digest(Path(name)) for name in sorted(files) if Path(name).is_file()]


@functools.cache
def _program() -> str:
    """Return a digest of the package's files; the version number does not suffice, because the
    files change during development."""
    files = sorted(Path(arctrue.__file__).parent.rglob("*.py"))
    return hashlib.sha256("".join(file_digest(path) for path in files).encode()).hexdigest()
