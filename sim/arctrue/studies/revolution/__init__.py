"""Simulates two turns of a table of the paper's size on the virtual instrument: settings, run and
score."""

from arctrue.studies.revolution.experiment import (
    RevolutionResult,
    run_revolution,
    set_up,
    settled,
)
from arctrue.studies.revolution.settings import (
    DEPTH_STEP,
    ECCENTRICITY_DIRECTION_RAD,
    ECCENTRICITY_M,
    FOUR_PLACES_DEG,
    GRADUATION_ARCSEC,
    GRADUATION_ORDERS,
    GRADUATION_PHASES_RAD,
    PAPER_AFTER_ARCSEC,
    PAPER_BEFORE_ARCSEC,
    RevolutionSettings,
)

__all__ = [
    "DEPTH_STEP",
    "ECCENTRICITY_DIRECTION_RAD",
    "ECCENTRICITY_M",
    "FOUR_PLACES_DEG",
    "GRADUATION_ARCSEC",
    "GRADUATION_ORDERS",
    "GRADUATION_PHASES_RAD",
    "PAPER_AFTER_ARCSEC",
    "PAPER_BEFORE_ARCSEC",
    "RevolutionResult",
    "RevolutionSettings",
    "run_revolution",
    "set_up",
    "settled",
]
