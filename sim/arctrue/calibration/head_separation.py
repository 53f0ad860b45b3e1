"""Determines the separation α from the capture, its uncertainty, and whether it is plausible.

mean(R₂ − R₁) over uniform true angle is the separation according to the index marks: both heads
count from the same mark, and ε(θ + α) − ε(θ) has the mean 0. This mean repeats within ± 1 count per
head. The heads may detect the mark at different places. Repeated runs do not show this constant
difference, but α contains it in full (10 µm at the disc are 38″). A set states the standard
uncertainty of the difference as ``table.index_detection_arcsec``; the default is the standard
uncertainty of the heads' mounting, 50″/√3. If a head did not find its index, the values of α from
several runs disagree, or the value is far from nominal.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from arctrue.base.runs import run_spans
from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, rad_per_count
from arctrue.calibration.opposite_heads import opposite_runs, said_of
from arctrue.measurement import MeasurementSet

Choice = Literal["measured", "nominal", "harmonics"]
"""Source of α. ``measured``: the index marks; ``nominal``: the value in the set; ``harmonics``: the
reference run, see separation_by_harmonics.
"""

NOMINAL_TOLERANCE_ARCSEC = 50.0
U_NOMINAL_RAD = NOMINAL_TOLERANCE_ARCSEC / math.sqrt(3.0) * RAD_PER_ARCSEC
"""Standard uncertainty of the nominal α: rectangular distribution over the mounting tolerance."""
U_DETECTION_DEFAULT_ARCSEC = NOMINAL_TOLERANCE_ARCSEC / math.sqrt(3.0)
"""Default of ``table.index_detection_arcsec``: the mark's sensor is assumed to be mounted as
accurately as its head, not better."""
INDEX_REPEATABILITY_COUNTS = 1.0
BELIEVABLE_ARCSEC = 900.0
"""Largest plausible difference of α from nominal: 0.25°, 0.24 mm at the disc. No head is mounted
that inaccurately, so a larger difference is a fault of the index."""
RUNS_AGREE_COUNTS = 4.0
"""Largest difference between two runs that agree: ± 1 count for each of two heads."""


@dataclass(frozen=True)
class Separation:
    """A value of α with its standard uncertainty; without a value u is infinite and ``note``
    states the reason."""

    value_rad: float
    u_rad: float
    note: str = ""


def u_index_rad(
    counts_per_rev: int,
    index_detection_arcsec: float = 0.0,
    index_repeatability_counts: float | None = None,
) -> float:
    """Return the standard uncertainty of α by the index, the same for all runs.

    The index of each of the two heads repeats with the standard deviation
    ``index_repeatability_counts``; None: a rectangular distribution of ± 1 count.
    ``index_detection_arcsec`` is the standard uncertainty of the difference between the places
    where the heads detect the mark.
    """
    of_a_head = _repeatability(index_repeatability_counts) * rad_per_count(counts_per_rev)
    return math.hypot(math.sqrt(2.0) * of_a_head, index_detection_arcsec * RAD_PER_ARCSEC)


def _repeatability(stated_counts: float | None) -> float:
    """Return the standard deviation of one head's index, counts."""
    if stated_counts is None:
        return INDEX_REPEATABILITY_COUNTS / math.sqrt(3.0)
    return stated_counts


def chosen(
    choice: Choice,
    nominal_rad: float,
    measured: Separation,
    by_harmonics: Separation | None,
) -> Separation:
    """Return the separation from the source ``choice``.

    Raises ValueError for harmonics without a value.
    """
    if choice == "measured":
        return measured
    if choice == "nominal":
        return Separation(nominal_rad, U_NOMINAL_RAD)
    if by_harmonics is None or not math.isfinite(by_harmonics.u_rad):
        raise ValueError(
            "the harmonics do not determine the head separation"
            + (f": {by_harmonics.note}" if by_harmonics is not None else "")
        )
    return by_harmonics


def _difference_arcsec(angle_rad: float, from_rad: float) -> float:
    """Return the difference of two angles, within half a turn."""
    return math.remainder(angle_rad - from_rad, math.tau) * ARCSEC_PER_RAD


def doubts(nominal_rad: float, measured_rad: float) -> str | None:
    """Return a warning if no mounting explains the measured separation; None if the value is
    plausible."""
    off_arcsec = _difference_arcsec(measured_rad, nominal_rad)
    if abs(off_arcsec) <= BELIEVABLE_ARCSEC:
        return None
    said = f"the measured head separation is {off_arcsec:+.1f}″ from nominal"
    if abs(_difference_arcsec(measured_rad, -nominal_rad)) <= BELIEVABLE_ARCSEC:
        return (
            f"{said}, which is the opposite direction: are head1_counts and head2_counts swapped?"
        )
    return (
        f"{said}: do both heads count from the same index mark, and are "
        "table.head_separation_deg and table.counts_per_rev right?"
    )


def doubts_of(measurement: MeasurementSet) -> list[str]:
    """Return the calibration's warning about heads that count in opposite directions, or about an
    implausible head separation. No effect can explain either."""
    capture, table = measurement.capture, measurement.table
    if (
        capture is None
        or not capture.run.size
        or table.counts_per_rev is None
        or table.head_separation_deg is None
    ):
        return []
    opposite = opposite_runs(
        capture.head1_counts, capture.head2_counts, capture.run, table.counts_per_rev
    )
    if opposite:
        # The mean of R₂ − R₁ is then no angle between the heads.
        return [said_of(2, opposite, len(run_spans(capture.run)))]
    nominal_rad = math.radians(table.head_separation_deg)
    counts = float(np.mean(capture.head2_counts - capture.head1_counts))
    # The heads' counters may differ by whole turns, so only the fraction of a turn has a meaning.
    off_rad = math.remainder(2.0 * math.pi * counts / table.counts_per_rev - nominal_rad, math.tau)
    said = doubts(nominal_rad, nominal_rad + off_rad)
    return [] if said is None else [said]


def judge(
    nominal_rad: float,
    by_run_rad: Sequence[float],
    u_by_run_rad: Sequence[float],
    measured_rad: float,
    counts_per_rev: int,
    asked: Choice | None,
    index_detection_arcsec: float = 0.0,
    index_repeatability_counts: float | None = None,
) -> tuple[Choice, list[str]]:
    """Decide which separation is used, and return warnings for the user about this choice.

    The choice ``asked`` is used if it is given. Otherwise the index is used if the runs agree, its
    value is plausible, and its standard uncertainty of detection is not larger than the standard
    uncertainty of the nominal value; else the nominal value is used.
    """
    warnings = []
    trusted = True
    off_arcsec = _difference_arcsec(measured_rad, nominal_rad)
    spread = max(by_run_rad) - min(by_run_rad)
    # RUNS_AGREE_COUNTS holds for ± 1 count; a larger stated repeatability widens the limit in
    # proportion.
    wider = max(_repeatability(index_repeatability_counts) / _repeatability(None), 1.0)
    allowed = wider * RUNS_AGREE_COUNTS * rad_per_count(counts_per_rev) + 6.0 * max(u_by_run_rad)
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
    preferred = trusted and index_detection_arcsec * RAD_PER_ARCSEC <= U_NOMINAL_RAD * (1 + 1e-9)
    choice: Choice = asked or ("measured" if preferred else "nominal")
    if not trusted and asked is None:
        warnings[-1] += " (the nominal value is used; --head-separation measured forces the other)"
    return choice, warnings
