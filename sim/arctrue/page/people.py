"""Errors that are told in a sentence beside what caused them."""

from __future__ import annotations

from pathlib import Path

from arctrue.measurement import MeasurementError
from arctrue.workbench.effects.guarded import EffectFileError
from arctrue.workbench.effects.registry import EffectNotFoundError

PEOPLE_ERRORS = (MeasurementError, EffectFileError, EffectNotFoundError, ValueError, OSError)


def sentence(error: Exception, folder: Path | None = None) -> str:
    """What is wrong, without the path of the server's own ``folder``."""
    if isinstance(error, OSError) and error.filename is not None and error.strerror:
        said = f"{error.filename}: cannot be read or written: {error.strerror}"
    else:
        said = str(error) or type(error).__name__
    return said if folder is None else said.replace(f"{folder}/", "").replace(str(folder), "")
