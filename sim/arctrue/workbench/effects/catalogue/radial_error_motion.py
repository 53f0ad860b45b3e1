"""The axis of the table moves sideways in its bearing, as a function of the angle."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import partial
from math import comb

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.axis_motion import (
    SEPARATING_HEADS,
    capture_motion,
    motion_of_waves,
    reference_motion,
)
from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Lane,
    Leftover,
    Nonlinear,
    OfWaves,
    Parameter,
    Wave,
    paired_lanes,
)
from arctrue.workbench.effects.missing import Missing, lacking_capture
from arctrue.workbench.numeric.harmonics import harmonic_columns, harmonic_names
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows


class RadialErrorMotion(Effect):
    """Adds x(θ) and y(θ) of the axis in the frame of the heads, orders 2 to 8. With three or more
    heads, :meth:`narrowed` also tries order 1."""

    name = "radial_error_motion"
    physics = (
        "The axis moves in its bearing, in the same way in every turn. The heads stand still, "
        "so they see the motion at their own stator angles: the phase difference between the "
        "heads is α, not nα."
    )
    equation = "ε₁ = y(θ), δ₂₁ = x sin α + y (cos α − 1); x, y = Σ c cos kθ + s sin kθ"
    source = "ISO 230-7, synchronous radial error motion; exact for small motions"
    capture_sees = (
        "order k; the factor e^{jkα} − 1 of errors that are fixed to the disc does not apply"
    )
    reference_sees = "order k"
    separated_by = (
        "at orders 2 to 8 the coefficients from two heads differ from those of the reference; with "
        "three or four heads, the coefficients of different pairs of heads differ at orders 1 to 8"
    )
    next_measurement = "a third head, or the reference with its polygon re-indexed by some faces"
    moves_axis = True
    plausible = "0.1 to 2 µm (0.4 to 8″ at a radius of 54 mm)"
    parameter_units = {
        "x_cos_K": "arcsec",
        "x_sin_K": "arcsec",
        "y_cos_K": "arcsec",
        "y_sin_K": "arcsec",
        "separable_cos_K": "arcsec",
        "separable_sin_K": "arcsec",
    }
    compensation = "lanes"
    compensation_note = (
        "lanes correct the part that head 1 sees (y), after a reference run has separated it; the "
        "weighted mean of three or four heads does not contain the motion"
    )
    defaults = {"orders": list(range(2, 9))}

    def missing(self, observations: Observations) -> list[str]:
        lacking: list[str] = []
        if observations.capture is None:
            lacking.append(lacking_capture())
        if observations.reference is None and observations.heads < SEPARATING_HEADS:
            lacking.append(
                Missing(
                    "a reference run", reason="two heads alone cannot separate it from graduation"
                )
            )
        return lacking

    def column_names(self, observations: Observations) -> list[str]:
        orders = self.integers("orders")
        return harmonic_names(orders, "x ") + harmonic_names(orders, "y ")

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return capture_motion(rows, self.integers("orders"))

    def of_waves(self, rows: CaptureRows) -> OfWaves | None:
        if rows.heads > 2:
            return None
        waves = [
            Wave((type(self), order), 2, partial(harmonic_columns, rows.angle_rad, [order]))
            for order in self.integers("orders")
        ]
        return OfWaves(waves, motion_of_waves(rows.head_separation_rad, 2 * len(waves)))

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        return reference_motion(rows, self.integers("orders"))

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Add orders one by one while the gain rises by more than the BIC penalty of their columns.

        At uneven stations a large order also gives other orders a gain if each is tested alone.
        """
        observations = residuals.observations
        # With two heads and a reference, order 1 looks the same as order 1 of the disc.
        first = (1,) if observations.heads >= SEPARATING_HEADS else ()
        orders = tuple(sorted({*first, *self.integers("orders")}))
        reference, capture = observations.reference, observations.capture
        rows = 0 if reference is None else reference.run.size
        columns = 2.0
        if observations.heads >= SEPARATING_HEADS and capture is not None:
            rows, columns = capture.run.size, 2.0 * (observations.heads - 2)
        penalty = columns * float(np.log(max(2, rows)))
        kept: list[int] = []
        gain = 0.0
        while waiting := [order for order in orders if order not in kept]:
            forms = [RadialErrorMotion(orders=sorted([*kept, order])) for order in waiting]
            scores = residuals.scores([(form, {}) for form in forms])
            gains = {order: score.gain for order, score in zip(waiting, scores, strict=True)}
            best = max(gains, key=gains.__getitem__)
            if gains[best] <= gain + penalty:
                break
            kept, gain = sorted([*kept, best]), gains[best]
        if not kept:
            return self, 1.0
        narrowed = (
            self if tuple(kept) == self.integers("orders") else RadialErrorMotion(orders=kept)
        )
        return narrowed, float(comb(len(orders), len(kept)))

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        # Head 1 reads y; the columns of y come after the columns of x.
        orders = self.integers("orders")
        return paired_lanes(orders, coefficients[2 * len(orders) :])

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        """Return x, y and the part of R₂ − R₁ that no graduation can replace, per order.

        Two heads and a reference do not separate x and y from an order of the disc. They determine
        x sin α + y cos α minus y(θ + α), which a graduation of the size of y cannot cause.
        """
        orders = self.integers("orders")
        names = self.column_names(observations)
        mixing = np.vstack([np.eye(len(names)), *_separable(orders, observations)])
        names += [f"separable {kind} {order:g}" for order in orders for kind in ("cos", "sin")]
        values, spread = mixing @ coefficients, mixing @ covariance @ mixing.T
        sigma = np.sqrt(np.maximum(np.diag(spread), 0.0))
        return {
            name.replace(" ", "_"): Parameter(float(value), float(error), "arcsec")
            for name, value, error in zip(names, values, sigma, strict=True)
        }


def _separable(orders: Sequence[int], observations: Observations) -> Iterator[NDArray[np.float64]]:
    """Yield, for each order, cosine and sine of x sin α + y cos α − y(θ + α) as factors of the
    coefficients, shape (2, coefficients)."""
    alpha = observations.head_separation_rad
    for place, order in enumerate(orders):
        rows = np.zeros((2, 4 * len(orders)))
        x, y = 2 * place, 2 * (len(orders) + place)
        rows[:, x : x + 2] = np.sin(alpha) * np.eye(2)
        cosine, sine = np.cos(order * alpha), np.sin(order * alpha)
        # c cos k(θ + α) + s sin k(θ + α), as cosine and sine of kθ.
        turned = np.array([[cosine, sine], [-sine, cosine]])
        rows[:, y : y + 2] = np.cos(alpha) * np.eye(2) - turned
        yield rows
