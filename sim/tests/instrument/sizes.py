"""Sizes of the one instrument that the tests build."""

from __future__ import annotations

from arctrue.studies.revolution import RevolutionSettings

LANES = 4
SAMPLES = 1200
DEPTH = RevolutionSettings(samples=SAMPLES).capture_depth
