"""What the paper prints in section 4 and its tables 2 and 3."""

from __future__ import annotations

from dataclasses import dataclass, field

from arctrue.studies.paper.budget import UncertaintyBudget


@dataclass(frozen=True)
class Published:
    """Figures in arcsec unless the name says otherwise."""

    faces: int = 24
    cycles: int = 10
    before_arcsec: tuple[float, float] = (-150.0, 137.9)
    after_arcsec: tuple[float, float] = (-1.3, 1.6)
    largest_deviation_arcsec: float = 0.2
    mounting_offset_m: float = 1e-6
    flatness_m: float = 0.03e-6
    face_width_m: float = 10e-3
    tilt_arcsec: float = 8.0
    budget: UncertaintyBudget = field(
        default_factory=lambda: UncertaintyBudget(0.1, 0.05, 0.2, 0.0005, 0.0001)
    )
    combined_arcsec: float = 0.23
    expanded_arcsec: float = 0.46


PUBLISHED = Published()
