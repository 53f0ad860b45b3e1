"""Any number of heads by least squares: the disc, and the motion of the axis where 4 heads see it.

Head h at the stator angle β reads R_h = θ − β + g(R_h) + m_β(θ) from the index mark, with the
disc's error g as a function of its own reading. A radial motion of order k is seen by it as
P e^{j(kθ + β)} + Q e^{j(kθ − β)} (real part). θ is unknown in every sample: the mean over the heads
is taken off both sides, which is the least-squares solution for it.

Three heads cannot tell motion from disc: at one order 1, e^{jβ} and e^{−jβ} already span all that
three readings can show. Four can.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD
from arctrue.calibration.harmonics import powers
from arctrue.studies.methods.method import Method, of_harmonics
from arctrue.studies.methods.normal_equations import NormalEquations
from arctrue.studies.methods.world import BLIND_ORDER, Correction, World

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

MOTION_ORDERS = np.arange(2, 9)
"""Of a bearing; order 1 of the axis is not different from an eccentric disc."""


def harmonics_of_heads(
    world: World, places_deg: Sequence[float], motion_orders: Integer
) -> tuple[Integer, Float]:
    """Orders and values of head 1's whole error, disc and motion, as a function of its reading."""
    places = -np.radians(np.asarray(places_deg, dtype=np.float64))
    orders = world.settings.orders
    number, moved = orders.size, motion_orders.size
    heads = places.size
    sums = NormalEquations(2 * number + 4 * moved + heads - 1)
    for counts in world.turns(places.tolist()):
        reading = counts * world.count_rad
        observed = (reading + places[:, None]) * ARCSEC_PER_RAD
        blocks = [
            _columns(reading[head], reading[0], places[head], orders, motion_orders)
            for head in range(heads)
        ]
        mean = sum(blocks) / heads
        for head in range(heads):
            own = np.full((reading.shape[1], heads - 1), -1.0 / heads)
            if head:
                own[:, head - 1] += 1.0
            sums.add(np.hstack([blocks[head] - mean, own]), observed[head] - observed.mean(axis=0))
    found = sums.solved()
    values = found[: 2 * number].copy()
    # Head 1 stands at β = 0: it sees P + Q.
    motion = found[2 * number : 2 * number + 4 * moved].reshape(4, moved)
    at = np.searchsorted(orders, motion_orders)
    values[at] += motion[0] + motion[2]
    values[at + number] += motion[1] + motion[3]
    return orders, values


def _columns(
    reading: Float, table: Float, place: float, orders: Integer, motion_orders: Integer
) -> Float:
    """Cosines and sines of the disc's orders, then of P and Q, ``(samples, columns)``."""
    first = np.exp(1j * reading)
    disc = np.hstack(
        [powers(first, orders[orders != BLIND_ORDER]), np.exp(1j * BLIND_ORDER * reading)[:, None]]
    )
    if motion_orders.size == 0:
        return np.hstack([disc.real, disc.imag])
    around = np.exp(1j * np.multiply.outer(table, motion_orders.astype(np.float64)))
    forward, backward = around * np.exp(1j * place), around * np.exp(-1j * place)
    return np.hstack(
        [disc.real, disc.imag, forward.real, forward.imag, backward.real, backward.imag]
    )


def least_squares_of(name: str, places_deg: Sequence[float], *, motion: bool) -> Method:
    """The method with heads at ``places_deg`` after head 1 (0, 33, …)."""
    heads = len(places_deg)
    orders = MOTION_ORDERS if motion else np.zeros(0, dtype=np.int64)

    def run(world: World) -> Correction:
        return of_harmonics(*harmonics_of_heads(world, places_deg, orders))

    named = ", ".join(f"{place:g}°" for place in places_deg)
    return Method(
        name,
        f"{heads} heads, least squares" + (", with the axis' motion" if motion else ""),
        "Geckeler et al. [9]; Zhao et al. [14]" if motion else "Geckeler et al. [8, 9]",
        heads,
        f"heads at {named}, one index mark",
        "no order up to 128" + ("" if motion else "; radial motion counts as disc"),
        run,
    )
