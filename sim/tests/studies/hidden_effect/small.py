"""Defines settings of a small scale, 2¹⁸ counts, for an instrument that other tests also build."""

from __future__ import annotations

import dataclasses
from pathlib import Path
from unittest.mock import patch

from sim.tests.instrument.sizes import EXTENSIONS, LANES, SAMPLES

from arctrue.gateware.capability import Capability
from arctrue.studies.hidden_effect import experiment
from arctrue.studies.hidden_effect.cases import CASES, Case
from arctrue.studies.hidden_effect.experiment import run_hidden
from arctrue.studies.hidden_effect.result import HiddenResult
from arctrue.studies.hidden_effect.settings import HiddenSettings

GENERICS_OF = experiment._generics_of
LINES = 1024
INTERPOLATION = 256


def small_settings() -> HiddenSettings:
    """Return settings of 1,024 lines × 256 and four lanes; a count is 4.9″."""
    settings = HiddenSettings.of_lines(LINES, LANES, SAMPLES)
    scale = dataclasses.replace(settings.revolution, interpolation=INTERPOLATION, orders=12)
    return dataclasses.replace(settings, revolution=scale)


def _generics_of_the_tests(case: Case) -> dict[str, str]:
    """Return the generics of the shared core with every extension if the case needs an extension;
    otherwise return no generics."""
    return EXTENSIONS if GENERICS_OF(case) else {}


def run_small(name: str, folder: Path) -> HiddenResult:
    """Run the case of this name; check that the case states every generic that its coefficients
    need."""
    with patch.object(experiment, "_generics_of", _generics_of_the_tests):
        result = run_hidden(CASES[name], small_settings(), folder)
    extension = result.export.coefficients.extension
    own = Capability(**{generic.lower(): True for generic in GENERICS_OF(CASES[name])})
    assert own.lacking(Capability() if extension is None else extension.needs) == []
    return result
