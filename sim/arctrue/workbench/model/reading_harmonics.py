"""Sums the effects of a model that plain lanes correct, as harmonics of the reading."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.harmonics import error_arcsec
from arctrue.calibration.selection import significance_factor
from arctrue.gateware.lane_words import ORDER_MAX
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.observations import Observations

Float = NDArray[np.float64]

SIDEBANDS = (-2, -1, 1, 2)
"""Distances of the orders that the conversion to the reading adds to each order of the true angle.
Eccentricity of amplitude A in radians turns the share n·A/2 of order n into each of the orders
n ± 1."""


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
        entries. An entry at the reading keeps its harmonics. ε(θ) of another entry is sampled at
        equally spaced readings; it gets Fourier coefficients of the orders of all such entries and
        of their ``SIDEBANDS``.
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
    notes: dict[int, str]
    """Descriptions of the effects that are not a function of the reading, by index in the model."""
    above: list[str]
    """Descriptions of the orders above ORDER_MAX."""
    not_significant: list[str]
    """Descriptions of the orders that are not significant."""
    warnings: list[str]
    every: dict[int, Float]
    """Cosine and sine of every order, (2,), arcseconds, including the orders that are not
    significant."""
    sidebands: dict[int, Float]
    """Cosine and sine, (2,), arcseconds, of every order that only the conversion to the reading
    adds; ``components`` contains those above one count."""

    @property
    def left_out(self) -> list[str]:
        """Descriptions of the parts of the model that no lane corrects."""
        return [*self.notes.values(), *self.above, *self.not_significant]

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
    notes: dict[int, str] = {}
    for index, entry in enumerate(model.effects):
        effect = entry.effect(effects)
        if effect.compensation not in ("reference", "lanes") and index not in taken:
            note = effect.compensation_note or "lanes cannot correct it"
            notes[index] = f"{entry.name}: {note}"
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
    above = [f"order {order} is above {ORDER_MAX}" for order in total if order > ORDER_MAX]
    not_significant: list[str] = []
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
            not_significant.append(f"{one} {named}: not significant, below {factor:.1f} u")
    kept = {order: pair for order, pair in by_order.items() if order not in quiet}
    if observations.counts_per_rev is not None:
        count = arcsec_per_count(observations.counts_per_rev)
        kept |= {
            order: pair
            for order, pair in sidebands.items()
            if np.hypot(*pair) > count and any(order - step in kept for step in SIDEBANDS)
        }
    return ReadingHarmonics(kept, notes, above, not_significant, warnings, by_order, sidebands)


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
