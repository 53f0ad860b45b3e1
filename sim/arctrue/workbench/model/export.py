"""Converts a fitted model to coefficients of the gateware; lists the errors that these cannot
correct.

A lane is a circuit of the gateware that adds one harmonic of the reading to the correction.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import arcsec_per_count
from arctrue.calibration.acceptance import of_speed_feedback
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.thermal import ORDERS_MOST, ThermalLanes
from arctrue.generated.number_formats import THERMAL_RANGE_K
from arctrue.workbench.effects.base import ConditionedLane, Effect
from arctrue.workbench.model.followed_lanes import (
    ConditionSettings,
    FollowedLanes,
    beyond_the_firmware,
    lanes_by_condition,
    lanes_of_real_orders,
    orders_of_waves,
    phase_rad,
    size_arcsec,
    would_follow,
)
from arctrue.workbench.model.local_errors import local_errors, table_of
from arctrue.workbench.model.model import Model
from arctrue.workbench.model.reading_harmonics import ReadingHarmonics, harmonics_of_reading
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]


@dataclass(frozen=True)
class Export:
    """Coefficients, and descriptions of the errors that they do not correct."""

    coefficients: Coefficients
    orders: list[int]
    amplitudes_arcsec: list[float]
    left_out: list[str]
    warnings: list[str]
    followed: list[str] = field(default_factory=list)
    """Descriptions of the lanes that follow a condition."""
    local: list[str] = field(default_factory=list)
    """Descriptions of the errors that the local table corrects."""
    real: list[str] = field(default_factory=list)
    """Descriptions of the lanes of real orders, which need not be integers."""
    scales: list[str] = field(default_factory=list)
    """Descriptions of the followed lanes whose words the host writes; they state the scale."""
    without_lane: list[str] = field(default_factory=list)
    """Descriptions of the orders for which no lane is left; ``left_out`` contains them too."""


@dataclass(frozen=True)
class _Thermal:
    """Cosine and sine of each order of the reading at T₀, and their temperature coefficients."""

    harmonics: ReadingHarmonics
    slopes_arcsec: dict[int, Float]
    """Cosine and sine per kelvin, and per kelvin squared, (4,), by order."""

    def largest_arcsec(self, order: int) -> float:
        """Return the largest of the amplitudes at T₀ and at THERMAL_SPAN_K below and above it."""
        slopes = self.slopes_arcsec.get(order, np.zeros(4))
        cold = self.harmonics.components[order]
        return max(
            float(np.hypot(*(cold + slopes[:2] * warmth + slopes[2:] * warmth**2)))
            for warmth in (-THERMAL_SPAN_K, 0.0, THERMAL_SPAN_K)
        )


THERMAL_SPAN_K = 5.0
"""Difference from T₀ at which the polynomial in T equals the model."""


LEAST_CHANGE_COUNTS = 0.1
"""The lane of an order has no temperature coefficients if the order changes by less than this, in
counts, from T₀ to THERMAL_SPAN_K below or above T₀.
"""


def follows_temperature(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> bool:
    """Tell whether lanes of the model change with the temperature."""
    reference_c = observations.reference_temperature_c
    for entry in model.effects:
        effect = entry.effect(effects)
        if effect.compensation != "lanes" or not entry.coefficients:
            continue
        cold, warm = (
            effect.lanes(np.array(entry.coefficients), entry.search, observations, celsius)
            for celsius in (reference_c, reference_c + THERMAL_SPAN_K)
        )
        if cold != warm:
            return True
    return False


def _with_temperature(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    taken: frozenset[int],
) -> _Thermal:
    """Evaluate the model at T₀ and at THERMAL_SPAN_K below and above T₀. An order is kept if it is
    significant at one of these temperatures."""
    reference_c = observations.reference_temperature_c
    count = arcsec_per_count(observations.counts_per_rev or 0)
    cold, middle, warm = (
        harmonics_of_reading(
            model, observations, effects, temperature_c=reference_c + step, taken=taken
        )
        for step in (-THERMAL_SPAN_K, 0.0, THERMAL_SPAN_K)
    )
    components: dict[int, Float] = {}
    slopes: dict[int, Float] = {}
    for order in sorted({*cold.components, *middle.components, *warm.components}):
        below, at, above = (
            found.every[order] if order in found.every else found.sidebands[order]
            for found in (cold, middle, warm)
        )
        components[order] = at
        slope = (above - below) / (2.0 * THERMAL_SPAN_K)
        curve = (above + below - 2.0 * at) / (2.0 * THERMAL_SPAN_K**2)
        # The conversion to the reading alone can change an order a little with the temperature;
        # this does not justify a temperature coefficient.
        if max(np.hypot(*(below - at)), np.hypot(*(above - at))) >= LEAST_CHANGE_COUNTS * count:
            slopes[order] = np.concatenate([slope, curve])
    quiet = set(middle.every) - set(components)
    named = ", ".join(map(str, sorted(quiet)))
    words = [f"orders {named}: not significant within {THERMAL_SPAN_K:g} K"] if quiet else []
    harmonics = dataclasses.replace(middle, components=components, not_significant=words)
    return _Thermal(harmonics, slopes)


def export_model(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    *,
    lanes: int,
    temperature_c: float | None,
    sensor_time_constant_s: float = 0.0,
    range_c: tuple[float, float] | None = None,
    conditions: ConditionSettings | None = None,
    with_local_table: bool = False,
    with_real_orders: bool = False,
) -> Export:
    """Quantise a fitted model for the gateware; the significant orders with the largest amplitudes
    get lanes.

    Without ``temperature_c`` the lanes that change with the temperature follow the table's
    thermometer, which lags by ``sensor_time_constant_s``: the firmware computes them, within
    ``range_c`` (None: THERMAL_RANGE_K to each side of T₀, and the whole range of the set). With
    ``conditions`` lanes follow direction and speed, and the coefficients need a gateware with
    MODULATORS. ``with_local_table``: errors at one place of the turn go into a table, which needs a
    gateware with LOCAL_TABLE. ``with_real_orders``: harmonics at orders that are not integers get
    lanes, which need a gateware with REAL_ORDERS. Raises ValueError for a model without
    coefficients, a set without counts per turn, fewer lanes than conditions and real orders need,
    a correction that changes too steeply after a reversal, or lanes that would make the speed
    unstable.
    """
    if observations.counts_per_rev is None:
        raise ValueError(
            "table.counts_per_rev is missing in the set; the coefficients are in counts"
        )
    conditioned: dict[int, list[ConditionedLane]] = {}
    if conditions is not None:
        conditioned = lanes_by_condition(model, observations, effects)
    followed = FollowedLanes(
        [lane for entry in conditioned.values() for lane in entry], conditions, observations
    )
    local = local_errors(model, effects)
    of_real_order = lanes_of_real_orders(model, observations, effects)
    real = [lane for entry in of_real_order.values() for lane in entry if with_real_orders]
    # The lanes of an effect may include both plain lanes and lanes with a condition.
    taken = without_plain_lanes(model, effects, conditioned) | {*local, *of_real_order}
    if temperature_c is None and follows_temperature(model, observations, effects):
        thermal = _with_temperature(model, observations, effects, taken)
    else:
        found = harmonics_of_reading(
            model, observations, effects, temperature_c=temperature_c, taken=taken
        )
        thermal = _Thermal(found, {})
    found = thermal.harmonics
    left_out = list(found.left_out)
    owned = orders_of_waves(followed.orders)
    by_order = {order: np.zeros(2) for order in owned} | found.components
    thermal = dataclasses.replace(
        thermal, harmonics=dataclasses.replace(found, components=by_order)
    )
    found = thermal.harmonics
    beyond_followed, beyond_real = beyond_the_firmware(model, observations, effects)
    left_out += beyond_followed if conditions is not None else []
    left_out += beyond_real if with_real_orders else []
    if conditions is None:
        left_out += would_follow(model, observations, effects)
    if local and not with_local_table:
        names = ", ".join(model.effects[index].name for index in local)
        left_out.append(
            f"{names}: a gateware with LOCAL_TABLE = true can correct it, with --local-table"
        )
    if of_real_order and not with_real_orders:
        names = ", ".join(model.effects[index].name for index in of_real_order)
        left_out.append(
            f"{names}: a gateware with REAL_ORDERS = true can correct it, with --real-orders"
        )
    left_out += _without_lanes(model, observations, effects)
    if len(followed.lanes) + len(real) > lanes:
        raise ValueError(
            f"{len(followed.lanes)} lanes follow a condition and {len(real)} have a real order, "
            f"but the gateware has only {lanes} lanes"
        )
    orders = sorted(by_order, key=lambda order: -thermal.largest_arcsec(order))
    plain_lanes = lanes - len(followed.lanes) - len(real)
    without_lane = [
        f"order {order} ({thermal.largest_arcsec(order):.3f}″): no lane left, "
        f"all {lanes} are in use"
        for order in orders[plain_lanes:]
        if thermal.largest_arcsec(order) != 0.0
    ]
    left_out += without_lane
    kept = sorted(orders[:plain_lanes])
    phases = [float(np.arctan2(-by_order[order][1], by_order[order][0])) for order in kept]
    sizes = [found.amplitude_arcsec(order) for order in kept]
    count = arcsec_per_count(observations.counts_per_rev)
    coefficients = Coefficients.from_harmonics(
        [*kept, *followed.orders, *[0] * len(real)],
        np.array([*sizes, *followed.sizes_arcsec, *map(size_arcsec, real)]) / count,
        [*phases, *followed.phases_rad, *map(phase_rad, real)],
        observations.counts_per_rev,
        lanes,
    )
    if followed.lanes:
        coefficients = dataclasses.replace(coefficients, extension=followed.extension(len(kept)))
        assert conditions is not None
        for objection in of_speed_feedback(coefficients, conditions.clock_hz):
            raise ValueError(objection)
    if real:
        first = len(kept) + len(followed.orders)
        coefficients = coefficients.with_real_orders(
            {first + place: lane.order for place, lane in enumerate(real)}
        )
    if local and with_local_table:
        table = table_of(list(local.values()), observations.counts_per_rev)
        extension = coefficients.extension or Extension()
        coefficients = dataclasses.replace(
            coefficients, extension=dataclasses.replace(extension, local_table=table)
        )
    following = [order for order in orders[:plain_lanes] if order in thermal.slopes_arcsec]
    for order in following[ORDERS_MOST:]:
        left_out.append(
            f"order {order} does not follow the temperature: at most {ORDERS_MOST} orders can"
        )
    if following:
        coefficients = dataclasses.replace(
            coefficients,
            thermal=ThermalLanes.from_slopes(
                {order: thermal.slopes_arcsec[order] / count for order in following[:ORDERS_MOST]},
                observations.reference_temperature_c,
                sensor_time_constant_s,
                range_c or _range_of(observations),
            ),
        )
    in_table = [
        f"{model.effects[index].name} at {np.degrees(one.place_rad):.4g}°"
        for index, one in local.items()
        if with_local_table
    ]
    of_orders = [f"order {lane.order:.7g}: {size_arcsec(lane):.4g}″" for lane in real]
    return Export(
        coefficients,
        kept,
        sizes,
        left_out,
        found.warnings,
        followed.words(),
        in_table,
        of_orders,
        followed.scales(),
        without_lane,
    )


def without_plain_lanes(
    model: Model, effects: Mapping[str, type[Effect]], conditioned: Iterable[int]
) -> frozenset[int]:
    """Return the indices in the model of the effects that have lanes with a condition, but no plain
    lanes."""
    return frozenset(
        index
        for index in conditioned
        if model.effects[index].effect(effects).compensation != "lanes"
    )


def _without_lanes(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> list[str]:
    """Return the reason for each effect that has no lanes although lanes correct effects of its
    kind."""
    others = {
        *lanes_by_condition(model, observations, effects),
        *lanes_of_real_orders(model, observations, effects),
        *local_errors(model, effects),
    }
    found = []
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if effect.compensation != "lanes" or index in others or not any(entry.coefficients):
            continue
        warm_c = observations.reference_temperature_c + THERMAL_SPAN_K
        if not effect.lanes(np.array(entry.coefficients), entry.search, observations, warm_c):
            found.append(f"{entry.name}: {effect.compensation_note or 'no lane can correct it'}")
    return found


def _range_of(observations: Observations) -> tuple[float, float]:
    """Return the smallest temperature range that contains T₀ ± THERMAL_RANGE_K and all temperatures
    of the set."""
    reference_c = observations.reference_temperature_c
    seen = [reference_c - THERMAL_RANGE_K, reference_c + THERMAL_RANGE_K]
    for rows in (observations.capture, observations.every_reference_row):
        if rows is not None and rows.temperature_c is not None:
            known = rows.temperature_c[np.isfinite(rows.temperature_c)]
            seen += [float(known.min()), float(known.max())] if known.size else []
    return min(seen), max(seen)
