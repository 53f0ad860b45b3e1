"""The two heads are not latched at the same instant."""

from __future__ import annotations

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.workbench.effects.base import Columns, FitContext, Nonlinear
from arctrue.workbench.effects.conditions import one_velocity
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.effects.scalar_effect import ScalarOfEachHead
from arctrue.workbench.observations import CaptureRows, Observations


class TimingSkew(ScalarOfEachHead):
    """Adds Δτ·ω to R₂ − R₁."""

    name = "timing_skew"
    physics = (
        "Head 2 is read Δτ after head 1, because of its cable, filter or interpolator. In this "
        "time the table moves by Δτ·ω, so R₂ − R₁ changes in proportion to the signed speed."
    )
    physics_of_one = (
        "Head {head} is read Δτ after the other heads, because of its cable, filter or "
        "interpolator. In this time the table moves by Δτ·ω, so that its reading changes against "
        "theirs in proportion to the signed speed."
    )
    equation = "δ₂₁ = Δτ·ω"
    source = "sampling of a moving scale"
    capture_sees = "an offset in proportion to the signed speed"
    reference_sees = "nothing at standstill"
    separated_by = "runs at several speeds and in both directions"
    next_measurement = "runs in both directions at a speed that this set does not have"
    in_parts = ("speed", "head2")
    plausible = "0.05 to 10 µs"
    parameter_units = {"skew": "us"}
    compensation_note = (
        "the output contains only head 1, so it has no such error; make the electronics read both "
        "heads at the same instant"
    )
    note_of_one = (
        "the output contains only head 1, so it has no such error; make the electronics read all "
        "heads at the same instant"
    )
    note_of_head1 = (
        "the output is the reading of head 1, which is late by this time; make the electronics "
        "read all heads at the same instant"
    )
    parameter_name = "skew"
    parameter_unit = "us"

    def missing(self, observations: Observations) -> list[str]:
        return [] if observations.capture is not None else [lacking_capture()]

    def variety(self, observations: Observations) -> list[str]:
        return one_velocity(observations)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return self.columns(rows.speed_rad_s * ARCSEC_PER_RAD * 1e-6, rows)
