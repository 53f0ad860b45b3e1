"""Names the pins of the core, and describes faults on their wires."""

from __future__ import annotations

from dataclasses import dataclass

HEAD1_A, HEAD1_B, HEAD1_Z, HEAD2_A, HEAD2_B, HEAD2_Z = (1 << pin for pin in range(6))
SYNC_IN, PROBE_IN = (1 << pin for pin in range(6, 8))
HEAD3_A, HEAD3_B, HEAD3_Z, HEAD4_A, HEAD4_B, HEAD4_Z = (1 << pin for pin in range(8, 14))
TRIGGER_OUT, COMPARE_OUT = (1 << place for place in range(9, 11))
"""Masks of trigger_out and compare_out in the levels that :meth:`Instrument.traced` returns."""


@dataclass(frozen=True, slots=True)
class PinFault:
    """Fault on the wires between heads and core, which begins at ``first_clock``.

    ``invert``, ``low`` and ``high`` are sums of HEAD1_A … HEAD4_Z: pins that are inverted or held.
    With ``probability`` below 1 the fault acts only in clocks that are drawn at random. Without a
    fault, SYNC_IN and PROBE_IN are low; ``high`` puts a pulse on them.
    """

    first_clock: int
    """Clock at which the fault begins."""
    clocks: int
    """Length of the fault in clocks."""
    invert: int = 0
    """Pins that are inverted."""
    low: int = 0
    """Pins that are held low."""
    high: int = 0
    """Pins that are held high."""
    probability: float = 1.0
    """Probability that the fault acts, in each clock."""
