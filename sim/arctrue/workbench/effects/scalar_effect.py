"""Defines effects whose parameters are their coefficients, in the effect's own unit.

Most such effects have one coefficient; an effect that exists at each head has one coefficient per
head.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import Columns, Effect, Leftover, Nonlinear, Parameter
from arctrue.workbench.effects.capture_block import in_place_of_head
from arctrue.workbench.observations import CaptureRows, Observations

Float = NDArray[np.float64]

OF_A_SECOND_CAUSE = 0.05
"""Share of the gain in log likelihood that further heads may add to the gain of the best head, and
this head is still the cause: a second cause of the runs adds to the gain of every head."""


class ScalarEffect(Effect):
    """An effect whose size is one number."""

    parameter_name: ClassVar[str]
    parameter_unit: ClassVar[str]

    def column_names(self, observations: Observations) -> list[str]:
        return [self.parameter_name]

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        sigma = np.sqrt(np.maximum(np.diag(covariance), 0.0))
        names = self.column_names(observations)
        return {
            name: Parameter(float(value), float(error), self.parameter_unit)
            for name, value, error in zip(names, coefficients, sigma, strict=True)
        }


class ScalarOfEachHead(ScalarEffect):
    """An effect that exists at each head, such as a bracket angle or a delay, with one number per
    head.

    Heads 2, 3, … have one coefficient each; an effect at head 1 changes all these coefficients
    equally. The setting ``heads``, if given, lists the heads that have coefficients and may contain
    head 1.
    """

    defaults: ClassVar[Mapping[str, object]] = {"heads": []}
    physics_of_one: ClassVar[str] = ""
    """``physics`` of a capture of three or four heads, if one head alone has the effect."""
    note_of_one: ClassVar[str] = ""
    """``compensation_note`` of one head that is not the output."""
    note_of_head1: ClassVar[str] = ""
    """``compensation_note`` of head 1, which is the output."""

    def __init__(self, **settings: object) -> None:
        """Make the effect; with one head in ``heads`` it equals a product of parts fixed to that
        head, and its texts name that head."""
        super().__init__(**settings)
        heads = self.integers("heads")
        if len(heads) == 1:
            self.in_parts = tuple(  # type: ignore[misc]
                f"head{heads[0]}" if name == "head2" else name for name in type(self).in_parts
            )
            if not self.physics_of_one:
                return
            note = self.note_of_head1 if heads[0] == 1 else self.note_of_one
            self.physics = self.physics_of_one.format(head=heads[0])  # type: ignore[misc]
            self.compensation_note = note.format(head=heads[0])  # type: ignore[misc]

    def column_names(self, observations: Observations) -> list[str]:
        heads = self.integers("heads") or range(2, observations.heads + 1)
        return [
            self.parameter_name if head == 2 else f"{self.parameter_name}_head{head}"
            for head in heads
        ]

    def columns(self, values: Float, rows: CaptureRows) -> Columns:
        """Return the columns of all heads. ``values``, (rows,): contribution of one head to its own
        reading."""
        heads = self.integers("heads")
        if not heads:
            return in_place_of_head(values[:, np.newaxis], rows)
        shares = np.array([-1.0 if head == 1 else float(head == rows.head) for head in heads])
        return np.asarray(values[:, np.newaxis] * shares)

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Return the effect with the best single head, and the number of heads tried, if the other
        heads gain less than the BIC penalty of their columns, or than a small share of the whole
        gain, which a second cause may add; otherwise return the effect itself and 1."""
        observations = residuals.observations
        if observations.heads == 2 or observations.capture is None or self.integers("heads"):
            return self, 1.0
        gains = {
            head: residuals.score(type(self)(heads=[head]), {}).gain
            for head in range(1, observations.heads + 1)
        }
        best = max(gains, key=gains.__getitem__)
        further = (observations.heads - 2) * float(np.log(observations.capture.run.size))
        whole = residuals.score(self, {}).gain
        if whole - gains[best] > max(further, OF_A_SECOND_CAUSE * whole):
            return self, 1.0
        return type(self)(heads=[best]), float(observations.heads)
