"""The worm or the gear that drives the table has periodic errors."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Lane,
    Leftover,
    Nonlinear,
    Parameter,
    RealLane,
    amplitude_and_phase,
    paired_lanes,
    paired_real_lanes,
)
from arctrue.workbench.effects.missing import lacking_key
from arctrue.workbench.numeric.harmonics import harmonic_columns
from arctrue.workbench.observations import Observations, ReferenceRows

HIGHEST_MULTIPLE = 3
"""Highest multiple of the tooth count that is tried, a choice."""
WHOLE_TURN = 0.9
"""Smallest share of a turn that the stations must cover to separate harmonics one order apart."""
LEAST_VARIANCE = 0.1
"""Smallest sum of the variances of a harmonic's cosine and sine columns over the stations; the sum
is 1 if the stations resolve the harmonic fully."""
AS_GOOD = 6.0
"""Of several harmonics that may be aliases, the first one is chosen whose gain is less than this
below the largest gain: odds of 20 to 1."""
LISTS = {"multiples": 0, "below": -1, "above": 1}
"""Settings that list multiples of the tooth count, with the distance of a line from its multiple,
in orders."""

Line = tuple[int, int]
"""A harmonic ("line"): factor of the tooth count, and distance from this multiple, in orders."""

USUAL: list[list[Line]] = [
    [(multiple, away) for away in distances for multiple in range(1, highest + 1)]
    for highest in range(1, HIGHEST_MULTIPLE + 1)
    for distances in ((0,), tuple(LISTS.values()))
]
"""The usual sets of lines: the tooth count and its first multiples, for a centred gear and for an
eccentric gear."""


class DriveGearError(Effect):
    """Adds cosine and sine of the tooth count and its multiples to the reference run only.

    A gear off its centre meshes slightly early and late once a turn. This causes the orders one
    below and one above each multiple; the settings ``below`` and ``above`` list these multiples.
    """

    name = "drive_gear_error"
    order_is_stated = True
    physics = (
        "The error of the worm or of the gear's teeth repeats, so the table follows with as "
        "many periods per turn as the wheel has teeth. The disc on the axis does not move "
        "relative to its heads, so the two heads do not see the error."
    )
    equation = (
        "ε = Σ c cos(kGθ) + s sin(kGθ); G is the number of teeth (drive_gear_teeth, a positive "
        "number, not necessarily an integer); an eccentric gear also causes the orders kG ± 1"
    )
    source = "ISO 1328, periodic error of a gear"
    capture_sees = "nothing if the disc is mounted on the axis"
    reference_sees = (
        "order G; with a polygon, an alias at G modulo the number of faces. If the number of faces "
        "divides G, only the orders G ± 1 remain visible, as an alias at order 1"
    )
    separated_by = "the order is the tooth count"
    next_measurement = "a reference run with stations closer than half a tooth"
    plausible = "0.5 to 30″"
    parameter_units = {
        "multiple_K_amplitude": "arcsec",
        "multiple_K_phase": "deg",
        "multiple_K_below_amplitude": "arcsec",
        "multiple_K_below_phase": "deg",
        "multiple_K_above_amplitude": "arcsec",
        "multiple_K_above_phase": "deg",
    }
    compensation = "lanes"
    compensation_note = (
        "lanes of the orders kG correct it, after a reference run has measured it; a tooth count "
        "that is not an integer needs REAL_ORDERS"
    )
    defaults = {"multiples": [1], "below": [], "above": []}
    multiples_setting = "multiples"
    narrowed_when_added = True

    @property
    def _lines(self) -> list[Line]:
        return [(multiple, away) for key, away in LISTS.items() for multiple in self.integers(key)]

    def missing(self, observations: Observations) -> list[str]:
        lacking: list[str] = []
        if observations.drive_gear_teeth is None:
            lacking.append(lacking_key("table.drive_gear_teeth"))
        if observations.reference is None:
            lacking.append("a reference run")
        return lacking

    def declared_order(self, observations: Observations) -> float | None:
        return observations.drive_gear_teeth

    def column_names(self, observations: Observations) -> list[str]:
        return [
            f"tooth {kind} {multiple}{away:+d}" if away else f"tooth {kind} {multiple}"
            for multiple, away in self._lines
            for kind in ("cos", "sin")
        ]

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.teeth is None:
            return None
        return harmonic_columns(rows.angle_rad, self._orders(rows.teeth))

    def _orders(self, teeth: float) -> list[float]:
        return [teeth * multiple + away for multiple, away in self._lines]

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Add lines one by one while the gain rises by the BIC penalty of two columns or more.

        If no line is added, the effect stays unchanged. Candidates are the first HIGHEST_MULTIPLE
        multiples of the tooth count and, if the stations cover the turn, the sidebands of an
        eccentric gear.
        """
        reference = residuals.observations.reference
        assert reference is not None
        worth = 2.0 * float(np.log(max(2, reference.run.size)))
        whole = float(np.ptp(reference.target_rad)) > WHOLE_TURN * 2.0 * np.pi
        lines = [
            (multiple, away)
            for multiple in range(1, HIGHEST_MULTIPLE + 1)
            for away in (LISTS.values() if whole else (0,))
            if self._varies((multiple, away), reference)
        ]
        kept: list[Line] = []
        gain = 0.0
        while waiting := [line for line in lines if self._is_another(line, kept, reference)]:
            found = [self._gain(residuals, [*kept, line]) for line in waiting]
            if max(found) < gain + worth:
                break
            # At the faces, lines may be aliases of each other: take the first line that is about as
            # good as the best.
            place = next(at for at, value in enumerate(found) if value > max(found) - AS_GOOD)
            kept.append(waiting[place])
            gain = found[place]
        if not kept or set(kept) == set(self._lines):
            return self, 1.0
        trials = comb(len(lines), len(kept))
        usual = [self._shown(form, lines, reference) for form in USUAL]
        if set(kept) in usual:
            # A set of lines in USUAL counts as one of only len(USUAL) trials, because it was not
            # chosen among all sets of lines.
            trials = min(trials, len(USUAL))
        return self._of(kept), float(trials)

    def _shown(self, form: list[Line], lines: list[Line], reference: ReferenceRows) -> set[Line]:
        """Return the lines of ``form`` that the stations can separate, without repetitions."""
        shown: list[Line] = []
        for line in form:
            if line in lines and self._is_another(line, shown, reference):
                shown.append(line)
        return set(shown)

    def _varies(self, line: Line, reference: ReferenceRows) -> bool:
        """Tell whether the line varies over the stations, that is, whether it is not an alias of a
        constant."""
        columns = self._of([line]).reference_columns(reference, {}, FitContext())
        return columns is not None and float(np.var(columns, axis=0).sum()) > LEAST_VARIANCE

    def _is_another(self, line: Line, kept: list[Line], reference: ReferenceRows) -> bool:
        """Tell whether the stations separate the line from the kept lines, that is, whether it is
        not an alias of these lines."""
        if not kept:
            return True
        columns, others = (
            self._of(lines).reference_columns(reference, {}, FitContext())
            for lines in ([line], kept)
        )
        assert columns is not None
        assert others is not None
        columns, others = columns - columns.mean(axis=0), others - others.mean(axis=0)
        left = columns - others @ np.linalg.lstsq(others, columns, rcond=None)[0]
        return float(np.sum(left**2)) > LEAST_VARIANCE * float(np.sum(columns**2))

    @staticmethod
    def _of(lines: list[Line]) -> DriveGearError:
        settings: dict[str, object] = {
            key: sorted(multiple for multiple, there in lines if there == away)
            for key, away in LISTS.items()
        }
        return DriveGearError(**settings)

    def _gain(self, residuals: Leftover, lines: list[Line]) -> float:
        return residuals.score(self._of(lines), {}).gain

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        teeth = observations.drive_gear_teeth
        assert teeth is not None
        if teeth != round(teeth):
            return []
        return paired_lanes([round(order) for order in self._orders(teeth)], coefficients)

    def real_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[RealLane]:
        teeth = observations.drive_gear_teeth
        if teeth is None or teeth == round(teeth):
            return []
        return paired_real_lanes(self._orders(teeth), coefficients)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        found: dict[str, Parameter] = {}
        names = {0: "", -1: "below_", 1: "above_"}
        for index, (multiple, away) in enumerate(self._lines):
            pair = slice(2 * index, 2 * index + 2)
            cosine, sine = coefficients[pair]
            found |= amplitude_and_phase(
                cosine, sine, covariance[pair, pair], f"multiple_{multiple}_{names[away]}"
            )
        return found
