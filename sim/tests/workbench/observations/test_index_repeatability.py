"""Tests which repeatability of the index the workbench uses: the value that the set states,
otherwise ±1 count per head."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.workbench.noise.noise import index_variance
from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set

STATED_COUNTS = 3.0


def test_the_stated_repeatability_is_that_of_both_heads() -> None:
    """The stated repeatability σ applies to each head, so that the difference of two heads has σ√2.
    Without a stated value, the counts −1, 0 and 1 have a variance of 2/3 per head."""
    made = measurement_set(runs=1, turns=1, reference=False)
    stated = replace(made, table=replace(made.table, index_repeatability_counts=STATED_COUNTS))
    assert made.table.counts_per_rev is not None
    count_arcsec = 1_296_000 / made.table.counts_per_rev
    by_default, as_stated = observations_of(made), observations_of(stated)
    assert by_default.index_sigma_arcsec == pytest.approx(count_arcsec * np.sqrt(4.0 / 3.0))
    expected = STATED_COUNTS * count_arcsec * np.sqrt(2.0)
    assert as_stated.index_sigma_arcsec == pytest.approx(expected)
    # Four runs that agree by chance lower a stated value less than an assumed one.
    left = [
        index_variance(item, np.zeros(4))[0] / item.index_sigma_arcsec**2
        for item in (by_default, as_stated)
    ]
    assert left[0] < left[1] < 1.0
