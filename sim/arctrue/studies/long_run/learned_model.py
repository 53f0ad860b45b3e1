"""Uses the first part of a long run to fit a model of the orders that depend on the temperature."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy import stats

from arctrue.base.units import arcsec_per_count
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS, ThermalLanes

Float = NDArray[np.float64]
Complex = NDArray[np.complex128]
FALSE_FINDS = 1e-3
"""Probability that noise alone makes at least one order appear to follow the temperature."""


@dataclass(frozen=True, slots=True)
class LearnedOrder:
    """Order n as a function of the temperature T: c₀ + c₁·(T − T₀), with the reference temperature
    T₀. The real part is the factor of cos nθ, the imaginary part is the factor of sin nθ."""

    order: int
    cold_arcsec: complex
    slope_arcsec_per_k: complex
    u_slope_arcsec_per_k: float
    """Standard uncertainty of the slope's real part, and of its imaginary part."""


def telemetry_orders(telemetry: Sequence[Mapping[str, Any]]) -> tuple[NDArray[np.int64], Complex]:
    """Return turn numbers (t,) and coefficients (t, orders) of all accepted turns.

    If the firmware reported a turn twice because of a further alarm, the turn is returned once.
    """
    by_turn = {int(one["turn"]): one["harmonics"] for one in telemetry if one.get("harmonics")}
    turns = np.array(sorted(by_turn), dtype=np.int64)
    values = np.array(
        [[h[1] * np.exp(-1j * h[2]) for h in by_turn[int(turn)]] for turn in turns],
        dtype=np.complex128,
    )
    return turns, values


def learn(
    turns: NDArray[np.int64], values: Complex, celsius: Float, reference_c: float
) -> list[LearnedOrder]:
    """Fit each order by least squares with a constant, T − T₀ and the turn number as regressors;
    return the orders that follow T.

    ``turns`` (t,), ``values`` (t, orders) and ``celsius`` (t,); ``reference_c`` is T₀. The
    regressor of the turn number absorbs wear and creep, so that these are not attributed to
    temperature. An order follows the temperature if an F test detects its slope. If only noise is
    present, one call in a thousand returns at least one order. Raises ValueError if the temperature
    is constant or a linear function of the turn number.
    """
    warmth = celsius - reference_c
    columns = np.column_stack([np.ones(turns.size), warmth, turns - turns.mean()])
    solution, _, rank, _ = np.linalg.lstsq(columns, values, rcond=None)
    if rank < columns.shape[1]:
        raise ValueError("in these turns the effects of temperature and time are not separable")
    residual = values - columns @ solution
    freedom = turns.size - columns.shape[1]
    sigma = np.sqrt((np.abs(residual) ** 2).sum(axis=0) / (2 * freedom))
    per_sigma = float(np.sqrt(np.linalg.inv(columns.T @ columns)[1, 1]))
    ratio = np.abs(solution[1]) ** 2 / (2.0 * (per_sigma * sigma) ** 2)
    chance = stats.f.sf(ratio, 2, 2 * freedom)
    # The third column is 0 at the mean turn number, so that c₀ is the value at this turn.
    return [
        LearnedOrder(place + 1, solution[0, place], solution[1, place], per_sigma * sigma[place])
        for place in range(values.shape[1])
        if chance[place] < FALSE_FINDS / values.shape[1]
    ]


def as_coefficients(
    learned: Sequence[LearnedOrder], reference_c: float, counts_per_rev: int, lanes: int
) -> Coefficients:
    """Return lanes that follow the temperature, in the form of a coefficient file.

    Raises ValueError if no order follows the temperature, or if the number formats cannot represent
    the lanes.
    """
    if not learned:
        raise ValueError("no order follows the temperature significantly")
    count = arcsec_per_count(counts_per_rev)
    bank = Coefficients.from_harmonics(
        [one.order for one in learned],
        [abs(one.cold_arcsec) / count for one in learned],
        [-np.angle(one.cold_arcsec) for one in learned],
        counts_per_rev,
        lanes,
    )
    slopes = np.zeros((len(learned), 4))
    for place, one in enumerate(learned):
        slopes[place, :2] = one.slope_arcsec_per_k.real, one.slope_arcsec_per_k.imag
    words = np.rint(slopes / count / SLOPE_LSB_COUNTS).astype(np.int64)
    thermal = ThermalLanes(tuple(one.order for one in learned), words, reference_c)
    return Coefficients(
        bank.phase_steps, bank.phase_offsets, bank.amplitudes, bank.offset, counts_per_rev, thermal
    )
