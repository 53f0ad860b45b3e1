"""Test of the paper's experiment with a small instrument: 2¹⁷ counts, two orders."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.instrument.sizes import DEPTH, LANES, SAMPLES

from arctrue.instrument import InstrumentError, build
from arctrue.studies.paper import PUBLISHED
from arctrue.studies.paper.experiment import ExperimentSettings, run_experiment
from arctrue.studies.revolution import RevolutionSettings
from arctrue.table import DiscEccentricity
from arctrue.table.rotary_table import DISC_RADIUS_M

ORDERS = 2
SMALL = RevolutionSettings(
    interpolation=8, lanes=LANES, samples=SAMPLES, orders=ORDERS, noise_arcsec=0.1
)


def missing() -> str:
    try:
        build(LANES, DEPTH)
    except InstrumentError as error:
        return str(error)
    return ""


def test_it_corrects_to_the_counts_and_the_orders_that_are_not_applied() -> None:
    if reason := missing():
        pytest.skip(reason)
    result = run_experiment(ExperimentSettings(revolution=SMALL, cycles=3))
    # Before the compensation the range equals that of the paper to one count of rounding and 1″ of
    # noise.
    count = SMALL.arcsec_per_count
    assert result.before.span_arcsec == pytest.approx(PUBLISHED.before_arcsec, abs=count + 1.0)
    # Orders 3 and above, which are not corrected, leave an error of at most 2.95″. The other terms
    # allow half a count of rounding and three times the polygon's uncertainty.
    left = 2.95 + 0.5 * count + 3 * PUBLISHED.budget.polygon_arcsec
    assert np.abs(result.after.mean_arcsec).max() < left
    assert result.applied_orders == ORDERS
    assert result.refused_turns == 0
    assert result.budget.repeatability_arcsec == pytest.approx(
        float(result.after.deviation_arcsec.mean())
    )


def test_one_cycle_is_refused() -> None:
    with pytest.raises(ValueError, match="two cycles or more, found 1"):
        run_experiment(ExperimentSettings(revolution=SMALL, cycles=1))


def test_the_uncorrected_error_is_the_eccentricity_of_the_table() -> None:
    """The eccentricity e of the table at the disc radius r causes an error of amplitude e / r; it
    must be 144″, the paper's value."""
    (eccentricity,) = [e for e in SMALL.table().causes if isinstance(e, DiscEccentricity)]
    assert eccentricity.offset_m / DISC_RADIUS_M * 206265 == pytest.approx(144.0, abs=0.2)
