"""The rolling elements of a bearing move the axis at an order that is not an integer."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.axis_motion import (
    SEPARATING_HEADS,
    capture_motion,
    reference_motion,
)
from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Nonlinear,
    Parameter,
    RealLane,
    SearchParameter,
    amplitude_and_phase,
    paired_real_lanes,
)
from arctrue.workbench.effects.conditions import one_speed
from arctrue.workbench.effects.missing import lacking_capture
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

SEPARATED_SIGMA = 5.5
"""Smallest distance of the order from whole and half orders, in standard uncertainties; 5.5² is the
χ² of 30 that the search requires."""
LEAST_SEEN = 0.1
"""Smallest ratio of the motions y and x that head 1 and the other head see. Of ellipses with
uniformly distributed axis ratio and direction, a share of LEAST_SEEN²/2 = CONTRADICTED_P has a
smaller ratio.
"""
SURELY_LESS = 3.0
"""Standard uncertainties by which y must be below the limit."""
LEAST_TURNS = 1.98
"""Smallest number of turns between first and last sample; a run of two turns has slightly less than
2."""


class BearingBallPass(Effect):
    """Adds axis motion as cos νθ and sin νθ over the unwrapped angle; a search finds ν, which is
    not an integer."""

    name = "bearing_ball_pass"
    physics = (
        "The cage and the balls of a rolling bearing revolve at rates that are not integer "
        "multiples of the table's rotation. The motion repeats over the unwrapped angle, not in "
        "every turn."
    )
    equation = "x, y = Σ c cos νθ + s sin νθ, θ unwrapped; the fit searches for ν"
    source = "ISO 15243 kinematics of rolling bearings; ISO 230-7 asynchronous error motion"
    capture_sees = "order ν of the unwrapped angle; three heads separate x from y"
    reference_sees = (
        "order ν of the unwrapped angle; at stations that every cycle visits, an error that is not "
        "the same in every cycle"
    )
    separated_by = "order tracking over the unwrapped angle; the order is the same at every speed"
    next_measurement = "a capture of more turns in one run: ν is resolved to 1/(2·turns)"
    moves_axis = True
    plausible = "0.05 to 1 µm"
    parameter_units = {
        "order": "1",
        "difference_amplitude": "arcsec",
        "difference_phase": "deg",
        "head1_amplitude": "arcsec",
        "head1_phase": "deg",
    }
    compensation_note = (
        "only a bitstream with REAL_ORDERS can correct it, and only if a reference run or a third "
        "head separates x from y; the weighted mean of three or four heads does not contain it "
        "(arctrue calibrate --angle mean)"
    )
    search_kind = "unwrapped_order"
    search = (SearchParameter("order", "1", 0.2, 60.0, "periods per turn, not an integer"),)
    defaults = {"highest_order": 60}

    def missing(self, observations: Observations) -> list[str]:
        if observations.capture is None:
            return [lacking_capture()]
        if observations.longest_run_turns < LEAST_TURNS:
            return ["a run of at least two turns: ν is resolved to 1/(2·turns)"]
        return []

    def variety(self, observations: Observations) -> list[str]:
        return one_speed(observations)

    def search_range(self, name: str) -> tuple[float, float]:
        highest = self.settings["highest_order"]
        assert isinstance(highest, int)
        return self.search[0].low, float(highest)

    def column_names(self, observations: Observations) -> list[str]:
        return ["x cos", "x sin", "y cos", "y sin"]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return capture_motion(rows, [nonlinear["order"]])

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return reference_motion(rows, [nonlinear["order"]])

    def search_contradiction(
        self, found: Mapping[str, Parameter], observations: Observations
    ) -> str | None:
        """Refuse an order that cannot be distinguished from a whole or half order.

        A motion that repeats after one or two turns (a belt, a gear of two to one) has such an
        order and is the simpler explanation; balls and cage do not turn at such rates. Few of all
        possible orders lie in the narrow interval around a whole or half order. An order in this
        interval therefore counts as whole or half unless the odds against this are 10⁶ (Occam's
        factor).
        """
        order = found["order"]
        half = round(2.0 * order.value) / 2.0
        # If σ is undetermined, the data do not show that the order differs from a whole or half
        # order.
        if not abs(order.value - half) <= SEPARATED_SIGMA * order.sigma:
            return None
        turns = "every turn" if half == round(half) else "every two turns"
        return (
            f"its order {order.value:.4g} ± {order.sigma:.2g} is not distinguishable from "
            f"{half:g}, which repeats {turns}; balls and cage of a bearing have no such rate"
        )

    def contradiction(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> str | None:
        """Refuse a motion that the heads' difference shows and the reference does not.

        Head 1 reads y. Without y, the difference is x·sin α; an ellipse of almost any direction has
        x and y.
        """
        if observations.reference is None:
            return None
        x, y = np.hypot(*coefficients[:2]), np.hypot(*coefficients[2:])
        sigma = np.sqrt(max(float(np.linalg.eigvalsh(covariance[2:, 2:])[-1]), 0.0))
        if sigma <= 0.0 or y + SURELY_LESS * sigma >= LEAST_SEEN * x:
            return None
        return (
            f"the difference of the heads implies a motion of {x:.2g}″, but head 1 sees "
            f"only {y:.2g}″ ± {sigma:.1g}″ in the reference: only one head shows the error"
        )

    def real_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[RealLane]:
        """Return the lane of y, which head 1 reads; two heads alone cannot separate y from x."""
        if observations.reference is None and observations.heads < SEPARATING_HEADS:
            return []
        return paired_real_lanes([nonlinear["order"]], coefficients[2:])

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        alpha = observations.head_separation_rad
        # Two heads cannot separate x and y, but head 1 and the difference each determine one
        # combination of x and y.
        mixing = np.array(
            [
                [np.sin(alpha), 0.0, np.cos(alpha) - 1.0, 0.0],
                [0.0, np.sin(alpha), 0.0, np.cos(alpha) - 1.0],
            ]
        )
        difference = mixing @ coefficients
        spread = mixing @ covariance @ mixing.T
        found = {"order": Parameter(nonlinear["order"], float("nan"), "1")}
        found |= amplitude_and_phase(difference[0], difference[1], spread, "difference_")
        if observations.reference is not None or observations.heads >= SEPARATING_HEADS:
            found |= amplitude_and_phase(
                coefficients[2], coefficients[3], covariance[2:, 2:], "head1_"
            )
        return found
