"""Holds the recorded inputs and outputs of the core together with the true angle."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True, slots=True)
class EdgeTrack:
    """Recorded edges of one encoder signal.

    Every K-th edge is kept, in arrays of shape ``(n,)``; the bins, shape ``(bins,)``, count all
    edges. Positions and errors have an arbitrary zero, which is the same for a whole track.
    """

    counts_per_rev: int
    """Counts per turn."""
    clock: NDArray[np.int64]
    """Clock of each kept edge."""
    position: NDArray[np.int64]
    """Level, in counts, that the reading passed at each kept edge."""
    true_angle_rad: NDArray[np.float64]
    """True angle of the table, not wrapped, half a clock before each kept edge; for an edge of the
    output, half a clock plus the latency of the core before it."""
    bin_edges: NDArray[np.int64]
    """Number of edges in each bin, an equal part of the turn."""
    bin_mean_counts: NDArray[np.float64]
    """Mean of (position − true angle) in each bin, counts; NaN in an empty bin."""
    bin_lowest_counts: NDArray[np.float64]
    """Smallest value of (position − true angle) in each bin, counts; ∞ in an empty bin."""
    bin_highest_counts: NDArray[np.float64]
    """Largest value of (position − true angle) in each bin, counts; −∞ in an empty bin."""
    edges: int
    """Number of all edges, whether kept or not."""
    dropped: int
    """Number of edges that were not kept because the limit of kept edges was reached."""


@dataclass(frozen=True, slots=True)
class Recording:
    """One recording: the edges of the core's output and of head 1's incoming signal."""

    output: EdgeTrack
    """Edges of the corrected signal."""
    head1: EdgeTrack
    """Edges of head 1's incoming signal."""
    illegal: int
    """Number of clocks in which A and B of the output changed together."""
    index_clock: NDArray[np.int64]
    """Clocks in which Z of the output rose from low to high."""
    index_position: NDArray[np.int64]
    """Position of the output in each of the clocks ``index_clock``, from the zero of the track."""
