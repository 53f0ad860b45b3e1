"""Recognises a line of a reference whose period is the signal period of the grating."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.base.figures import with_uncertainty
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.next_measurement import NextMeasurement
from arctrue.workbench.effects.base import Effect, Parameter
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE, corrected_p_value

COVERAGE = 3.0
"""Factor of the standard uncertainty of an order, for a coverage of 99.7 %."""
EXACT = 0.01
"""A distance of an order from a multiple is negligible up to this value: it changes the phase by at
most 4° in one turn."""
HIGHEST = 4
"""Highest multiple of the signal period that is searched: a wrong offset, gain or phase causes the
multiples 1 and 2 (Heydemann, Appl. Opt. 20 (1981) 3382), a distorted wave 3 and 4."""


@dataclass(frozen=True)
class SignalPeriod:
    """A named line that is a multiple of the signal period, in a set that cannot test an effect of
    the signal."""

    multiple: int
    lines: int
    """Number of lines of the grating."""
    further: Mapping[int, Parameter]
    """Amplitudes of the other significant multiples."""
    untested: str
    """Name of the effect that causes such an error and that the set cannot test."""
    lacking: str
    """Data that the set lacks to test this effect."""

    @property
    def measurement(self) -> NextMeasurement:
        """The measurement that supplies the phase of the signal."""
        return NextMeasurement(
            "the same reference run with the counts of head 1 (column head1_counts): they give the "
            f"phase of the signal, with which {self.untested} can be tested",
            None,
        )

    def sentences(self) -> list[str]:
        """Return what the line and the other multiples show, in words."""
        times = "" if self.multiple == 1 else f"{self.multiple} times "
        said = [
            f"The order is {times}the number of grating lines, so it belongs to the signal period "
            f"(table.grating_lines = {self.lines}). {self.untested} is probable, but cannot be "
            f"tested: the set lacks {self.lacking}."
        ]
        if self.further:
            sizes = ", ".join(
                f"order {multiple * self.lines} "
                f"{with_uncertainty(size.value, size.sigma, size.unit)}"
                for multiple, size in self.further.items()
            )
            said.append(f"Other multiples of the signal period: {sizes}.")
        return said


def signal_period(
    item: Candidate | None,
    untestable: Mapping[str, list[str]],
    effects: Mapping[str, type[Effect]],
) -> SignalPeriod | None:
    """Return the signal period if the line ``item`` is a multiple of it and the set lacks data to
    test an effect of the signal; otherwise None."""
    if item is None or not item.effect.unspecific:
        return None
    place, observations = item.nonlinear, item.solution.observations
    untested = next((name for name in untestable if effects[name].of_the_signal), None)
    if untested is None:
        return None
    lines, order = observations.grating_lines, item.parameters().get("order")
    if lines is None or order is None or place.get("in_time") or place.get("in_capture"):
        return None
    multiple = round(order.value / lines)
    sigma = order.sigma if np.isfinite(order.sigma) else 0.0
    if multiple < 1 or abs(order.value - multiple * lines) > max(COVERAGE * sigma, EXACT):
        return None
    further, lacking = _further(item, multiple, lines), "; ".join(untestable[untested])
    return SignalPeriod(multiple, lines, further, untested, lacking)


def _further(item: Candidate, multiple: int, lines: int) -> dict[int, Parameter]:
    """Return the amplitudes of the other significant multiples that have more than two rows a
    period."""
    rows = item.solution.observations.reference
    if rows is None:
        return {}
    step_rad = float(np.median(np.abs(np.diff(rows.angle_rad))))
    residuals = Residuals(item.at_maximum)
    found = {}
    for other in range(1, HIGHEST + 1):
        order = float(other * lines)
        if other == multiple or order * step_rad >= np.pi:
            continue
        effect, place = type(item.effect)(), {**item.nonlinear, "order": order}
        score = residuals.score(effect, place)
        p_value = corrected_p_value(score.gain, score.rank, 1.0, HIGHEST)
        if score.rank == 2 and p_value < SIGNIFICANCE:
            grown = residuals.solution_with(effect, place, score)
            found[other] = grown.parameters()[-1]["amplitude"]
    return found
