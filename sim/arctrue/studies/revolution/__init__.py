"""Simulates one revolution of the virtual instrument at the paper's size: conditions, run and
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
