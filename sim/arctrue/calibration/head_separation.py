"""α: what the capture says of it, and whether to believe that.

mean(R₂ − R₁) over uniform true angle is the true separation: both heads count from the same mark,
and ε(θ + α) − ε(θ) has no mean. It is good to the index's repeatability, ± 1 count = 0.08″, where
the nominal value is good to ± 50″. What can spoil it is an index that is not found at the same
place by both heads (10 µm of difference at the disc are 38″, within the nominal tolerance still),
or one that is not found at all; that shows as runs that disagree or a value far from nominal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal

from arctrue.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, rad_per_count

Choice = Literal["measured", "nominal"]

NOMINAL_TOLERANCE_ARCSEC = 50.0
U_NOMINAL_RAD = NOMINAL_TOLERANCE_ARCSEC / math.sqrt(3.0) * RAD_PER_ARCSEC
"""Rectangular distribution over the tolerance."""
INDEX_REPEATABILITY_COUNTS = 1.0
BELIEVABLE_ARCSEC = 900.0
"""0.25°, 0.24 mm at the disc: no head is mounted so badly; the index is at fault."""
RUNS_AGREE_COUNTS = 4.0
"""± 1 count for each of two heads, between the two runs furthest apart."""


def u_index_rad(counts_per_rev: int) -> float:
    """Standard uncertainty by the index: rectangular over ± 1 count, the same for all runs."""
    return INDEX_REPEATABILITY_COUNTS / math.sqrt(3.0) * rad_per_count(counts_per_rev)


def doubts(nominal_rad: float, measured_rad: float) -> str | None:
    """What is said of a measured separation that no head's mounting explains; None: it may be."""
    off_arcsec = (measured_rad - nominal_rad) * ARCSEC_PER_RAD
    if abs(off_arcsec) <= BELIEVABLE_ARCSEC:
        return None
    said = f"the measured head separation is {off_arcsec:+.1f}″ from nominal"
    if abs(measured_rad + nominal_rad) * ARCSEC_PER_RAD <= BELIEVABLE_ARCSEC:
        return f"{said}, which is the other way round: are head1_counts and head2_counts swapped?"
    return (
        f"{said}: do both heads count from the same index mark, and are "
        "table.head_separation_deg and table.counts_per_rev right?"
    )


def judge(
    nominal_rad: float,
    by_run_rad: Sequence[float],
    u_by_run_rad: Sequence[float],
    measured_rad: float,
    counts_per_rev: int,
    asked: Choice | None,
) -> tuple[Choice, list[str]]:
    """Which separation to use, and what a person should know about it."""
    warnings = []
    trusted = True
    off_arcsec = (measured_rad - nominal_rad) * ARCSEC_PER_RAD
    spread = max(by_run_rad) - min(by_run_rad)
    allowed = RUNS_AGREE_COUNTS * rad_per_count(counts_per_rev) + 6.0 * max(u_by_run_rad)
    if spread > allowed:
        trusted = False
        warnings.append(
            f"the runs disagree on the head separation by {spread * ARCSEC_PER_RAD:.2f}″, "
            f"more than the index's repeatability ({allowed * ARCSEC_PER_RAD:.2f}″)"
        )
    if unbelievable := doubts(nominal_rad, measured_rad):
        trusted = False
        warnings.append(unbelievable)
    elif abs(off_arcsec) > NOMINAL_TOLERANCE_ARCSEC:
        warnings.append(
            f"the measured head separation is {off_arcsec:+.1f}″ from nominal, "
            f"outside the tolerance of ±{NOMINAL_TOLERANCE_ARCSEC:g}″"
        )
    choice: Choice = asked or ("measured" if trusted else "nominal")
    if not trusted and asked is None:
        warnings[-1] += " (the nominal value is used; --head-separation measured forces the other)"
    return choice, warnings
