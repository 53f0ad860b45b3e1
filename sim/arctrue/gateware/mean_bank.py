"""What the gateware holds for the weighted mean of two to four heads, and what it puts out.

    θ = r_s + Σwᵢ·(rᵢ − r_s) − E(r_s), rᵢ = Rᵢ − oᵢ,

with the carrier s, weights wᵢ in s1.16 whose sum is 1, offsets oᵢ in u24.4 counts and the lanes of
E as in :mod:`arctrue.gateware.coefficients`.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.mean_set import OFFSET_FRACTION, WEIGHT_FRACTION, MeanSet

Float = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class MeanBank:
    """One set of run-time words: carrier, weights, offsets and lanes, which change together.

    ``carrier``: 1 to the number of heads; ``weights``: int32 (heads,), s1.16, Σ = 2¹⁶;
    ``offsets``: uint32 (heads,), u24.4 counts, below one turn; ``lanes``: E as a function of
    r_s. ``missing``: the head that has no part, 1 to the number of heads; None: all have.

    Raises ValueError for a word that its format cannot hold, or weights with another sum.
    """

    carrier: int
    weights: NDArray[np.int32]
    offsets: NDArray[np.uint32]
    lanes: Coefficients
    missing: int | None = None

    def __post_init__(self) -> None:
        """Check every word against its format and make the arrays read-only."""
        weights, offsets = np.asarray(self.weights), np.asarray(self.offsets)
        MeanSet(tuple(weights.tolist()), tuple(offsets.tolist()), self.carrier, self.missing or 0)
        turn = self.lanes.counts_per_rev << OFFSET_FRACTION
        if np.any(offsets >= turn):
            raise ValueError(f"offsets: expected 0 to {turn - 1}, found {offsets}")
        for name, words, kind in (
            ("weights", weights, np.int32),
            ("offsets", offsets, np.uint32),
        ):
            kept = words.astype(kind)
            kept.flags.writeable = False
            object.__setattr__(self, name, kept)

    @property
    def heads(self) -> int:
        """How many heads the bank is for, one that is missing among them."""
        return int(self.weights.size)

    @classmethod
    def of_head(cls, head: int, heads: int, lanes: Coefficients) -> MeanBank:
        """The bank that puts out one head alone, corrected: what two heads do today."""
        weights = np.zeros(heads, dtype=np.int32)
        weights[head - 1] = 1 << WEIGHT_FRACTION
        return cls(head, weights, np.zeros(heads, dtype=np.uint32), lanes)

    def angle_counts(self, head_counts: ArrayLike) -> Float:
        """The equation in double precision from these words, (n,) counts, not rounded.

        ``head_counts``: whole counts of every head, (heads, n); whole turns between two heads
        mean nothing. The lanes take r_s rounded to a count, as the gateware does.
        """
        turn = self.lanes.counts_per_rev
        scale = 1 << OFFSET_FRACTION
        counts = np.asarray(head_counts, dtype=np.int64) * scale
        reading = counts - self.offsets.astype(np.int64)[:, None]
        carrier = reading[self.carrier - 1]
        span = turn * scale
        apart = (reading - carrier + span // 2) % span - span // 2
        shares = self.weights.astype(np.int64) @ apart
        rounded = (carrier + scale // 2) // scale
        return np.asarray(
            carrier / scale
            + shares / float(scale << WEIGHT_FRACTION)
            - self.lanes.error_counts(rounded)
        )
