"""Repeats the paper's experiment (section 4): ten cycles with polygon and autocollimator, and the
uncertainty."""

from arctrue.studies.paper.budget import (
    UncertaintyBudget,
    bessel_deviation,
    mounting_eccentricity_rad,
    tower_difference_rad,
)
from arctrue.studies.paper.published import PUBLISHED, Published
from arctrue.studies.paper.station_error import StationErrors, residual_orders, station_errors

__all__ = [
    "PUBLISHED",
    "Published",
    "StationErrors",
    "UncertaintyBudget",
    "bessel_deviation",
    "mounting_eccentricity_rad",
    "residual_orders",
    "station_errors",
    "tower_difference_rad",
]
