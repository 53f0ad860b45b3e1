"""Composes effects that are not in the catalogue from parts.

A product consists of a condition (temperature, speed, time, ...), a wave (an order, the electrical
phase, or nothing) and the frame to which it is fixed (the disc, the stator, a head, the reference).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from typing import Literal, Self, get_args
from weakref import WeakKeyDictionary

import numpy as np
from numpy.typing import NDArray

from arctrue.workbench.effects.axis_motion import (
    capture_motion,
    motion_of_waves,
    reference_motion,
)
from arctrue.workbench.effects.base import (
    Columns,
    ConditionedLane,
    Effect,
    FitContext,
    Lane,
    Nonlinear,
    OfWaves,
    Parameter,
    RealLane,
    Wave,
    amplitude_and_phase,
    paired_lanes,
    paired_real_lanes,
)
from arctrue.workbench.effects.part_conditions import (
    ALWAYS,
    BY_GATEWARE,
    FORMS,
    LAG,
    SEARCHED_FORMS,
    TEMPERATURE,
    Condition,
    Float,
    Rows,
    column_condition,
    condition_named,
    form_condition,
    run_condition,
    times_direction,
)
from arctrue.workbench.numeric.harmonics import disc_difference, harmonic_columns, harmonic_names
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

Frame = Literal["disc", "stator", "head1", "head2", "head3", "head4", "reference"]
MOST_WAVES = 16
"""Largest number of waves that are kept for a set of rows: a search multiplies the waves of the
best orders, in five frames, by one condition after another."""
_WAVES: WeakKeyDictionary[Rows, dict[Hashable, Columns]] = WeakKeyDictionary()
FRAME_OF_HEAD: Mapping[int, Frame] = {1: "head1", 2: "head2", 3: "head3", 4: "head4"}


def _share(head: int, rows: CaptureRows) -> float:
    """Return the factor with which one head's own error enters Rᵢ − R₁ on rows of head i."""
    return -1.0 if head == 1 else float(rows.head == head)


class ProductOfParts(Effect):
    """Adds a condition (a factor of each row) times a wave that is fixed to a frame (disc, stator,
    head or reference)."""

    name = "product_of_parts"
    physics = "The settings state the parts of this effect; its physical cause is not known yet."
    equation = "condition × wave, in one frame"
    source = "found in the residuals"
    needs_settings = True
    compensation = "lanes"
    compensation_note = (
        "on disc, stator or head 1, steady or in proportion to the temperature; in proportion to "
        "direction, speed, speed squared or a column it needs MODULATORS"
    )
    defaults = {
        "condition": "",
        "time_constant_s": 0.0,
        "each_run": False,
        "column": "",
        "column_zero": 0.0,
        "from_run": 0,
        "orders": [],
        "fixed_to": "disc",
        "electrical_head": 0,
        "turned_by": "",
    }
    parameter_units = {"size": "arcsec", "amplitude": "arcsec", "phase": "deg"}
    capture_sees = "as its frame says"
    reference_sees = "as its frame says"
    separated_by = "its condition and its order"
    next_measurement = "change the condition alone and measure again"
    plausible = "unknown"

    condition: Condition
    orders: tuple[float, ...]
    """Multiples of the angle (or of the electrical phase); () for a constant."""
    frame: Frame
    electrical_head: int | None
    turned_by: str
    """Column in degrees that is added to the angle of the wave, with a minus in front if it is
    subtracted; empty for none."""

    def __init__(self, **settings: object) -> None:
        """Check and store the settings.

        One of four settings selects the factor. ``condition``: a name of CONDITIONS.
        ``time_constant_s`` > 0: exp(−t/τ), with t from the start of each run (``each_run``) or of
        the set. ``column``: a column minus ``column_zero``. ``from_run``: 0 before this run of the
        reference, 1 from this run on.

        With ``column``, ``condition`` may be "direction": the column times the direction of the
        reference. It may also be a name of FORMS or SEARCHED_FORMS (a function of the column minus
        ``column_zero``), or LAG (the column after a lag of ``time_constant_s``); with these, the
        column may be ``temperature_c``.

        ``orders``: an empty list is a constant. ``electrical_head``: 1 to 4 for multiples of that
        head's electrical phase. ``turned_by``: a column in degrees that is added to the angle of
        the orders of a reference, or, with a minus in front of its name, subtracted. Raises
        ValueError for settings that define no product.
        """
        super().__init__(**settings)
        said = self.settings
        constant_s, column = float(str(said["time_constant_s"])), str(said["column"])
        by_direction = bool(column) and said["condition"] == "direction"
        forms = {*FORMS, *SEARCHED_FORMS, LAG}
        form = str(said["condition"]) if column and said["condition"] in forms else ""
        condition = bool(said["condition"]) and not by_direction and not form
        from_run = int(str(said["from_run"]))
        settles = constant_s != 0.0 and form != LAG
        if sum([condition, settles, bool(column), from_run != 0]) > 1:
            self._refuse("condition", "only one of condition, time_constant_s, column and from_run")
        if constant_s < 0.0:
            self._refuse("time_constant_s", "seconds above 0, or 0 for no settling")
        if form == LAG and constant_s == 0.0:
            self._refuse("time_constant_s", "seconds above 0 for the lag of a column")
        if form:
            zero = float(str(said["column_zero"]))
            self.condition = form_condition(column, form, zero, constant_s or None)
        elif column:
            self.condition = column_condition(column, float(str(said["column_zero"])))
            if by_direction:
                self.condition = times_direction(self.condition)
        elif from_run:
            self.condition = run_condition(from_run)
        else:
            self.condition = condition_named(
                str(said["condition"]), constant_s or None, bool(said["each_run"])
            )
        orders = said["orders"]
        if not isinstance(orders, Sequence) or any(
            isinstance(order, bool) or not isinstance(order, int | float) or not order > 0
            for order in orders
        ):
            self._refuse("orders", "a list of numbers above 0")
        if said["fixed_to"] not in get_args(Frame):
            self._refuse("fixed_to", f"one of {', '.join(get_args(Frame))}")
        if said["electrical_head"] not in (0, *FRAME_OF_HEAD):
            self._refuse("electrical_head", "1 to 4, or 0 for the angle")
        self.orders = tuple(float(order) for order in orders)  # type: ignore[attr-defined]
        self.frame = said["fixed_to"]  # type: ignore[assignment]
        self.electrical_head = int(str(said["electrical_head"])) or None
        self.turned_by = str(said["turned_by"])
        if self.turned_by and (self.frame != "reference" or not self.orders):
            self._refuse("turned_by", "a column only with orders that are fixed to the reference")
        reason = self._why_no_lanes()
        if reason:
            self.compensation = "none"  # type: ignore[misc, assignment]
            self.compensation_note = reason  # type: ignore[misc]

    def _why_no_lanes(self) -> str:
        """Return the reason why the firmware loads no lane for a product with such orders and such
        a condition. The empty string means no reason, or one that ``compensation_note`` states."""
        if self.condition is ALWAYS:
            return ""
        if self.condition.form:
            return "the firmware loads no lane that follows a function or a lag of a column"
        if self.condition.by_direction:
            what = "the time" if self.condition.column is None else "a column"
            return f"the firmware loads no lane that follows {what} and the direction"
        if self.condition.from_run is not None:
            return "no lane changes between two runs"
        if any(order != round(order) for order in self.orders):
            return (
                "the firmware loads no lane that has both an order that is not an integer and a "
                "condition"
            )
        if self.condition is TEMPERATURE and not self.orders:
            return "a lane that follows the temperature has an order of 1 or more in the firmware"
        return ""

    @property
    def _head(self) -> int | None:
        """Return the head of the frame; None if the error does not belong to a single head."""
        return next((head for head, name in FRAME_OF_HEAD.items() if name == self.frame), None)

    def _refuse(self, key: str, expected: str) -> None:
        raise ValueError(
            f"effect {self.name}: setting {key}: expected {expected}, found {self.settings[key]!r}"
        )

    @classmethod
    def of(
        cls,
        condition: Condition,
        orders: tuple[float, ...],
        frame: Frame,
        electrical_head: int | None = None,
    ) -> Self:
        """Make the product of a condition, a wave and a frame."""
        product = cls(
            **condition.settings,
            orders=list(orders),
            fixed_to=frame,
            electrical_head=electrical_head or 0,
        )
        # The given object replaces the equal condition that the settings define: two settlings
        # exp(−t/τ) with the same time constant are different objects.
        product.condition = condition
        return product

    def missing(self, observations: Observations) -> list[str]:
        channels = (observations.capture, observations.reference)
        rows = observations.reference
        if self.turned_by and (rows is None or self._turned_name not in rows.conditions):
            return [f"the column {self._turned_name} in the reference"]
        if any(rows is not None and self.condition.values(rows) is not None for rows in channels):
            return []
        what = "condition" if self.condition.column is None else "column"
        return [f"the {what} {self.condition.part}"]

    @property
    def parts(self) -> list[str]:
        """Return the public names of the parts."""
        names = [self.condition.part] if self.condition.part else []
        if self.condition.by_direction:
            names.insert(0, "direction")
        if self.electrical_head is not None:
            return [*names, f"electrical:head{self.electrical_head}"]
        names += [f"order:{order:g}" for order in self.orders]
        if self.turned_by:
            names.append(f"turned:{self.turned_by}")
        return [*names, self.frame]

    @property
    def unconditional_orders(self) -> bool:
        plain = not self.condition.part and self.electrical_head is None and not self.turned_by
        return plain and bool(self.orders)

    @property
    def _turned_name(self) -> str:
        """Return the name of the column of ``turned_by``, without its sign."""
        return self.turned_by.removeprefix("-")

    def _turned_rad(self, rows: ReferenceRows) -> Float | None:
        """Return the angle of the wave, which a column turns; None without this column."""
        turned = rows.conditions.get(self._turned_name)
        if turned is None:
            return None
        # A wave of half as many periods as stations has the same phase, modulo half a period, at
        # all targets. At the true angles, the error would give it a second independent column.
        return rows.target_rad + (-1.0 if self.turned_by[0] == "-" else 1.0) * np.radians(turned)

    def column_names(self, observations: Observations) -> list[str]:
        if not self.orders:
            return ["size"]
        if self.electrical_head is None and self.frame == "stator":
            return harmonic_names(self.orders, "x ") + harmonic_names(self.orders, "y ")
        return harmonic_names(self.orders)

    def _kept_wave(self, rows: Rows, wave: Callable[[], Columns]) -> Columns:
        """Return the result of ``wave``; it is kept, because many conditions have the same wave."""
        kept = _WAVES.setdefault(rows, {})
        key = (self.frame, self.electrical_head, tuple(self.orders))
        if key not in kept:
            while len(kept) >= MOST_WAVES:
                del kept[next(iter(kept))]
            kept[key] = wave()
        return kept[key]

    def _wave(self, angle_rad: Float, sign: float = 1.0) -> Columns:
        if not self.orders:
            return np.full((angle_rad.size, 1), sign)
        return sign * harmonic_columns(angle_rad, self.orders)

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        factor = self.condition.values(rows)
        if factor is None or self.frame == "reference":
            return None
        if self.electrical_head is not None and self._phase(rows) is None:
            return None
        return factor[:, np.newaxis] * self._kept_wave(rows, lambda: self._capture_wave(rows))

    def of_waves(self, rows: CaptureRows) -> OfWaves | None:
        """Return the columns of the frames stator and head as multiples of the same wave."""
        factor = self.condition.values(rows)
        elsewhere = self.frame == "reference" or (self.frame == "disc" and self.orders)
        if rows.heads > 2 or factor is None or self.electrical_head is not None or elsewhere:
            return None
        width = 2 * len(self.orders) or 1
        angle_rad, orders = rows.angle_rad, tuple(self.orders)

        def columns() -> Columns:
            wave = harmonic_columns(angle_rad, orders) if orders else np.ones((angle_rad.size, 1))
            return factor[:, np.newaxis] * wave

        if self.frame == "stator":
            factors = motion_of_waves(rows.head_separation_rad, width)
        else:
            factors = np.eye(width) * (1.0 if self._head is None else _share(self._head, rows))
        return OfWaves([Wave((id(self.condition), orders), width, columns)], factors)

    def _phase(self, rows: CaptureRows) -> Float | None:
        return rows.electrical1_rad if self.electrical_head == 1 else rows.electrical2_rad

    def _capture_wave(self, rows: CaptureRows) -> Columns:
        if self.electrical_head is not None:
            # Rows of Rᵢ − R₁ have the phases of heads 1 and i. If ``electrical_head`` is neither 1
            # nor i, the factor is 0, and the phase has no influence.
            phase = self._phase(rows)
            assert phase is not None
            return self._wave(phase, _share(self.electrical_head, rows))
        if self.frame == "disc" and self.orders:
            return disc_difference(rows.disc1_rad, rows.disc2_rad, self.orders)
        if self.frame == "stator":
            return capture_motion(rows, self.orders)
        return self._wave(rows.angle_rad, 1.0 if self._head is None else _share(self._head, rows))

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        factor = self.condition.values(rows)
        further = (self._head or 1) > 1 or (self.electrical_head or 1) > 1
        if factor is None or further:
            return None
        if self.electrical_head == 1:
            if rows.electrical1_rad is None:
                return None
            wave = self._wave(rows.electrical1_rad)
        elif self.turned_by:
            turned_rad = self._turned_rad(rows)
            if turned_rad is None:
                return None
            wave = self._wave(turned_rad)
        elif self.frame == "stator":
            wave = reference_motion(rows, self.orders)
        else:
            wave = self._wave(rows.angle_rad)
        return factor[:, np.newaxis] * wave

    def electrical_orders(self, observations: Observations) -> list[float]:
        if self.electrical_head is None:
            return []
        lines = observations.grating_lines or 0
        return [order * lines for order in self.orders for _ in ("cos", "sin")]

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        unit = "arcsec" + (f"/{self.condition.unit}" if self.condition.unit else "")
        if not self.orders:
            sigma = float(np.sqrt(max(covariance[0, 0], 0.0)))
            return {"size": Parameter(float(coefficients[0]), sigma, unit)}
        if self.frame == "stator" and self.electrical_head is None:
            width = 2 * len(self.orders)
            alpha = observations.head_separation_rad
            mixing = np.hstack([np.sin(alpha) * np.eye(width), (np.cos(alpha) - 1) * np.eye(width)])
            coefficients, covariance = mixing @ coefficients, mixing @ covariance @ mixing.T
        found: dict[str, Parameter] = {}
        for index, order in enumerate(self.orders):
            pair = slice(2 * index, 2 * index + 2)
            cosine, sine = coefficients[pair]
            prefix = "" if len(self.orders) == 1 else f"order_{order:g}_"
            found |= amplitude_and_phase(cosine, sine, covariance[pair, pair], prefix, unit)
        rows = observations.reference
        columns: Columns | None = None
        if self.turned_by and len(self.orders) > 1 and rows is not None:
            columns = self.reference_columns(rows, nonlinear, FitContext())
        if columns is not None:
            prediction = columns @ coefficients
            rms = float(np.sqrt(np.mean(prediction**2)))
            slope = columns.T @ prediction / (prediction.size * max(rms, 1e-300))
            sigma = float(np.sqrt(np.abs(slope @ covariance @ slope)))
            found = {"rms": Parameter(rms, sigma, unit)} | found
        return found

    def conditioned_lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> list[ConditionedLane]:
        column = self.condition.column or ""
        condition = "column" if column else BY_GATEWARE.get(self.condition.words)
        if condition is None or self.condition.by_direction or self.condition.form:
            return []
        zero = self.condition.column_zero
        if not self.orders:
            if self.frame == "reference" or (self._head or 1) > 1:
                return []
            constant = Lane(0, float(coefficients[0]), 0.0)
            return [ConditionedLane(condition, constant, column, zero)]
        lanes = self._waves(coefficients, observations)
        return [ConditionedLane(condition, lane, column, zero) for lane in lanes]

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        factor = 1.0
        if not self._waves(coefficients, observations):
            return []
        if self.condition is TEMPERATURE:
            if temperature_c is None:
                raise ValueError(f"{self.name}: state the temperature with --temperature")
            factor = temperature_c - observations.reference_temperature_c
        elif self.condition is not ALWAYS:
            return []
        return self._waves(factor * coefficients, observations)

    def real_lanes(
        self, coefficients: Float, nonlinear: Nonlinear, observations: Observations
    ) -> list[RealLane]:
        all_whole = all(order == round(order) for order in self.orders)
        elsewhere = self.frame == "reference" or (self._head or 1) > 1
        if self.condition is not ALWAYS or self.electrical_head is not None or elsewhere:
            return []
        if all_whole or not self.orders:
            return []
        if self.frame == "stator":
            coefficients = coefficients[2 * len(self.orders) :]
        return paired_real_lanes(self.orders, coefficients)

    def _waves(self, coefficients: Float, observations: Observations) -> list[Lane]:
        """Return the harmonics of head 1's error that the product causes where the condition is
        1."""
        orders = [round(order) for order in self.orders if order == round(order)]
        if self.electrical_head == 1 and observations.grating_lines is not None:
            orders = [order * observations.grating_lines for order in orders]
        elif self.electrical_head is not None or self.frame == "reference" or (self._head or 1) > 1:
            return []
        if len(orders) != len(self.orders):
            return []
        if self.frame == "stator" and self.electrical_head is None:
            # The motion y is the error of head 1; the columns of y come after the columns of x.
            coefficients = coefficients[2 * len(orders) :]
        return paired_lanes(orders, coefficients)

    def describe(self, parameters: Mapping[str, Parameter]) -> str:
        """Describe the product in words, for example ``(T − T₀) × order 2, disc-fixed,
        0.31″/K``."""
        changes = self.condition.from_run is not None
        words = [self.condition.words] if self.condition.words and not changes else []
        if self.electrical_head is not None:
            multiples = ", ".join(f"{order:g}" for order in self.orders)
            words.append(f"electrical phase of head {self.electrical_head} × {multiples}")
        elif self.orders:
            words.append(self._orders_in_words())
        frames = {
            "disc": "disc-fixed",
            "stator": "stator-fixed",
            "reference": "reference only",
            **{name: f"head {head} only" for head, name in FRAME_OF_HEAD.items()},
        }
        size = parameters.get("amplitude") or parameters.get("size")
        rms = parameters.get("rms")
        if size is None and rms is not None:
            return f"{' × '.join(words)}, {frames[self.frame]}, {rms.value:.2g}″ RMS"
        if changes and size is not None:
            return (
                f"{' × '.join(words) or 'the zero'} changes by {abs(size.value):.2g}″ between two "
                f"runs, at the start of run {self.condition.from_run}, {frames[self.frame]}"
            )
        text = " × ".join(words) if words else "constant"
        if self.electrical_head is None:
            text += f", {frames[self.frame]}"
        if size is not None:
            unit = size.unit.replace("arcsec", "″")
            # The sign shows whether the error rises or falls with the user's column.
            falls = bool(self.condition.column) and not self.orders and size.value < 0.0
            text += f", {'−' if falls else ''}{abs(size.value):.2g}{unit}"
        return text

    def _orders_in_words(self) -> str:
        """Return the orders, and the angle to which they belong if a column turns it."""
        several = len(self.orders) > 2 and bool(np.all(np.diff(self.orders) == 1.0))
        if not self.turned_by:
            return "order " + ", ".join(f"{order:g}" for order in self.orders)
        ends = f"orders {self.orders[0]:g} to {self.orders[-1]:g}"
        text = ends if several else "order " + ", ".join(f"{order:g}" for order in self.orders)
        sign = "−" if self.turned_by[0] == "-" else "+"
        return f"{text} of target_deg {sign} {self._turned_name}"
