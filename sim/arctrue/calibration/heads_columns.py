"""Computes the design-matrix columns of every unknown in a calibration of several heads, for each
head.

Let g be the disc's error as a function of its own reading. Head i at the place p_i and the radius
R/ρᵢ reads Rᵢ = θ + aᵢ + g_i(Rᵢ + dᵢ) + m_i(θ). aᵢ is the offset of its counter, and dᵢ = p_i − aᵢ
is the angle by which head i detects the index mark late. Order 1 of g is multiplied by ρᵢ. An axis
at c(θ) = Σ F_k e^{jkθ} + B_k e^{−jkθ} adds m_i = ρᵢ·Im(c·e^{jp_i}), F and B in arcseconds at the
disc's radius. The forward circle of order 1 has the same effect as an eccentric disc and is not a
separate unknown.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import RAD_PER_ARCSEC
from arctrue.calibration.harmonics import powers

Float = NDArray[np.float64]
Integer = NDArray[np.int64]


@dataclass(frozen=True)
class Layout:
    """Order of the columns: disc cosines, disc sines, motion, angles dᵢ, radius ratios ρᵢ."""

    heads: int
    orders: Integer
    motion_orders: tuple[int, ...]

    @property
    def motion_parts(self) -> tuple[tuple[int, int], ...]:
        """Order and sense (+1 forward, −1 backward) of every circle, two columns each."""
        return tuple(
            (order, sense)
            for order in self.motion_orders
            for sense in (1, -1)
            if (order, sense) != (1, 1)
        )

    @property
    def disc(self) -> slice:
        """Columns of the cosines of all orders, then of the sines, arcseconds."""
        return slice(0, 2 * self.orders.size)

    @property
    def motion(self) -> slice:
        """Columns of the real and imaginary part of every circle, arcseconds."""
        return slice(self.disc.stop, self.disc.stop + 2 * len(self.motion_parts))

    @property
    def late(self) -> slice:
        """Columns of dᵢ of heads 2, 3 and 4, arcseconds."""
        return slice(self.motion.stop, self.motion.stop + self.heads - 1)

    @property
    def radius(self) -> slice:
        """Columns of ρᵢ − 1 of heads 2, 3 and 4; for head 1 this value is 0."""
        return slice(self.late.stop, self.late.stop + self.heads - 1)

    @property
    def size(self) -> int:
        """Number of all columns, without the offsets."""
        return int(self.radius.stop)


@dataclass(frozen=True)
class State:
    """Present values of all unknowns of ``layout``, and the offsets aᵢ in radians, (runs, heads).

    ``values``: (layout.size,), in the units of the layout.
    """

    layout: Layout
    values: Float
    offsets_rad: Float

    @property
    def late_rad(self) -> Float:
        """Angles dᵢ by which the heads detect the index late, radians, (heads,); 0 for head 1."""
        return np.concatenate(([0.0], self.values[self.layout.late] * RAD_PER_ARCSEC))

    @property
    def radius_ratios(self) -> Float:
        """Radius ratios ρᵢ of all heads, (heads,)."""
        return np.concatenate(([1.0], 1.0 + self.values[self.layout.radius]))

    def places_rad(self, run: int) -> Float:
        """Return p_i = aᵢ + dᵢ with the offsets of one run, (heads,)."""
        return np.asarray(self.offsets_rad[run] + self.late_rad)

    def of_head(
        self, head: int, run: int, turned: NDArray[np.complex128], angle: Float
    ) -> HeadSees:
        """Return the reading error of one head and its derivatives.

        ``turned``, (n,): e^{jy} of the disc readings y. ``angle``, (n,): true angles in radians.
        """
        layout, number = self.layout, self.layout.orders.size
        ratio = float(self.radius_ratios[head])
        place = float(self.places_rad(run)[head])
        columns = np.zeros((turned.size, layout.size), order="F")
        waves = powers(turned, layout.orders)
        columns[:, :number], columns[:, number : 2 * number] = waves.real, waves.imag
        first = np.flatnonzero(layout.orders == 1)
        ahead = self.values[layout.disc]
        by_radius = (
            columns[:, first] @ ahead[first] + columns[:, first + number] @ (ahead[first + number])
        )
        if ratio != 1.0:
            columns[:, np.concatenate((first, first + number))] *= ratio
        start = layout.motion.start
        around = {k: np.exp(1j * k * angle) for k in layout.motion_orders}
        # The columns are Im(F·e^{j(kθ+p)}) and Im(B·e^{−j(kθ−p)}), for the values 1 and j of F and
        # B.
        for index, (order, sense) in enumerate(layout.motion_parts):
            wave = around[order] if sense == 1 else around[order].conj()
            seen = ratio * wave * np.exp(1j * place)
            columns[:, start + 2 * index] = seen.imag
            columns[:, start + 2 * index + 1] = seen.real
        moved = self.values[layout.motion]
        motion = columns[:, layout.motion] @ moved
        expected = columns[:, layout.disc] @ ahead + motion
        if head:
            cosine, sine = np.split(ahead, 2)
            slope = waves.imag @ (-layout.orders * cosine) + waves.real @ (layout.orders * sine)
            # d m/d p: Im(j·F·e^{…}) turns a sine into a cosine.
            along = columns[:, start + 1 : layout.motion.stop : 2] @ moved[::2] - (
                columns[:, start : layout.motion.stop : 2] @ moved[1::2]
            )
            columns[:, layout.late.start + head - 1] = (slope + along) * RAD_PER_ARCSEC
            columns[:, layout.radius.start + head - 1] = by_radius + motion / ratio
        return HeadSees(columns, expected)


@dataclass(frozen=True)
class HeadSees:
    """Expected reading error of one head (disc plus motion), arcseconds, (n,), and its derivatives
    by every unknown, (n, layout.size)."""

    columns: Float
    expected: Float
