"""The table stops at an angle that depends on the direction of approach."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    ConditionedLane,
    Effect,
    FitContext,
    Lane,
    Leftover,
    Nonlinear,
    Parameter,
    SearchParameter,
)
from arctrue.workbench.effects.scalar_effect import ScalarEffect
from arctrue.workbench.observations import Observations, ReferenceRows

LEAST_REVERSALS = 2
"""Smallest number of reversals. With one reversal only, all rows of one direction come before all
rows of the other, so that any step or drift in time looks the same."""
WIDEST_DEG = 45.0
"""Largest width: twice the largest W, 22.5°, of the gateware's stop operator (u20.4 counts) at 2²⁴
counts per turn."""
NARROWEST_DEG = 0.05
"""Smallest width: a twentieth of the width that an export assumes for an effect without a width."""
WITH_WIDTH = ("linear", "exponential")
"""Forms of the transition after a reversal: Prandtl's stop operator (Dahl's model with the exponent
0), and Dahl's model with the exponent 1 (P. R. Dahl, Aerospace Corporation TOR-0158(3107-18)-1,
1968)."""
TRANSITIONS = ("short", *WITH_WIDTH)
"""Forms of the transition; a short one is complete at the second place after a reversal, so that
the rows show only an upper limit of its width."""
TRIED_WIDTHS = np.geomspace(NARROWEST_DEG, WIDEST_DEG, 24)
"""Widths at which a transition is tried, in steps of a third: with a width that is a sixth wrong, a
linear transition still removes more than nine tenths of the error that remains without a
transition."""
MOST_OF_A_PASS = 0.125
"""Largest width that is tried, as a share of the longest travel without a reversal: WIDEST_DEG is
this share of a turn. A linear transition over a whole pass is a straight line of the angle, the
same in both directions, as a scale error of the reference is."""
FURTHER_COLUMNS = ("transition", "start")
"""Columns that a transition adds: its size after a reversal, and its size at the start."""
MOST_LEFT = 0.5
"""Largest ratio of the residual mean square with a transition to that without one, both above the
noise of the repeats: the transition then explains more of this error than all other causes."""
EQUAL_INTEGRAL = 2.0
"""Width of a linear transition with the same integral as an exponential transition, in units of the
travel over which the exponential decays to 1/e."""


class Hysteresis(ScalarEffect):
    """Adds ± half the reversal error to the reference run, by direction.

    With a setting ``transition``, friction takes up the error within a travel after each reversal.
    The search parameter ``width`` is this travel: to the end of a linear transition, or to 1/e of
    an exponential one. If the table moves beyond the last station before it reverses, it moves a
    part of the width before the first row. The transition therefore has a size of its own,
    ``transition``, which equals ``reversal_error`` without such an overtravel. The rows before the
    first reversal have another size, ``start``.
    """

    name = "hysteresis"
    physics = (
        "Friction twists the shaft between disc and table; the sign of the twist depends on the "
        "direction of motion. Both heads are at the disc and do not see the twist."
    )
    equation = (
        "ε = d·(B/2 − C·f(s/w)), d = ±1 direction, B reversal error; s travel since the reversal; "
        "w width and C size of the transition, f(x) = max(1 − x, 0) or e^{−x}; C = 0 without it"
    )
    source = (
        "ISO 230-2, reversal error of an axis; transition: Prandtl's stop operator, or Dahl's "
        "model of friction"
    )
    capture_sees = "almost nothing"
    reference_sees = "positive and negative approach differ by B at every station"
    separated_by = "a reference run in both directions"
    next_measurement = "one more reference run in both directions"
    plausible = "0.1 to 5″"
    parameter_units = {"reversal_error": "arcsec"}
    compensation = "modulators"
    compensation_note = (
        "the correction follows the direction of approach; the default bitstream cannot correct it"
    )
    parameter_name = "reversal_error"
    reversal_of_the_table = "reversal_error"
    parameter_unit = "arcsec"
    in_parts = ("direction", "reference")
    defaults = {"transition": "none"}
    narrowed_when_added = True

    def __init__(self, **settings: object) -> None:
        """Make the effect. Raises ValueError for a transition that does not exist."""
        super().__init__(**settings)
        if self.transition not in ("none", *TRANSITIONS):
            raise ValueError(
                f"effect {self.name}: setting transition must be none, {' or '.join(TRANSITIONS)}, "
                f"found {self.transition!r}"
            )
        if self.transition in WITH_WIDTH:
            width = SearchParameter(
                "width",
                "deg",
                NARROWEST_DEG,
                WIDEST_DEG,
                "travel after a reversal within which friction takes up the error",
            )
            self.search = (width,)  # type: ignore[misc]

    @property
    def transition(self) -> str:
        """The form of the transition after a reversal."""
        return str(self.settings["transition"])

    def column_names(self, observations: Observations) -> list[str]:
        names = [self.parameter_name]
        return names if self.transition == "none" else [*names, *FURTHER_COLUMNS]

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Return the form of the effect with the largest gain minus BIC penalty, and the number of
        trials. The penalty counts the further parameters and the widths that were tried. The trials
        are all forms and widths that were tried; without a transition, their number is 1.

        In most sets the reversals are at the same stations. A reversal error that differs from
        place to place looks like a transition there. It also differs at the other stations, so a
        transition explains only a small part of it.
        """
        rows = residuals.observations.reference
        if self.transition != "none" or rows is None or rows.travel_rad is None:
            return self, 1.0
        best: Effect = self
        most, trials = residuals.score(self, {}).gain, 1
        excess = residuals.reference_excess_arcsec2(self, {})
        widest = MOST_OF_A_PASS * float(np.degrees(rows.travel_rad.max(initial=0.0)))
        widths = [{"width": float(width)} for width in TRIED_WIDTHS if width <= widest]
        for form in self.forms()[1:]:
            places = widths if form.search else [{}]
            if not places:
                continue
            gains = [residuals.score(form, place).gain for place in places]
            trials += len(places)
            place = places[int(np.argmax(gains))]
            further = len(FURTHER_COLUMNS) + len(form.search)
            gain = max(gains) - further * float(np.log(rows.run.size))
            gain -= 2.0 * float(np.log(len(places)))
            if gain > most and residuals.reference_excess_arcsec2(form, place) < MOST_LEFT * excess:
                best, most = form, gain
        return best, 1.0 if best is self else float(trials)

    def forms(self) -> list[Effect]:
        if self.transition != "none":
            return [self]
        return [self, *(Hysteresis(transition=form) for form in TRANSITIONS)]

    def describe_values(self, parameters: Mapping[str, Parameter]) -> str:
        if self.transition == "none":
            return ""
        width = parameters["width"]
        start = "After a reversal, the error changes its sign within"
        if self.transition == "short":
            return f"{start} less than {2.0 * width.value:.3g}° of travel, where the next row is."
        form = "" if self.transition == "linear" else ", by an exponential to 1/e"
        return f"{start} {width.value:.3g}° of travel (u {width.sigma:.2g}°){form}."

    def missing(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None:
            return ["a reference run"]
        if rows.direction is None:
            return ["the column direction in the reference run"]
        if rows.direction.min() == rows.direction.max():
            return ["a reference run in both directions"]
        return []

    def variety(self, observations: Observations) -> list[str]:
        rows = observations.reference
        if rows is None or rows.direction is None:
            return []
        if np.count_nonzero(np.diff(rows.direction)) >= LEAST_REVERSALS:
            return []
        return [
            "the reference run up and down once more: a change with time at its only reversal "
            "looks the same"
        ]

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found = super().parameters(coefficients, covariance, nonlinear, observations)
        for item in self.search:
            found[item.name] = Parameter(nonlinear[item.name], float("nan"), item.unit)
        rows = observations.reference
        if self.transition == "short" and rows is not None:
            # All widths below this travel are equally probable.
            most = _second_travel_deg(rows)
            found["width"] = Parameter(0.5 * most, most / float(np.sqrt(12.0)), "deg")
        return found

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        lane = Lane(0, 0.5 * float(coefficients[0]), 0.0)
        width = self._whole_width_deg(coefficients, nonlinear)
        return [ConditionedLane("direction", lane, width_deg=width)]

    def _whole_width_deg(
        self, coefficients: NDArray[np.float64], nonlinear: Nonlinear
    ) -> float | None:
        """Return the travel within which a stop operator changes from one end to the other, also if
        a part of this travel is before the first row after a reversal; None if the width is not
        known."""
        if self.transition not in WITH_WIDTH:
            return None
        if self.transition == "exponential":
            return EQUAL_INTEGRAL * nonlinear["width"]
        error, transition = (float(value) for value in coefficients[:2])
        share = transition / error if error != 0.0 else 1.0
        return nonlinear["width"] / share if 0.0 < share < 1.0 else nonlinear["width"]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.direction is None:
            return None
        columns = 0.5 * rows.direction[:, None]
        if self.transition == "none":
            return columns
        if rows.travel_rad is None or rows.reversals is None or rows.at_reversal is None:
            # If only the direction of the rows is known, they count as far from the last reversal.
            return np.hstack([columns, np.zeros((rows.direction.size, 2))])
        travel = np.degrees(rows.travel_rad)
        if self.transition == "short":
            before = rows.at_reversal.astype(np.float64)
        elif self.transition == "linear":
            before = np.maximum(1.0 - travel / nonlinear["width"], 0.0)
        else:
            before = np.exp(-travel / nonlinear["width"])
        after_reversal = rows.reversals > 0
        sizes = np.stack([after_reversal, ~after_reversal], axis=1) * before[:, None]
        return np.hstack([columns, -rows.direction[:, None] * sizes])


def _second_travel_deg(rows: ReferenceRows) -> float:
    """Return the smallest travel at the second place after a reversal, where a short transition is
    complete."""
    if rows.travel_rad is None or rows.at_reversal is None:
        return WIDEST_DEG
    beyond = ~rows.at_reversal
    return float(np.degrees(np.min(rows.travel_rad, where=beyond, initial=np.radians(WIDEST_DEG))))
