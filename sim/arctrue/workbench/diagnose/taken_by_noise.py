"""Effects that the slow noise of a channel may have taken, for it was estimated without them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.significance import corrected_p_value, single_p_value
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.law import NoiseLaw
from arctrue.workbench.noise.row_noise import RowNoise, with_spectra
from arctrue.workbench.noise.spectrum import Spectrum

OF_ITS_SIZE = 0.2
"""Noise that has taken an effect is about as large as it: the effect is then a standard uncertainty
of such noise or more, which chance makes with this probability or less."""


def without_slow_noise(residuals: Residuals) -> Residuals:
    """The same model beside the white part of the noise alone."""
    base = residuals.solution
    noise = base.noise
    white = replace(
        noise,
        capture=_white_rows(noise.capture),
        reference=_white_rows(noise.reference),
        capture_law=_white_law(noise.capture_law),
        reference_law=_white_law(noise.reference_law),
        groups=(),
    )
    again = fit(base.terms, base.observations, base.context, noise=white)
    return Residuals(replace(again, unknown_noise=base.unknown_noise))


def _white_rows(rows: RowNoise | None) -> RowNoise | None:
    if rows is None:
        return None
    return with_spectra(rows, [Spectrum(item.white) for item in rows.spectra])


def _white_law(law: NoiseLaw | None) -> NoiseLaw | None:
    if law is None:
        return None
    return replace(law, spectra=tuple(Spectrum(item.white) for item in law.spectra))


def may_be_taken(
    items: Sequence[Candidate], residuals: Residuals, candidates: int, significance: float
) -> list[Candidate]:
    """Those of ``items`` that would be significant if there were no slow noise.

    No estimate of the noise beside an effect leaves less of it than none, so that what is not
    significant beside none is so beside no estimate. An effect with a search is left out, whose
    place was found in the slow noise.
    """
    fixed = [
        item
        for item in items
        if not item.effect.search and single_p_value(item.gain, item.rank, np.inf) < OF_ITS_SIZE
    ]
    if not fixed:
        return []
    white = without_slow_noise(residuals)
    white.scores([(item.effect, item.nonlinear) for item in fixed])
    found = []
    for item in fixed:
        score = white.score(item.effect, item.nonlinear)
        if corrected_p_value(score.gain, score.rank, item.trials, candidates) < significance:
            found.append(item)
    return found
