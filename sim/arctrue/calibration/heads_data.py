"""Readings of two to four heads, block by block, and the prior knowledge of a fit to them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from arctrue.base.units import ARCSEC_PER_RAD, RAD_PER_ARCSEC, arcsec_per_count
from arctrue.calibration.capture_check import WholeTurns
from arctrue.calibration.head_separation import NOMINAL_TOLERANCE_ARCSEC, U_DETECTION_DEFAULT_ARCSEC
from arctrue.calibration.heads_columns import Layout, State
from arctrue.calibration.heads_gain import MotionOrders

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

U_PLACE_DEFAULT_ARCSEC = NOMINAL_TOLERANCE_ARCSEC / float(np.sqrt(3.0))
"""Standard uncertainty of a head's place: rectangular distribution over the mounting tolerance."""
U_RADIUS_DEFAULT = 0.1 / float(np.sqrt(3.0)) / 53.975
"""Standard uncertainty of a radius ratio: rectangular distribution of ± 0.1 mm at the radius of the
paper's disc, 53.975 mm."""
_BLOCK = 1 << 13


@dataclass(frozen=True)
class HeadsSettings:
    """The unknowns of the fit, and the standard uncertainties of prior knowledge.

    ``motion``: orders at which the axis may move, or "every"; ``u_place_arcsec``: standard
    uncertainty of a mounted head's place (inf: the data alone determine the places);
    ``u_index_arcsec``: standard uncertainty of the difference between the places where two heads
    detect the mark; ``u_radius``: standard uncertainty of the ratio of a head's radius to the
    disc's, 0: known.
    """

    orders: Integer = field(default_factory=lambda: np.arange(1, 33))
    motion: MotionOrders = ()
    u_place_arcsec: float = U_PLACE_DEFAULT_ARCSEC
    u_index_arcsec: float = U_DETECTION_DEFAULT_ARCSEC
    u_radius: float = U_RADIUS_DEFAULT


class HeadsData:
    """The readings of all runs, block by block."""

    def __init__(
        self, turns: Sequence[WholeTurns], counts_per_rev: int, nominal_places_rad: Float
    ) -> None:
        """Store the readings. Raises ValueError for a run with another number of heads."""
        self.turns = turns
        self.part_of_all = False
        self.counts_per_rev = counts_per_rev
        self.nominal_rad = nominal_places_rad
        self.heads = nominal_places_rad.size
        self.whole_counts: list[list[int]] = []
        """Number of whole turns between a head's counter and head 1's counter, in counts, by run.
        These counts are subtracted, because the counters start at arbitrary turns."""
        unit = arcsec_per_count(counts_per_rev) * RAD_PER_ARCSEC
        for part in turns:
            if len(part.heads) != self.heads:
                raise ValueError(
                    f"run {part.run} has {len(part.heads)} heads, and {self.heads} places are given"
                )
            self.whole_counts.append(
                [
                    counts_per_rev
                    * round((float(np.mean(h - part.heads[0])) * unit - place) / (2.0 * np.pi))
                    for h, place in zip(part.heads, nominal_places_rad.tolist(), strict=True)
                ]
            )

    @property
    def samples(self) -> int:
        """Number of samples of all runs."""
        return sum(part.samples for part in self.turns)

    def thinned(self, most: int, most_order: int) -> HeadsData:
        """Return every k-th sample of each run; ``self`` if k is 1.

        Fewer than twice ``most`` samples remain, unless a turn needs more for four samples in each
        period of its highest order.
        """
        a_turn = min(part.samples // part.turns for part in self.turns)
        step = min(self.samples // most, a_turn // (4 * most_order))
        if step < 2:
            return self
        parts = [
            replace(
                part,
                head1_counts=part.head1_counts[::step],
                head2_counts=part.head2_counts[::step],
                further_counts=tuple(head[::step] for head in part.further_counts),
            )
            for part in self.turns
        ]
        found = HeadsData(parts, self.counts_per_rev, self.nominal_rad)
        found.part_of_all = True
        return found

    def first_state(
        self, settings: HeadsSettings, orders: Integer, motion_orders: tuple[int, ...]
    ) -> State:
        """Return a state with offsets from the means, places as mounted, no disc and no motion."""
        unit = arcsec_per_count(self.counts_per_rev) * RAD_PER_ARCSEC
        apart = np.array(
            [
                [
                    float(np.mean(h - part.heads[0] - turn)) * unit
                    for h, turn in zip(part.heads, whole, strict=True)
                ]
                for part, whole in zip(self.turns, self.whole_counts, strict=True)
            ]
        )
        layout = Layout(self.heads, orders, motion_orders)
        values = np.zeros(layout.size)
        late, _ = late_beforehand(self.nominal_rad, apart.mean(axis=0), settings)
        values[layout.late] = late
        return State(layout, values, apart)

    def state_of(self, orders: Integer, motion_orders: tuple[int, ...], before: State) -> State:
        """Return the values of ``before`` in another layout; columns that are new are 0."""
        layout = Layout(self.heads, orders, motion_orders)
        values = np.zeros(layout.size)
        both, new, old = np.intersect1d(orders, before.layout.orders, return_indices=True)
        if both.size:
            values[new] = before.values[old]
            values[new + orders.size] = before.values[old + before.layout.orders.size]
        values[layout.late] = before.values[before.layout.late]
        values[layout.radius] = before.values[before.layout.radius]
        return State(layout, values, before.offsets_rad)

    def blocks(self) -> Iterator[tuple[int, list[Integer]]]:
        """Yield the run's index and the counts of every head, for each block."""
        for run, part in enumerate(self.turns):
            for start in range(0, part.samples, _BLOCK):
                at = slice(start, min(start + _BLOCK, part.samples))
                whole = self.whole_counts[run]
                yield run, [h[at] - turn for h, turn in zip(part.heads, whole, strict=True)]


def late_beforehand(
    nominal_rad: Float, offsets_rad: Float, settings: HeadsSettings
) -> tuple[Float, float]:
    """Return the prior dᵢ of heads 2, 3 and 4, arcseconds, and the precision of each.

    The mounting gives the value p_i − aᵢ, and the index gives the value 0; the prior is their
    weighted mean.
    """
    by_mounting = (nominal_rad - offsets_rad)[1:] * ARCSEC_PER_RAD
    weight_mounting = precision_of(settings.u_place_arcsec)
    weight_index = precision_of(settings.u_index_arcsec)
    if not np.isfinite(settings.u_place_arcsec):
        # If the prior is infinitely uncertain, the search starts at the mounted places with
        # precision 0.
        return by_mounting, 0.0
    total = weight_mounting + weight_index
    return by_mounting * (weight_mounting / total), total


def precision_of(u: float) -> float:
    """Return the precision 1/u² of an observation; 0 for an infinite u."""
    return 0.0 if np.isinf(u) else 1.0 / max(u, 1e-6) ** 2
