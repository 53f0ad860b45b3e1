"""The interpolator of each head has an error with the period of its signal."""

from __future__ import annotations

from math import comb

import numpy as np
from numpy.typing import NDArray
from scipy.special import chdtri

from arctrue.workbench.effects.base import (
    Columns,
    Effect,
    FitContext,
    Lane,
    Leftover,
    Nonlinear,
    Parameter,
    amplitude_and_phase,
    paired_lanes,
)
from arctrue.workbench.effects.capture_block import in_place_of_head
from arctrue.workbench.effects.missing import lacking_key
from arctrue.workbench.numeric.harmonics import harmonic_columns, harmonic_names
from arctrue.workbench.observations import CaptureRows, Observations, ReferenceRows

WORTH_P = 0.01
"""Largest p with which a multiple of the phase (two columns per head) is kept."""


class SubdivisionError(Effect):
    """Adds cosine and sine of k times the electrical phase, separately for each head."""

    name = "subdivision_error"
    physics = (
        "Offset, gain and phase errors of a head's sine and cosine make the interpolated angle "
        "oscillate once, twice or four times per signal period. Each head has its own "
        "electronics and its own errors."
    )
    equation = "ε_h = Σ c_{h,k} cos kφ_h + s_{h,k} sin kφ_h, φ_h = 2π·frac(counts·lines/turn)"
    source = "Heydemann (1981), quadrature errors of an interferometer"
    capture_sees = (
        "the oscillations of both heads; the factor e^{jnα} − 1 of errors that are fixed to the "
        "disc does not apply"
    )
    reference_sees = (
        "with 24 faces and 16,384 lines, an alias at order 8, because the faces meet only 3 "
        "electrical phases"
    )
    separated_by = "the error follows the electrical phase, counts mod (counts per line)"
    next_measurement = "a slow capture over a few signal periods with many samples per period"
    plausible = "0.06 to 2.4″"
    parameter_units = {
        "head1_multiple_K_amplitude": "arcsec",
        "head1_multiple_K_phase": "deg",
        "head2_multiple_K_amplitude": "arcsec",
        "head2_multiple_K_phase": "deg",
    }
    of_the_signal = True
    compensation = "lanes"
    at_reading = True
    compensation_note = (
        "lanes at the orders k × lines correct head 1's part; the parts of other heads are not "
        "in the output"
    )
    defaults = {"multiples": [1, 2, 4]}

    def missing(self, observations: Observations) -> list[str]:
        if observations.grating_lines is None:
            return [lacking_key("table.grating_lines")]
        if observations.capture is None and (
            observations.reference is None or observations.reference.electrical1_rad is None
        ):
            return ["counts of a head"]
        return []

    def column_names(self, observations: Observations) -> list[str]:
        multiples = self.integers("multiples")
        heads = range(1, observations.heads + 1)
        return [name for head in heads for name in harmonic_names(multiples, f"head {head} ")]

    def capture_columns(
        self, rows: CaptureRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns:
        assert rows.electrical1_rad is not None
        assert rows.electrical2_rad is not None
        multiples = self.integers("multiples")
        return np.hstack(
            [
                -harmonic_columns(rows.electrical1_rad, multiples),
                in_place_of_head(harmonic_columns(rows.electrical2_rad, multiples), rows),
            ]
        )

    def reference_columns(
        self, rows: ReferenceRows, nonlinear: Nonlinear, context: FitContext
    ) -> Columns | None:
        if rows.electrical1_rad is None:
            return None
        head1 = harmonic_columns(rows.electrical1_rad, self.integers("multiples"))
        return np.hstack([head1, *[np.zeros_like(head1)] * (rows.heads - 1)])

    def electrical_orders(self, observations: Observations) -> list[float]:
        lines = observations.grating_lines or 0
        of_head = [float(k * lines) for k in self.integers("multiples") for _ in ("cos", "sin")]
        return of_head * observations.heads

    def constant_between_heads_arcsec(self, coefficients: NDArray[np.float64]) -> float:
        """Return the sum of all amplitudes.

        Sine and cosine that deviate from quadrature by ψ cause ψ/2·(1 ± cos 2φ), and the columns
        contain only the wave. A counter that is zeroed at the index also keeps, as an offset, the
        whole error at the index.
        """
        pairs = coefficients.reshape(-1, 2)
        return float(np.sum(np.hypot(pairs[:, 0], pairs[:, 1])))

    def narrowed(self, residuals: Leftover) -> tuple[Effect, float]:
        """Keep the multiples that are significant.

        The third multiple is tested too, because large distortions produce it.
        """
        tried = sorted({*self.integers("multiples"), 3})
        least = float(chdtri(2 * residuals.observations.heads, WORTH_P))
        forms = [SubdivisionError(multiples=[multiple]) for multiple in tried]
        scores = residuals.scores([(form, {}) for form in forms])
        kept = [
            multiple for multiple, score in zip(tried, scores, strict=True) if score.gain > least
        ]
        if not kept:
            return self, 1.0
        return SubdivisionError(multiples=kept), float(comb(len(tried), len(kept)))

    def lanes(
        self,
        coefficients: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
        temperature_c: float | None,
    ) -> list[Lane]:
        lines = observations.grating_lines
        assert lines is not None
        # The columns of head 1 come first; the output does not contain the errors of the other
        # heads.
        return paired_lanes([lines * k for k in self.integers("multiples")], coefficients)

    def parameters(
        self,
        coefficients: NDArray[np.float64],
        covariance: NDArray[np.float64],
        nonlinear: Nonlinear,
        observations: Observations,
    ) -> dict[str, Parameter]:
        multiples = self.integers("multiples")
        found: dict[str, Parameter] = {}
        for head in range(1, observations.heads + 1):
            for index, multiple in enumerate(multiples):
                start = 2 * (index + (head - 1) * len(multiples))
                pair = slice(start, start + 2)
                cosine, sine = coefficients[pair]
                found |= amplitude_and_phase(
                    cosine, sine, covariance[pair, pair], f"head{head}_multiple_{multiple}_"
                )
        return found
