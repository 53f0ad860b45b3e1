"""Defines the sizes of the instruments that the tests build, and the generics of the instrument
with extensions."""

from __future__ import annotations

from arctrue.studies.revolution import RevolutionSettings

LANES = 4
SAMPLES = 1200
DEPTH = RevolutionSettings(samples=SAMPLES).capture_depth
EXTENSIONS = {"LOCAL_TABLE": "true", "MODULATORS": "true", "REAL_ORDERS": "true"}
"""Generics of the core that all tests of extensions share, because building a core takes nearly a
minute."""
