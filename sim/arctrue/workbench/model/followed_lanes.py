"""Finds the lanes of a model that follow a condition or have an order that is not an integer.

A lane follows a condition if a modulator of the gateware (direction, speed, or a word that the host
writes) multiplies its amplitude.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from typing import TypeVar

import numpy as np

from arctrue.base.units import arcsec_per_count
from arctrue.gateware.coefficient_bounds import STEEPEST_REVERSAL
from arctrue.gateware.coefficients import Extension
from arctrue.gateware.extension import FOLLOWED_LANES_MOST, REAL_LANES_MOST, WIDTH_ONE, Conditions
from arctrue.gateware.lane_words import ORDER_MAX
from arctrue.generated.number_formats import CLOCK_HZ, LANES_MAX
from arctrue.workbench.effects.base import ConditionedLane, Effect, Lane, RealLane
from arctrue.workbench.model.model import Model
from arctrue.workbench.observations import Observations

OneLane = TypeVar("OneLane", ConditionedLane, RealLane)


USUAL_REVERSAL_WIDTH_DEG = 1.0
"""Default of :attr:`ConditionSettings.reversal_width_deg`, a choice."""


@dataclass(frozen=True, slots=True)
class ConditionSettings:
    """Settings for direction and speed in the gateware (generic MODULATORS)."""

    reversal_width_deg: float | None = None
    """After a reversal, the correction changes from one direction to the other over twice this
    angle; None: half the width of the largest lane with a width, or USUAL_REVERSAL_WIDTH_DEG."""
    dead_zone_counts: int = 4
    nominal_deg_per_s: float | None = None
    """Speed at which the modulator is 1; None: 1.5 times the largest speed in the set."""
    clock_hz: float = CLOCK_HZ
    """Clock of the gateware, whose windows for the speed are counted in clocks."""


def lanes_of_real_orders(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    most: int = REAL_LANES_MOST,
) -> dict[int, list[RealLane]]:
    """Return the ``most`` harmonics of non-integer order with the largest amplitudes, by the index
    of the effect in the model. The phases refer to the unwrapped angle of the set, which is zero at
    the beginning of turn 0.
    """
    found = {}
    for index, entry in enumerate(model.effects):
        lanes = (
            entry.effect(effects).real_lanes(
                np.array(entry.coefficients), entry.search, observations
            )
            if entry.coefficients
            else []
        )
        if lanes and all(lane.order <= ORDER_MAX for lane in lanes):
            found[index] = lanes
    return _largest(found, size_arcsec, most)


def _largest(
    found: Mapping[int, list[OneLane]], size: Callable[[OneLane], float], most: int
) -> dict[int, list[OneLane]]:
    """Return at most ``most`` lanes, those of the largest size, by the index of the effect."""
    ranked = sorted(
        ((index, lane) for index, lanes in found.items() for lane in lanes),
        key=lambda one: -size(one[1]),
    )
    kept = ranked[:most]
    return {
        index: held
        for index, lanes in found.items()
        if (held := [lane for lane in lanes if (index, lane) in kept])
    }


def size_arcsec(lane: Lane | RealLane) -> float:
    """Return the amplitude of a lane."""
    return float(np.hypot(lane.cosine_arcsec, lane.sine_arcsec))


def phase_rad(lane: Lane | RealLane) -> float:
    """Return the phase of a lane."""
    return float(np.arctan2(-lane.sine_arcsec, lane.cosine_arcsec))


WORDS = ("word_a", "word_b")
"""Modulators whose value the host writes; the first column that a lane follows gets the first of
them."""


def orders_of_waves(orders: Iterable[int]) -> list[int]:
    """Return the orders of lanes that follow a condition, without order 0.

    For each of these orders the file also contains a plain lane, which follows no condition.
    Without this lane, the device's calibration would fit the order and use a free lane for it; that
    lane would then contain the condition's contribution to the calibrated turn. If no lane of the
    file is free, the calibration cannot do this, so that a plain lane of 0 may be omitted.
    """
    return sorted({order for order in orders if order > 0})


def lanes_by_condition(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    most: int = FOLLOWED_LANES_MOST,
) -> dict[int, list[ConditionedLane]]:
    """Return the ``most`` largest lanes with a condition that correct effects, by the index of the
    effect in the model. The gateware has two registers (words) for columns of the set; an effect
    that needs a third column is omitted.
    """
    found = {}
    columns: set[tuple[str, float]] = set()
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if not entry.coefficients:
            continue
        coefficients = np.array(entry.coefficients)
        lanes = effect.conditioned_lanes(coefficients, entry.search, observations)
        wanted = columns | {
            (one.column, one.column_zero) for one in lanes if one.condition == "column"
        }
        fits = len(wanted) <= len(WORDS)
        if lanes and fits and all(one.lane.order <= ORDER_MAX for one in lanes):
            found[index] = lanes
            columns = wanted
    return _largest(found, lambda one: _largest_arcsec(one, observations), most)


def _largest_arcsec(one: ConditionedLane, observations: Observations) -> float:
    """Return the amplitude of a lane with a condition at the largest condition in the set."""
    speed = _fastest_rad_s(observations) or float(np.radians(USUAL_NOMINAL_DEG_PER_S))
    factors = {"direction": 1.0, "speed": speed, "speed_squared": speed**2}
    factor = factors.get(one.condition) or _column_most(one, observations)
    return factor * size_arcsec(one.lane)


def _fastest_rad_s(observations: Observations) -> float:
    """Return the largest speed in the set; 0 for a set without a speed."""
    fastest = [
        float(np.abs(rows.speed_rad_s).max())
        for rows in (observations.capture, observations.every_reference_row)
        if rows is not None and rows.speed_rad_s is not None and rows.speed_rad_s.size
    ]
    return max(fastest, default=0.0)


def _column_most(one: ConditionedLane, observations: Observations) -> float:
    """Return the largest deviation of a column from its zero in the set."""
    channels = (observations.capture, observations.every_reference_row)
    most = [
        float(np.nanmax(np.abs(rows.conditions[one.column] - one.column_zero)))
        for rows in channels
        if rows is not None and one.column in rows.conditions
    ]
    return max(most, default=0.0)


def beyond_the_firmware(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> tuple[list[str], list[str]]:
    """Describe the lanes with a condition, and the lanes of real orders, for which the firmware has
    no place."""
    every = model, observations, effects, LANES_MAX * len(model.effects)

    def beyond(all_of: dict[int, list[OneLane]], kept: dict[int, list[OneLane]]) -> list[OneLane]:
        return [
            lane
            for index, lanes in all_of.items()
            for lane in lanes
            if lane not in kept.get(index, [])
        ]

    followed = beyond(lanes_by_condition(*every), lanes_by_condition(model, observations, effects))
    real = beyond(lanes_of_real_orders(*every), lanes_of_real_orders(model, observations, effects))
    return (
        [
            f"order {one.lane.order} × {one.column or one.condition.replace('_', ' ')} "
            f"({_largest_arcsec(one, observations):.3f}″): the firmware holds at most "
            f"{FOLLOWED_LANES_MOST} lanes that follow a condition"
            for one in followed
        ],
        [
            f"order {one.order:.7g} ({size_arcsec(one):.3f}″): the firmware holds at most "
            f"{REAL_LANES_MOST} lanes of orders that are not integers"
            for one in real
        ],
    )


def would_follow(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> list[str]:
    """Name the effects that a gateware with MODULATORS can correct, and the option that does it."""
    names = [
        model.effects[index].name for index in lanes_by_condition(model, observations, effects)
    ]
    if not names:
        return []
    return [
        f"{', '.join(names)}: a gateware with MODULATORS = true can correct it, with --modulators"
    ]


@dataclass(frozen=True)
class FollowedLanes:
    """Lanes that follow a condition, with the scales of the gateware."""

    lanes: list[ConditionedLane]
    settings: ConditionSettings | None
    observations: Observations

    @property
    def orders(self) -> list[int]:
        """Orders of the lanes."""
        return [one.lane.order for one in self.lanes]

    @property
    def nominal_rad_s(self) -> float:
        """Return the speed at which the modulator of the speed is 1, ω₀."""
        assert self.settings is not None
        if self.settings.nominal_deg_per_s is not None:
            return float(np.radians(self.settings.nominal_deg_per_s))
        fastest = _fastest_rad_s(self.observations)
        return 1.5 * fastest or float(np.radians(USUAL_NOMINAL_DEG_PER_S))

    def _factor(self, one: ConditionedLane) -> float:
        """Return the value of the condition at which its modulator is 1."""
        if one.condition == "direction":
            return 1.0
        if one.condition == "column":
            return self._column_scale(one)
        return self.nominal_rad_s ** (1 if one.condition == "speed" else 2)

    @property
    def columns(self) -> list[tuple[str, float]]:
        """Return name and zero of each column that the lanes follow, in the order of WORDS."""
        named = ((one.column, one.column_zero) for one in self.lanes if one.condition == "column")
        return list(dict.fromkeys(named))

    def _column_scale(self, one: ConditionedLane) -> float:
        """Return the deviation of a column from its zero at which the modulator is 1: 1.5 times the
        largest deviation in the set."""
        return float(f"{1.5 * _column_most(one, self.observations):.3g}") or 1.0

    def _modulator(self, one: ConditionedLane) -> str:
        """Return the modulator's name in the coefficient file."""
        if one.condition != "column":
            return one.condition
        return WORDS[self.columns.index((one.column, one.column_zero))]

    def _at_full(self, one: ConditionedLane) -> str:
        """Describe the condition at which the modulator is 1."""
        if one.condition == "direction":
            return ""
        if one.condition == "column":
            word = self._modulator(one).removeprefix("word_")
            return (
                f" at {one.column} = {one.column_zero + self._column_scale(one):g}, where word "
                f"{word} is 1; it is 0 at {one.column_zero:g}"
            )
        return f" at {np.degrees(self.nominal_rad_s):.4g}°/s"

    @property
    def sizes_arcsec(self) -> list[float]:
        """Amplitudes of the lanes where their modulators are 1."""
        return [self._factor(one) * size_arcsec(one.lane) for one in self.lanes]

    @property
    def phases_rad(self) -> list[float]:
        """Phases of the lanes."""
        return [phase_rad(one.lane) for one in self.lanes]

    def words(self) -> list[str]:
        """Describe each lane in one line."""
        return [
            f"order {one.lane.order} × {one.column or one.condition.replace('_', ' ')}: "
            f"{size:.4g}″{self._at_full(one)}"
            for one, size in zip(self.lanes, self.sizes_arcsec, strict=True)
        ]

    def scales(self) -> list[str]:
        """Describe each lane whose word the host writes; the text states the scale of the word."""
        described = zip(self.lanes, self.words(), strict=True)
        return [text for one, text in described if one.condition == "column"]

    @property
    def reversal_width_deg(self) -> float:
        """W, half the travel over which the correction changes after a reversal."""
        assert self.settings is not None
        if self.settings.reversal_width_deg is not None:
            return self.settings.reversal_width_deg
        widths = [
            (size, one.width_deg)
            for one, size in zip(self.lanes, self.sizes_arcsec, strict=True)
            if one.width_deg is not None
        ]
        return 0.5 * max(widths)[1] if widths else USUAL_REVERSAL_WIDTH_DEG

    def extension(self, first_lane: int) -> Extension:
        """Make the coefficient file's extension for these lanes, which come after ``first_lane``
        other lanes. Raises ValueError if the slope after a reversal exceeds STEEPEST_REVERSAL."""
        assert self.settings is not None
        assert self.observations.counts_per_rev is not None
        width_deg = self.reversal_width_deg
        width_counts = width_deg / 360.0 * self.observations.counts_per_rev
        reversal = sum(
            size
            for one, size in zip(self.lanes, self.sizes_arcsec, strict=True)
            if one.condition == "direction"
        )
        slope = reversal / arcsec_per_count(self.observations.counts_per_rev) / width_counts
        if slope >= STEEPEST_REVERSAL:
            needed = slope / STEEPEST_REVERSAL * width_deg
            raise ValueError(
                f"--reversal-width {width_deg:g}: after a reversal the "
                f"correction would change by {slope:.3g} counts per count; the limit is "
                f"{STEEPEST_REVERSAL:g}: choose more than {needed:.3g}°"
            )
        names = tuple((first_lane + at, self._modulator(one)) for at, one in enumerate(self.lanes))
        conditions = Conditions(
            max(round(width_counts * WIDTH_ONE), 1),
            self.settings.dead_zone_counts,
            float(f"{np.degrees(self.nominal_rad_s):.9g}"),
        )
        return Extension(conditions=conditions, modulators=names)


USUAL_NOMINAL_DEG_PER_S = 90.0
"""Nominal speed for a set without a speed; such a set has no lane that follows the speed."""
