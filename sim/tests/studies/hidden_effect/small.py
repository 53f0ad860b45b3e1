"""The scale of these tests: 2¹⁸ counts, and the instrument that the other tests build too."""

from __future__ import annotations

import dataclasses
from pathlib import Path

from sim.tests.instrument.sizes import LANES, SAMPLES

from arctrue.studies.hidden_effect.cases import CASES
from arctrue.studies.hidden_effect.experiment import HiddenResult, run_hidden
from arctrue.studies.hidden_effect.settings import HiddenSettings

LINES = 1024
INTERPOLATION = 256


def small_settings() -> HiddenSettings:
    """Return settings of 1,024 lines × 256 and four lanes; a count is 4.9″."""
    settings = HiddenSettings.of_lines(LINES, LANES, SAMPLES)
    scale = dataclasses.replace(settings.revolution, interpolation=INTERPOLATION, orders=12)
    return dataclasses.replace(settings, revolution=scale)


def run_small(name: str, folder: Path) -> HiddenResult:
    """Run the case of that name."""
    return run_hidden(CASES[name], small_settings(), folder)
