"""Simulates the table: an axis, a disc on it, heads that read the disc, and causes of errors."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from arctrue.table.cause import GEOMETRY, READING, Cause, acts_on, refuse_unhonoured
from arctrue.table.conditions import conditions_of
from arctrue.table.head import Head
from arctrue.table.state import TableState

DISC_RADIUS_M = 107.95e-3 / 2
"""Radius of the graduation of a MicroE PurePrecision disc (section 4 of the paper; docs/errata.md
discusses it)."""
HEAD_SEPARATION_RAD = float(np.deg2rad(33.0))
"""Head separation α of docs/architecture.md, "Head geometry"."""
GRATING_LINES = 16384
"""Number of lines of the paper's disc."""

TURN_RAD = 2 * np.pi


def two_heads(
    radius_m: float = DISC_RADIUS_M, separation_rad: float = HEAD_SEPARATION_RAD
) -> tuple[Head, Head]:
    """Return head 1 at the stator angle 0 and head 2 at −α: docs/architecture.md, "Head geometry".

    Parameters
    ----------
    radius_m : float
        Distance of both heads from the axis, metres.
    separation_rad : float
        α, radians.

    Returns
    -------
    tuple of Head
        Both heads.
    """
    return Head.on_circle(radius_m, 0.0), Head.on_circle(radius_m, -separation_rad)


HEAD_PLACES_DEG: Mapping[int, tuple[float, ...]] = {
    2: (0.0, 33.0),
    3: (0.0, 33.0, 223.5),
    4: (0.0, 33.0, 162.5, 300.5),
}
"""Angles from head 1 to each head, by the number of heads; head 2 is at its place in the paper. The
third of three heads stands at the place that minimises the largest noise gain of orders 1 to 64,
among the places at which the mean of the heads has less noise than one head. docs/methods.md
explains the places of four heads."""


def heads_at(
    places_rad: Sequence[float],
    radii_m: Sequence[float] | None = None,
    late_counts: Sequence[int] | None = None,
) -> tuple[Head, ...]:
    """Return heads at the stator angles −p, where p is the place of each head relative to head 1.

    Parameters
    ----------
    places_rad : sequence of float
        Place of each head, radians.
    radii_m : sequence of float, optional
        Distance of each head from the axis, metres; None: the disc's radius.
    late_counts : sequence of int, optional
        Delay of each head's index mark, counts; None: none.

    Returns
    -------
    tuple of Head
        The heads in the order of their places.

    Raises
    ------
    ValueError
        If the sequences differ in length.
    """
    radii = [DISC_RADIUS_M] * len(places_rad) if radii_m is None else radii_m
    late = [0] * len(places_rad) if late_counts is None else late_counts
    return tuple(
        Head.on_circle(radius, -place, counts)
        for place, radius, counts in zip(places_rad, radii, late, strict=True)
    )


HEADS = (*two_heads(), *heads_at(np.deg2rad(HEAD_PLACES_DEG[4]).tolist())[2:])
"""The two heads of the paper, and heads 3 and 4 for a table with four heads."""


@dataclass(frozen=True, slots=True)
class RotaryTable:
    """A disc on an axis, read by heads, with the exact geometry of the plane.

    Most tables have two heads; the gateware supports at most four. At the true angle θ the disc
    centre is at C = axis + e^{jθ}·disc shift. The ray from C through a head at H meets the
    graduation at the disc angle g = θ − arg(H − C); the lines there state the angle g + γ(g). Each
    head counts from the index mark on the disc. With the heads of :func:`two_heads` this gives R₁ =
    θ + ε(θ) and R₂ = θ + α + ε(θ + α).

    The interpolator gives ``counts_per_rev`` counts a turn; a count changes where the reading
    passes a whole number (``"floor"``) or a half (``"nearest"``). ``noise_rad`` is the standard
    deviation of white noise on the reading of each head; captures and edges use it.
    """

    heads: tuple[Head, ...]
    """The heads, one or more; the gateware supports two to four."""
    causes: tuple[Cause, ...] = ()
    """Causes of errors, in the order in which they are applied."""
    counts_per_rev: int = 1 << 24
    """Counts a turn, a multiple of 4."""
    rounding: Literal["floor", "nearest"] = "floor"
    """Condition of a change of the count: the reading passes a whole number (``"floor"``) or a half
    (``"nearest"``)."""
    noise_rad: float = 0.0
    """Standard deviation of white noise on each reading, radians."""
    index_mark_rad: float = 0.0
    """Disc angle of the index mark."""
    index_width_counts: int = 1
    """Number of counts for which Z is high."""

    def __post_init__(self) -> None:
        """Raise ValueError for a table that cannot be built."""
        if self.counts_per_rev < 4 or self.counts_per_rev % 4:
            raise ValueError(
                f"a graduation gives a multiple of 4 counts a turn, found {self.counts_per_rev}"
            )
        if not 1 <= self.index_width_counts < self.counts_per_rev:
            raise ValueError(
                f"the index is 1 to {self.counts_per_rev - 1} counts wide, "
                f"found {self.index_width_counts}"
            )
        for cause in self.causes:
            if getattr(cause, "head", 0) >= len(self.heads):
                raise ValueError(
                    f"{type(cause).__name__} acts on head {cause.head + 1}, "  # type: ignore[attr-defined]
                    f"the table has {len(self.heads)}"
                )
        if self.noise_rad < 0:
            raise ValueError(f"noise is a standard deviation and not negative: {self.noise_rad}")

    @property
    def count_rad(self) -> float:
        """Angle of one count, radians."""
        return TURN_RAD / self.counts_per_rev

    def disc_angle_rad(self, head: int, state: TableState) -> NDArray[np.float64]:
        """Return the disc angle under a head.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray
            Disc angle, not wrapped, radians, shape (n,).
        """
        axis: NDArray[np.complex128] = np.zeros(state.angle_rad.shape, dtype=np.complex128)
        disc = axis.copy()
        point = axis + self.heads[head].point_m
        for cause in self.causes:
            axis += cause.axis_shift_m(state)
            disc += cause.disc_shift_m(state)
            point += cause.head_shift_m(head, state)
        ray = point - (axis + np.exp(1j * state.angle_rad) * disc)
        # The angle of the ray is measured from the head's own direction, so that this angle never
        # wraps.
        nominal = self.heads[head].angle_rad
        off_nominal: NDArray[np.float64] = np.angle(ray * np.exp(-1j * nominal))
        return state.angle_rad - nominal - off_nominal

    def _disc_reading_rad(
        self, disc_angle_rad: NDArray[np.float64], state: TableState
    ) -> NDArray[np.float64]:
        reading = disc_angle_rad.copy()
        for cause in self.causes:
            reading += cause.graduation_error_rad(disc_angle_rad, state)
        return reading

    def index_count(self, head: int) -> int:
        """Return the count of the graduation at which a head detects the index mark.

        Parameters
        ----------
        head : int
            Number of the head, from 0.

        Returns
        -------
        int
            Counts.
        """
        mark = np.array([self.index_mark_rad])
        reading = self._disc_reading_rad(mark, TableState.at_rest(mark))
        counts = self.round_counts(reading / self.count_rad)
        return int(counts[0]) + self.heads[head].index_offset_counts

    def reading_rad(self, head: int, state: TableState) -> NDArray[np.float64]:
        """Return the continuous reading of a head from the index mark, without noise.

        A delayed reading is the reading at an earlier time, when the angle was smaller by delay ×
        speed. This is exact at constant speed; on a ramp the error is acceleration × delay²/2.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        state : TableState
            Instants at which the quantity is requested, shape (n,).

        Returns
        -------
        ndarray
            Reading, not wrapped, radians, shape (n,).
        """
        timed = [cause for cause in self.causes if acts_on(cause) - GEOMETRY]
        if timed:
            conditions = conditions_of(state)
            late_s = sum(cause.sampling_delay_s(head) for cause in timed)
            turn = sum(
                (np.asarray(cause.disc_turn_rad(conditions)) for cause in timed),
                start=-late_s * conditions.speed_rad_s,
            )
            state = replace(
                conditions,
                time_s=conditions.time_s - late_s,
                since_run_start_s=conditions.since_run_start_s - late_s,
                angle_rad=conditions.angle_rad + turn,
            )
        reading = self._disc_reading_rad(self.disc_angle_rad(head, state), state)
        lines = reading.copy()
        for cause in self.causes:
            reading += cause.signal_error_rad(head, lines, state)
        for cause in timed:
            reading += cause.gained_counts(head, conditions) * self.count_rad
        return reading - self.index_count(head) * self.count_rad

    def round_counts(self, reading_counts: NDArray[np.float64]) -> NDArray[np.int64]:
        """Round a continuous reading to whole counts, by the table's rule.

        Parameters
        ----------
        reading_counts : ndarray
            Readings, counts, shape (n,).

        Returns
        -------
        ndarray
            Whole counts, shape (n,).
        """
        half = 0.5 if self.rounding == "nearest" else 0.0
        return np.floor(reading_counts + half).astype(np.int64)

    def counts(
        self, head: int, state: TableState, random: np.random.Generator | None = None
    ) -> NDArray[np.int64]:
        """Return the counts of a head's counter from the index mark.

        Parameters
        ----------
        head : int
            Number of the head, from 0.
        state : TableState
            Instants at which the quantity is requested, shape (n,).
        random : numpy.random.Generator, optional
            Source of the noise ``noise_rad``; None: no noise.

        Returns
        -------
        ndarray
            Counts, not wrapped, shape (n,).

        Raises
        ------
        UnhonouredCauseError
            If a cause acts on something other than the reading, for example by missing rows, an
            error of the instrument, or noise of its own.
        """
        refuse_unhonoured(self.causes, READING, "a counter")
        reading = self.reading_rad(head, state) / self.count_rad
        if random is not None and self.noise_rad:
            reading += random.normal(0.0, self.noise_rad / self.count_rad, reading.shape)
        return self.round_counts(reading)
