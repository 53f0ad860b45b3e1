"""Converts errors to sentences; the page shows each sentence next to the input that caused the
error."""

from __future__ import annotations

import sys
import traceback
from pathlib import Path

from arctrue.base.read_errors import sentence
from arctrue.calibration import CaptureRefusedError
from arctrue.device.console import ConsoleError
from arctrue.measurement import MeasurementError
from arctrue.workbench.effects.guarded import EffectFileError
from arctrue.workbench.effects.registry import EffectNotFoundError

PEOPLE_ERRORS = (MeasurementError, EffectFileError, EffectNotFoundError, ValueError, OSError)


def shown(error: Exception, *folders: Path) -> str:
    """Return the text of the error; the paths of the server's own ``folders`` are removed."""
    said = sentence(error)
    for folder in folders:
        said = said.replace(f"{folder}/", "").replace(str(folder), folder.name)
    return said


def failure(error: Exception, *folders: Path) -> str:
    """Return a sentence about an error of background work; print a program fault on the
    terminal."""
    if isinstance(error, (CaptureRefusedError, ConsoleError, *PEOPLE_ERRORS)):
        return shown(error, *folders)
    traceback.print_exception(error, file=sys.stderr)
    return f"The program has a fault; its terminal shows details: {error}."
