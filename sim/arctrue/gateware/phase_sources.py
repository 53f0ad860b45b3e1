"""Selects how the device determines the phase of each lane of a real order."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping

import numpy as np

from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import PhaseSource
from arctrue.generated.number_formats import PHASE_WIDTH

SIDE_MOST = 8
"""Largest magnitude of the side (a whole number, see :class:`PhaseSource`) that is tried for a lane
whose phase comes from an index of the drive."""
SIDE_TOLERANCE = 0.005
"""Largest permitted deviation of a fitted order minus its side from a multiple of the number of the
drive's indices in a turn, in periods per turn. It is five times the standard uncertainty of an
order that is fitted to one turn of a reference."""


def with_phase_from_heads(coefficients: Coefficients) -> Coefficients:
    """Return the bank in which the device determines the phase of each lane of a real order from
    the heads."""
    return _with_phase_sources(
        coefficients,
        {lane: PhaseSource("heads") for lane in np.flatnonzero(coefficients.turn_steps).tolist()},
    )


def with_phase_from_probe(
    coefficients: Coefficients, edge_turns: float, edges_per_turn: float
) -> Coefficients:
    """Return the bank in which the device determines the phase of each lane of a real order
    from an index of the drive.

    ``edge_turns``: angle of the table at an index, in turns from the start of turn 0;
    ``edges_per_turn``: number of indices in a turn of the table. A harmonic has the same phase
    at every index if its order minus an integer, its side, is a multiple of ``edges_per_turn``.
    Raises ValueError for a harmonic without such a side.
    """
    sources = {}
    for lane in np.flatnonzero(coefficients.turn_steps).tolist():
        order = float(coefficients.real_orders[lane])
        side = _side_of(order, edges_per_turn)
        turns = coefficients.phases_rad[lane] / (2.0 * np.pi) + (order - side) * edge_turns
        phase = round((turns % 1.0) * 2**PHASE_WIDTH) % 2**PHASE_WIDTH
        sources[lane] = PhaseSource("probe", side, phase)
    return _with_phase_sources(coefficients, sources)


def _with_phase_sources(
    coefficients: Coefficients, sources: Mapping[int, PhaseSource]
) -> Coefficients:
    extension = dataclasses.replace(
        coefficients.extension or Extension(), phase_sources=tuple(sorted(sources.items()))
    )
    return dataclasses.replace(coefficients, extension=extension)


def _side_of(order: float, edges_per_turn: float) -> int:
    """Return the s of smallest size for which order - s is a multiple of ``edges_per_turn``.

    Raises ValueError if no s with |s| up to SIDE_MOST gives a multiple.
    """
    if not edges_per_turn > 0.0:
        raise ValueError(f"edges in a turn: {edges_per_turn:g}, expected more than 0")
    for side in sorted(range(-SIDE_MOST, SIDE_MOST + 1), key=abs):
        multiple = (order - side) / edges_per_turn
        if abs(multiple - round(multiple)) * edges_per_turn <= SIDE_TOLERANCE:
            return side
    raise ValueError(
        f"order {order:.7g}: for no side from -{SIDE_MOST} to {SIDE_MOST} is the order minus the "
        f"side a multiple of {edges_per_turn:.7g} edges per turn, so that the phase differs from "
        "edge to edge"
    )
