"""Defines the scale of an experiment with a hidden effect."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass, field

from arctrue.studies.revolution import RevolutionSettings
from arctrue.table import RotaryTable
from arctrue.table.cause import Cause
from arctrue.table.instruments.polygon import FACES

KEPT_A_SIGNAL_PERIOD = 64
"""Intended number of kept edges in each period of the grating. The number can differ from this,
because the step between kept edges is an odd whole number (1024 edges with step 17: 60)."""


@dataclass(frozen=True, slots=True)
class HiddenSettings:
    """Settings of the table and the gateware, as in ``arctrue revolution``, and of the
    measurements."""

    revolution: RevolutionSettings = field(
        default_factory=lambda: RevolutionSettings(
            noise_arcsec=0.1, clocks_per_count=1.14, alpha_error_arcsec=0.0
        )
    )
    stations: int = 360
    """Marks of the rotary reference per turn."""
    faces: int = FACES
    """Faces of the polygon; the table must stand still while a face is read."""
    cycles: int = 2
    """Cycles over all faces of the polygon."""
    reference_noise_arcsec: float = 0.1
    seed: int = 1

    @classmethod
    def of_lines(cls, lines: int, lanes: int, samples: int, **others: object) -> HiddenSettings:
        """Return settings like the paper's, but with the given number of grating lines, lanes and
        samples per turn."""
        usual = cls()
        scale = dataclasses.replace(usual.revolution, lines=lines, lanes=lanes, samples=samples)
        return dataclasses.replace(usual, revolution=scale, **others)  # type: ignore[arg-type]

    @property
    def kept_every(self) -> int:
        """Return the step between kept edges; it is odd, so that the kept edges cover every phase
        of the grating's period."""
        every = max(1, self.revolution.interpolation // KEPT_A_SIGNAL_PERIOD)
        return every + 1 - every % 2 if every > 1 else 1

    def table(self, hidden: Sequence[Cause]) -> RotaryTable:
        """Return the table of ``arctrue revolution`` with the causes ``hidden`` added; noise, if
        there is any, is the last cause."""
        plain = self.revolution.table()
        noise = 1 if self.revolution.noise_arcsec else 0
        known = plain.causes[: len(plain.causes) - noise]
        return RotaryTable(
            heads=plain.heads,
            causes=(*known, *hidden, *plain.causes[len(known) :]),
            counts_per_rev=plain.counts_per_rev,
        )
