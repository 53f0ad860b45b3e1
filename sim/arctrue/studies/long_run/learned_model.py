"""What the first part of a long run teaches of the orders that follow the temperature."""

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
"""Chance that noise alone makes any order follow the temperature."""


@dataclass(frozen=True, slots=True)
class LearnedOrder:
    """One order as c₀ + c₁·(T − T₀); real part: of cos nθ, imaginary part: of sin nθ."""

    order: int
    cold_arcsec: complex
    slope_arcsec_per_k: complex
    u_slope_arcsec_per_k: float
    """Of each component."""


def told_orders(told: Sequence[Mapping[str, Any]]) -> tuple[NDArray[np.int64], Complex]:
    """Turn numbers (t,) and coefficients (t, orders) of all turns that were not refused.

    A turn that the firmware told twice, with a further alarm, counts once.
    """
    by_turn = {int(one["turn"]): one["harmonics"] for one in told if one.get("harmonics")}
    turns = np.array(sorted(by_turn), dtype=np.int64)
    values = np.array(
        [[h[1] * np.exp(-1j * h[2]) for h in by_turn[int(turn)]] for turn in turns],
        dtype=np.complex128,
    )
    return turns, values


def learn(
    turns: NDArray[np.int64], values: Complex, celsius: Float, reference_c: float
) -> list[LearnedOrder]:
    """The orders that follow the temperature, by least squares over 1, T − T₀ and the turn number.

    The turn number takes what wears or creeps, so that it does not count as heat. ``turns`` (t,),
    ``values`` (t, orders) and ``celsius`` (t,). An order is learned where an F test finds its
    slope: in one of a thousand such fits noise alone would bring in any. Raises ValueError where
    the temperature rises with the turn number alone.
    """
    warmth = celsius - reference_c
    columns = np.column_stack([np.ones(turns.size), warmth, turns - turns.mean()])
    solution, _, rank, _ = np.linalg.lstsq(columns, values, rcond=None)
    if rank < columns.shape[1]:
        raise ValueError("the temperature of these turns cannot be told from time passing")
    residual = values - columns @ solution
    freedom = turns.size - columns.shape[1]
    sigma = np.sqrt((np.abs(residual) ** 2).sum(axis=0) / (2 * freedom))
    per_sigma = float(np.sqrt(np.linalg.inv(columns.T @ columns)[1, 1]))
    ratio = np.abs(solution[1]) ** 2 / (2.0 * (per_sigma * sigma) ** 2)
    chance = stats.f.sf(ratio, 2, 2 * freedom)
    # The middle of the turns is where the third column is 0: c₀ holds there.
    return [
        LearnedOrder(place + 1, solution[0, place], solution[1, place], per_sigma * sigma[place])
        for place in range(values.shape[1])
        if chance[place] < FALSE_FINDS / values.shape[1]
    ]


def as_coefficients(
    learned: Sequence[LearnedOrder], reference_c: float, counts_per_rev: int, lanes: int
) -> Coefficients:
    """Lanes that follow the temperature, in the form of a coefficient file.

    Raises ValueError for none, and for what the formats cannot hold.
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
