"""Converts a fitted model to coefficients of the gateware; lists the errors that these cannot
correct.

A lane is a circuit of the gateware that adds one harmonic of the reading to the correction. A lane
follows a condition if a modulator (direction, speed, or a word that the host writes) multiplies its
amplitude.
"""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.acceptance import of_speed_feedback
from arctrue.calibration.harmonics import error_arcsec
from arctrue.calibration.selection import significance_factor
from arctrue.gateware.coefficients import ORDER_MAX, STEEPEST_REVERSAL, Coefficients
from arctrue.gateware.extension import (
    FOLLOWED_LANES_MOST,
    REAL_LANES_MOST,
    WIDTH_ONE,
    Conditions,
    Extension,
)
from arctrue.gateware.thermal import ORDERS_MOST, ThermalLanes
from arctrue.generated.number_formats import CLOCK_HZ, LANES_MAX, THERMAL_RANGE_K
from arctrue.workbench.effects.base import ConditionedLane, Effect, RealLane
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.local_errors import local_errors, table_of
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]
OneLane = TypeVar("OneLane", ConditionedLane, RealLane)

SIDEBANDS = (-2, -1, 1, 2)
"""Distances of the orders that the conversion to the reading adds to each order of the true angle.
Eccentricity of amplitude A in radians turns the share n·A/2 of order n into each of the orders
n ± 1."""


USUAL_REVERSAL_WIDTH_DEG = 1.0


@dataclass(frozen=True, slots=True)
class ConditionSettings:
    """Settings for direction and speed in the gateware (generic MODULATORS)."""

    reversal_width_deg: float = USUAL_REVERSAL_WIDTH_DEG
    """After a reversal, the correction changes from one direction to the other over twice this
    angle."""
    dead_zone_counts: int = 4
    nominal_deg_per_s: float | None = None
    """Speed at which the modulator is 1; None: 1.5 times the largest speed in the set."""
    clock_hz: float = CLOCK_HZ
    """Clock of the gateware, whose windows for the speed are counted in clocks."""


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


@dataclass(frozen=True)
class CorrectableLanes:
    """Effects that lanes correct, and their sum as harmonics of the reading."""

    entries: list[tuple[int, ModelEffect, Effect]]
    """Index in the model, entry, and effect of each effect that lanes correct."""
    observations: Observations
    temperature_c: float | None

    def components(self, place: int, coefficients: Float) -> dict[int, Float]:
        """Return cosine and sine of every order, (2,), of the entry with the index ``place`` in
        ``entries``."""
        _, entry, effect = self.entries[place]
        found: dict[int, Float] = {}
        for lane in effect.lanes(coefficients, entry.search, self.observations, self.temperature_c):
            pair = np.array([lane.cosine_arcsec, lane.sine_arcsec])
            found[lane.order] = found.get(lane.order, np.zeros(2)) + pair
        return found

    def of_reading(self) -> list[dict[int, Float]]:
        """Return the harmonics of the reading, cosine and sine of every order, (2,), by entry.

        The true angle of a reading R is the solution θ of R = θ + ε(θ), with the sum ε of all
        entries. An entry at the reading keeps its harmonics; ε(θ) of another entry is sampled at
        equal readings, and its Fourier coefficients are those of its own orders and of the
        ``SIDEBANDS`` of all such entries.
        """
        parts = [
            self.components(place, np.array(entry.coefficients))
            for place, (_, entry, _) in enumerate(self.entries)
        ]
        at_reading = [effect.at_reading for _, _, effect in self.entries]
        own = {
            order
            for part, stays in zip(parts, at_reading, strict=True)
            for order in part
            if not stays and order <= ORDER_MAX
        }
        if not own:
            return parts
        neighbours = {order + step for order in own for step in SIDEBANDS if order}
        wanted = np.array(sorted(own | {one for one in neighbours if 0 < one <= ORDER_MAX}))
        angle_rad = _angle_of_readings(parts, at_reading)
        converted = []
        for part, stays in zip(parts, at_reading, strict=True):
            if stays:
                converted.append(part)
                continue
            spectrum = np.fft.rfft(_sum_arcsec(part, angle_rad)) * (2.0 / angle_rad.size)
            spectrum[0] *= 0.5
            pairs = np.stack([spectrum.real[wanted], -spectrum.imag[wanted]], axis=1)
            beyond = {order: pair for order, pair in part.items() if order > ORDER_MAX}
            converted.append(dict(zip(wanted.tolist(), pairs, strict=True)) | beyond)
        return converted

    def own_orders(self, place: int) -> list[int]:
        """Return the orders of one entry before the conversion to the reading."""
        return list(self.components(place, np.array(self.entries[place][1].coefficients)))

    def uncertainty(self, covariances: Float, parts: list[slice]) -> dict[int, float]:
        """Return the standard uncertainty of a component of every order, by linear propagation."""
        slopes: dict[int, Float] = {}
        for place, (index, entry, _) in enumerate(self.entries):
            for column, unit in enumerate(np.eye(len(entry.coefficients))):
                for order, pair in self.components(place, unit).items():
                    slope = slopes.setdefault(order, np.zeros((2, covariances.shape[0])))
                    slope[:, parts[index].start + column] += pair
        return {
            order: float(np.sqrt(np.trace(slope @ covariances @ slope.T) / 2.0))
            for order, slope in slopes.items()
        }


def _sum_arcsec(part: Mapping[int, Float], angle_rad: Float) -> Float:
    """Return the sum of the harmonics up to ORDER_MAX at angles, in the shape of ``angle_rad``."""
    orders = np.array([order for order in part if order <= ORDER_MAX], dtype=np.int64)
    values = np.array([part[order] for order in orders.tolist()]).reshape(-1, 2)
    return error_arcsec(orders, values.T.ravel(), angle_rad)


def _angle_of_readings(parts: list[dict[int, Float]], at_reading: list[bool]) -> Float:
    """Return the true angles of equally spaced readings of one turn, radians."""
    summed: tuple[dict[int, Float], dict[int, Float]] = ({}, {})
    for part, stays in zip(parts, at_reading, strict=True):
        total = summed[stays]
        for order, pair in part.items():
            total[order] = total.get(order, np.zeros(2)) + pair
    most = max(order for total in summed for order in total if order <= ORDER_MAX)
    # 16 samples a period of a low order, 4 samples of a high one, whose harmonics are small.
    number = 1 << int(np.ceil(np.log2(max(1024, 16 * min(most, 256), 4 * most + 4))))
    reading = np.linspace(0.0, 2.0 * np.pi, number, endpoint=False)
    of_angle, of_reading = summed
    fixed = reading - _sum_arcsec(of_reading, reading) * RAD_PER_ARCSEC
    angle = fixed
    for _ in range(20):
        before = angle
        angle = fixed - _sum_arcsec(of_angle, angle) * RAD_PER_ARCSEC
        if np.max(np.abs(angle - before)) < 1e-10 * RAD_PER_ARCSEC:
            break
    return angle


def correctable_lanes(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    *,
    temperature_c: float | None,
    taken: frozenset[int],
) -> CorrectableLanes:
    """Return the effects that plain lanes correct; ``taken``: indices in the model of the effects
    that are corrected otherwise. Raises ValueError for an effect without coefficients."""
    entries = []
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if effect.compensation != "lanes" or index in taken:
            continue
        if not entry.coefficients:
            raise ValueError(f"{entry.name}: has no coefficients; fit the model first")
        entries.append((index, entry, effect))
    return CorrectableLanes(entries, observations, temperature_c)


@dataclass(frozen=True)
class ReadingHarmonics:
    """Significant orders of the part of ε of head 1 that is a function of the reading."""

    components: dict[int, Float]
    """Cosine and sine of every significant order, (2,), arcseconds."""
    left_out: list[str]
    """Descriptions of the parts of the model that are not a function of the reading, or are not
    significant."""
    warnings: list[str]
    every: dict[int, Float]
    """Cosine and sine of every order, (2,), arcseconds, including the orders that are not
    significant."""
    sidebands: dict[int, Float]
    """Cosine and sine, (2,), arcseconds, of every order that only the conversion to the reading
    adds; ``components`` contains those above one count."""

    def amplitude_arcsec(self, order: int) -> float:
        """Return the amplitude of one order."""
        return float(np.hypot(*self.components[order]))


def harmonics_of_reading(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    *,
    temperature_c: float | None,
    taken: frozenset[int] = frozenset(),
) -> ReadingHarmonics:
    """Return the significant orders of a fitted model that a function of the reading can correct.

    The orders of the conversion to the reading, next to a significant order, are added if they
    exceed one count. The significance of an order is calculated with the covariance of a fit of the
    model to ``observations`` and with the calibration's limit. If the model cannot be fitted to
    ``observations``, every order is kept, with a warning. ``taken``: indices in the model of the
    effects that are corrected otherwise (lanes with a condition, lanes of orders that are not
    integers, the local table). Raises ValueError for a model without coefficients.
    """
    left_out: list[str] = []
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if effect.compensation not in ("reference", "lanes") and index not in taken:
            note = effect.compensation_note or "lanes cannot correct it"
            left_out.append(f"{entry.name}: {note}")
    correctable = correctable_lanes(
        model, observations, effects, temperature_c=temperature_c, taken=taken
    )
    total: dict[int, Float] = {}
    for part in correctable.of_reading():
        for order, pair in part.items():
            total[order] = total.get(order, np.zeros(2)) + pair
    own = {
        order
        for place in range(len(correctable.entries))
        for order in correctable.own_orders(place)
    }
    left_out += [f"order {order} is above {ORDER_MAX}" for order in total if order > ORDER_MAX]
    by_order = {order: total[order] for order in sorted(own) if order <= ORDER_MAX}
    sidebands = {order: pair for order, pair in total.items() if order not in own}
    warnings: list[str] = []
    lacking = _cannot_be_judged(model, observations, effects)
    if lacking:
        warnings.append(f"it is not known whether the lanes are significant: {lacking}")
        quiet: list[int] = []
    else:
        terms = model.terms(effects)
        solution = fit(terms, observations)
        u = correctable.uncertainty(
            solution.covariance, [solution.part(index) for index in range(len(terms))]
        )
        factor = significance_factor(len(by_order))
        quiet = sorted(
            order for order in by_order if float(np.hypot(*by_order[order])) <= factor * u[order]
        )
        if quiet:
            named = ", ".join(map(str, quiet))
            one = "order" if len(quiet) == 1 else "orders"
            left_out.append(f"{one} {named}: not significant, below {factor:.1f} u")
    kept = {order: pair for order, pair in by_order.items() if order not in quiet}
    if observations.counts_per_rev is not None:
        count = arcsec_per_count(observations.counts_per_rev)
        kept |= {
            order: pair
            for order, pair in sidebands.items()
            if np.hypot(*pair) > count and any(order - step in kept for step in SIDEBANDS)
        }
    return ReadingHarmonics(kept, left_out, warnings, by_order, sidebands)


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
    left_out = [text for text in middle.left_out if "not significant" not in text]
    if quiet:
        named = ", ".join(map(str, sorted(quiet)))
        left_out.append(f"orders {named}: not significant within {THERMAL_SPAN_K:g} K")
    harmonics = dataclasses.replace(middle, components=components, left_out=left_out)
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
    """Quantise a fitted model for the gateware; the largest significant orders get lanes.

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
    followed = _FollowedLanes(
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
    owned = _orders_of_waves(followed.orders)
    by_order = {order: np.zeros(2) for order in owned} | found.components
    thermal = dataclasses.replace(
        thermal, harmonics=dataclasses.replace(found, components=by_order)
    )
    found = thermal.harmonics
    beyond_followed, beyond_real = _beyond_the_firmware(model, observations, effects)
    left_out += beyond_followed if conditions is not None else []
    left_out += beyond_real if with_real_orders else []
    if conditions is None:
        left_out += _would_follow(model, observations, effects)
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
    for order in orders[plain_lanes:]:
        if thermal.largest_arcsec(order) == 0.0:
            continue
        left_out.append(
            f"order {order} ({thermal.largest_arcsec(order):.3f}″): no lane left, "
            f"all {lanes} are in use"
        )
    kept = sorted(orders[:plain_lanes])
    phases = [float(np.arctan2(-by_order[order][1], by_order[order][0])) for order in kept]
    sizes = [found.amplitude_arcsec(order) for order in kept]
    count = arcsec_per_count(observations.counts_per_rev)
    coefficients = Coefficients.from_harmonics(
        [*kept, *followed.orders, *[0] * len(real)],
        np.array([*sizes, *followed.sizes_arcsec, *map(_size_arcsec, real)]) / count,
        [*phases, *followed.phases_rad, *map(_phase_rad, real)],
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
    of_orders = [f"order {lane.order:.7g}: {_size_arcsec(lane):.4g}″" for lane in real]
    return Export(
        coefficients,
        kept,
        sizes,
        left_out,
        found.warnings,
        followed.words(),
        in_table,
        of_orders,
    )


def lanes_of_real_orders(
    model: Model,
    observations: Observations,
    effects: Mapping[str, type[Effect]],
    most: int = REAL_LANES_MOST,
) -> dict[int, list[RealLane]]:
    """Return the ``most`` largest harmonics at orders that are not integers, by the index of the
    effect in the model. The phases refer to the unwrapped angle of the set, which is zero at the
    beginning of turn 0.
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
    return _largest(found, _size_arcsec, most)


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


def _size_arcsec(lane: RealLane) -> float:
    return float(np.hypot(lane.cosine_arcsec, lane.sine_arcsec))


def _phase_rad(lane: RealLane) -> float:
    return float(np.arctan2(-lane.sine_arcsec, lane.cosine_arcsec))


WORDS = ("word_a", "word_b")
"""Modulators whose value the host writes; the first column that a lane follows gets the first of
them."""


def _orders_of_waves(orders: Iterable[int]) -> list[int]:
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
    return factor * float(np.hypot(one.lane.cosine_arcsec, one.lane.sine_arcsec))


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


def without_plain_lanes(
    model: Model, effects: Mapping[str, type[Effect]], conditioned: Iterable[int]
) -> frozenset[int]:
    """Return those effects with lanes that follow a condition, by their index in the model, that
    have no plain lanes."""
    return frozenset(
        index
        for index in conditioned
        if model.effects[index].effect(effects).compensation != "lanes"
    )


def _without_lanes(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> list[str]:
    """Give the reason for each effect of a kind that lanes correct, if it has no lanes."""
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


def _beyond_the_firmware(
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
            f"order {one.order:.7g} ({_size_arcsec(one):.3f}″): the firmware holds at most "
            f"{REAL_LANES_MOST} lanes of orders that are not integers"
            for one in real
        ],
    )


def _would_follow(
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
class _FollowedLanes:
    """Lanes that follow a condition, with the scales of the gateware."""

    lanes: list[ConditionedLane]
    settings: ConditionSettings | None
    observations: Observations

    @property
    def orders(self) -> list[int]:
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
        return [
            self._factor(one) * float(np.hypot(one.lane.cosine_arcsec, one.lane.sine_arcsec))
            for one in self.lanes
        ]

    @property
    def phases_rad(self) -> list[float]:
        return [
            float(np.arctan2(-one.lane.sine_arcsec, one.lane.cosine_arcsec)) for one in self.lanes
        ]

    def words(self) -> list[str]:
        """Describe each lane in one line."""
        return [
            f"order {one.lane.order} × {one.column or one.condition.replace('_', ' ')}: "
            f"{size:.4g}″{self._at_full(one)}"
            for one, size in zip(self.lanes, self.sizes_arcsec, strict=True)
        ]

    def extension(self, first_lane: int) -> Extension:
        """Make the coefficient file's extension for these lanes, which follow ``first_lane`` other
        lanes. Raises ValueError if the slope after a reversal exceeds STEEPEST_REVERSAL."""
        assert self.settings is not None
        assert self.observations.counts_per_rev is not None
        width_counts = self.settings.reversal_width_deg / 360.0 * self.observations.counts_per_rev
        reversal = sum(
            size
            for one, size in zip(self.lanes, self.sizes_arcsec, strict=True)
            if one.condition == "direction"
        )
        slope = reversal / arcsec_per_count(self.observations.counts_per_rev) / width_counts
        if slope >= STEEPEST_REVERSAL:
            needed = slope / STEEPEST_REVERSAL * self.settings.reversal_width_deg
            raise ValueError(
                f"--reversal-width {self.settings.reversal_width_deg:g}: after a reversal the "
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


def _cannot_be_judged(
    model: Model, observations: Observations, effects: Mapping[str, type[Effect]]
) -> str:
    """Return the reason why the model cannot be fitted to this set; an empty string if it can."""
    for entry in model.effects:
        effect = entry.effect(effects)
        lacking = effect.missing(observations)
        if lacking:
            return f"{entry.name} cannot be fitted to this set, which lacks {'; '.join(lacking)}"
        if set(entry.search) != {item.name for item in effect.search}:
            return f"{entry.name} has no values of its search parameters; fit the model first"
        if entry.coefficients and entry.columns != effect.column_names(observations):
            return f"{entry.name} was stored for other columns than this set has"
    return ""
