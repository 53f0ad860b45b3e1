"""Tests of the coverage of a verdict: the smallest detectable effects, sets that cannot tell, and
aliases of orders."""

from __future__ import annotations

import inspect
import re
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from sim.tests.workbench.small_sets import ALPHA, measurement_set

from arctrue.workbench.diagnose import coverage as coverage_module
from arctrue.workbench.diagnose.aliases import aliases
from arctrue.workbench.diagnose.coverage import (
    MOST_UNTESTED,
    Coverage,
    blindness,
    coverage,
    effect_or_noise,
)
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.evidence import survey
from arctrue.workbench.diagnose.probabilities import NONE, UNKNOWN, prior_weights
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.detectable import (
    FEW_FREEDOM,
    Detectable,
    Refused,
    needed_gain,
    smallest_detectable,
)
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
REFUSED = Refused(1e-4, 10.0)


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def _residuals(slow_arcsec: float = 0.0) -> Residuals:
    observations = observations_of(measurement_set(runs=2, cycles=2))
    noise = white_noise(observations, (0.1, 0.15))
    assert noise.reference_law is not None
    slow = Spectrum(0.15**2, np.array([60.0]), np.array([slow_arcsec**2]))
    law = replace(noise.reference_law, spectra=tuple(slow for _ in noise.reference_law.spectra))
    assert observations.reference is not None
    noise = replace(noise, reference_law=law, reference=law.on(observations.reference))
    return Residuals(fit([_base()], observations, noise=noise))


def test_stated_odds_of_the_largest_untested_share_are_those_of_the_priors() -> None:
    stated = re.search(
        r"odds of ([\d.]+)\s+to 1 that nothing is missing", inspect.getsource(coverage_module)
    )
    weights = prior_weights(tested=100, untested=round(100 * MOST_UNTESTED / (1 - MOST_UNTESTED)))
    odds = np.exp(weights[NONE] - weights[UNKNOWN])
    assert stated is not None
    assert float(stated[1]) == pytest.approx(odds, abs=0.05)  # one decimal is stated
    # The docstring also states that the odds are 3 to 1 if five sixths are tested.
    weights = prior_weights(tested=5, untested=1)
    assert np.exp(weights[NONE] - weights[UNKNOWN]) == pytest.approx(3.0)


def test_smallest_size_is_that_of_dense_least_squares() -> None:
    """The smallest detectable reversal error is ± z·σ/√n, with white noise of 0.15″ and a constant
    in the model."""
    observations = observations_of(measurement_set(runs=1, cycles=2))
    residuals = Residuals(
        fit([_base()], observations, noise=white_noise(observations, (0.1, 0.15)))
    )
    found = smallest_detectable(residuals, EFFECTS["hysteresis"](), {}, 1.0)
    rows = observations.reference
    assert found is not None
    assert rows is not None
    # For one column at 1 %, the threshold is z = 2.576 and the power adds z = 1.645; both
    # directions have the same number of rows.
    expected = (2.5758 + 1.6449) * 0.15 / np.sqrt(rows.run.size)
    assert found.rms_arcsec["reference"] == pytest.approx(expected, rel=0.02)
    assert found.size is not None
    # The reversal error is twice the amplitude ± of its column.
    assert found.size.value == pytest.approx(2.0 * expected, rel=0.02)
    assert found.size.unit == "arcsec"


def test_adequate_says_what_it_covers() -> None:
    result = diagnose(observations_of(measurement_set()), [_base()], EFFECTS)
    data = diagnosis_data(result, ["graduation_harmonics"])
    assert data["schema"] == 2
    assert data["verdict"] == "adequate"
    assert set(data["covers"]["smallest"]) == {item["effect"] for item in data["candidates"]}
    assert data["covers"]["cannot_be_tested"] == data["cannot_be_tested"]
    orders = np.arange(1, 599)
    seen_equally = orders[np.abs(np.exp(1j * orders * ALPHA) - 1.0) < 1e-6]
    assert data["covers"]["blind_orders"] == seen_equally.tolist() == [120, 240, 360, 480]
    probability = data["probability"]
    assert sum(probability.values()) == pytest.approx(1.0)
    assert max(probability, key=probability.__getitem__) == "none"
    assert set(probability) == {item["effect"] for item in data["candidates"]} | {"none", "unknown"}
    assert data["noise"]["capture"]["white_arcsec"] == pytest.approx(0.1 * np.sqrt(2.0), rel=0.05)
    assert data["noise"]["reference"]["white_arcsec"] == pytest.approx(0.15, rel=0.15)
    assert any("the diagnosis would find" in text for text in sentences(result))


@pytest.mark.parametrize(("slow_arcsec", "blind"), [(0.0, False), (0.3, False), (3.0, True)])
def test_noise_that_is_all_slow_cannot_tell(slow_arcsec: float, blind: bool) -> None:
    """A reference whose slow noise is twice its scatter can show that no effect is missing; a
    reference whose slow noise is twenty times its scatter cannot."""
    residuals = _residuals(slow_arcsec)
    found = blindness(
        residuals, coverage(residuals, [], {}, 20, 20, REFUSED), {"capture": 1.0}, 0.0
    )
    assert (found is not None) == blind
    if found is not None:
        assert "reference changes slowly" in found.reason


def test_a_set_that_can_test_little_cannot_tell() -> None:
    made = measurement_set(runs=1, cycles=4)
    bare = replace(made, capture=None)
    result = diagnose(observations_of(bare), [_base()], EFFECTS)
    assert result.verdict == "cannot_tell"
    assert result.decision.cannot_tell is not None
    assert "cannot be tested" in result.decision.cannot_tell
    assert result.next_measurement is not None
    assert "capture of both heads" in result.next_measurement


def test_a_residual_smaller_than_what_can_be_found_cannot_tell() -> None:
    residuals = _residuals()
    covers = coverage(residuals, [], {}, 20, 20, REFUSED)
    assert blindness(residuals, covers, {"capture": 0.1, "reference": 0.15}, 0.0) is None
    found = blindness(residuals, covers, {"capture": 1e-5, "reference": 1e-5}, 0.0)
    assert found is not None
    assert "simple effects" in found.reason


@pytest.mark.parametrize(
    ("drift_rms_arcsec", "verdict"),
    [
        pytest.param(0.0, "adequate", marks=pytest.mark.large),
        (0.06, "cannot_tell"),
        pytest.param(0.1, "named", marks=pytest.mark.large),
    ],
)
def test_a_drift_that_slow_noise_may_be_is_not_adequate(
    drift_rms_arcsec: float, verdict: str
) -> None:
    """The verdict must not be "adequate" if a drift may be slow noise. If the noise is white, 288
    readings of 0.15″ determine a drift to 0.15″/√288 = 0.009″ RMS, and a drift of 6.8 times this
    value is significant.

    But slow noise of this size explains the rows as well; only the straightness of a drift
    distinguishes the two. At 11 times this value the set can distinguish them.
    """
    made = measurement_set(runs=2)
    assert made.reference is not None
    time = made.reference.time_s
    assert time is not None
    made.reference.error_arcsec[:] += drift_rms_arcsec * np.sqrt(12.0) * time / np.ptp(time)
    result = diagnose(observations_of(made), [_base()], EFFECTS)
    assert result.verdict == verdict
    if verdict == "cannot_tell":
        assert result.decision.cannot_tell is not None
        assert result.decision.cannot_tell.startswith("reference_drift and slow noise explain")
        assert result.next_measurement_kind == "again"
    if verdict == "named":
        assert result.named is not None
        assert result.named.name == "reference_drift"


@pytest.mark.parametrize(
    ("gain", "rank", "freedom", "is_named"), [(24.5, 1, 3.5, True), (55.2, 23, 25.0, False)]
)
def test_noise_with_many_columns_is_little_known(
    gain: float, rank: int, freedom: float, is_named: bool
) -> None:
    """The noise of a channel with many columns is hardly known. With 48 readings, 23 face errors
    leave 25 degrees of freedom, and F(23, 25) = 2.3 has a probability of 2 %; with known noise it
    would be 2·10⁻⁴."""
    item: Any = SimpleNamespace(
        name="x",
        evidence=SimpleNamespace(score=SimpleNamespace(gain=gain, rank=rank)),
        size_arcsec={"reference": 0.1},
        trials=1.0,
        freedom=freedom,
    )
    assert (effect_or_noise([item], 19, 0.04) is not None) == is_named
    assert effect_or_noise([item], 19, 0.2) is None


@pytest.mark.large
def test_an_order_with_fewer_than_two_stations_a_period_has_aliases() -> None:
    """A gear with 90 teeth has aliases at 24 faces: the orders 18, 6, 42 and 30 have its cos and
    sin columns."""
    made = measurement_set(runs=2)
    assert made.reference is not None
    target = np.radians(made.reference.target_deg)
    made.reference.error_arcsec[:] += 1.0 * np.cos(90.0 * target + 0.5)
    made = replace(made, table=replace(made.table, drive_gear_teeth=90.0))
    result = diagnose(observations_of(made), [_base()], EFFECTS)
    assert result.effect_class[0] == "drive_gear_error"
    found = diagnosis_data(result, ["graduation_harmonics"])["aliases"]
    assert found == [6.0, 18.0, 30.0, 42.0]
    waves = np.stack([np.cos(90.0 * target), np.sin(90.0 * target)], axis=1)
    for order in found:
        same = np.stack([np.cos(order * target), np.sin(order * target)], axis=1)
        left = waves - same @ np.linalg.lstsq(same, waves, rcond=None)[0]
        np.testing.assert_allclose(left, 0.0, atol=1e-9)
    assert any("orders 6, 18, 30, 42 and others" in words for words in sentences(result))


@pytest.mark.parametrize(("order", "stations"), [(5.0, 24), (90.0, 360)])
def test_an_order_with_two_stations_a_period_has_none(order: float, stations: int) -> None:
    observations: Any = SimpleNamespace(
        capture=None,
        reference=SimpleNamespace(target_rad=np.arange(stations) * 2.0 * np.pi / stations),
    )
    effect = SimpleNamespace(declared_order=lambda _: order)
    item: Any = SimpleNamespace(effect=effect, parameters=dict)
    assert aliases(item, observations) == []
    uneven = observations.reference.target_rad
    uneven[::3] += 0.01
    effect.declared_order = lambda _: 10.0 * stations
    assert aliases(item, observations) == []


def test_a_bound_of_hardly_known_noise_says_so() -> None:
    """The report of the smallest detectable size states that the noise is hardly known. At this
    limit of the degrees of freedom, the F test needs 2.8 times the size that would suffice if the
    noise were known."""
    ratio = [np.sqrt(needed_gain(1, 19, freedom) / needed_gain(1, 19)) for freedom in (2.0, 6.0)]
    assert ratio == [pytest.approx(37.0, rel=0.01), pytest.approx(2.8, rel=0.02)]
    found = diagnose(observations_of(measurement_set()), [_base()], {})
    for freedom, stated in ((FEW_FREEDOM - 0.1, True), (FEW_FREEDOM, False)):
        sizes = {"reference_drift": Detectable({"reference": 3.0}, None, freedom)}
        said = replace(
            found,
            decision=replace(found.decision, verdict="adequate"),
            covers=replace(found.covers, smallest=sizes),
        )
        words = " ".join(sentences(said))
        assert ("is known so poorly for reference_drift" in words) == stated


@pytest.mark.parametrize("bare", [False, True])
def test_an_effect_that_the_tests_drop_counts_as_tested(bare: bool) -> None:
    """The number of effects is the same for like sets: an effect whose search finds nothing, or
    that the model explains completely, was tested. The catalogue has 19 further effects that
    concern a polygon without a capture."""
    measured = replace(measurement_set(runs=1, turns=1, cycles=2), capture=None)
    assert measured.reference is not None
    if bare:
        reference = replace(
            measured.reference, direction=None, time_s=None, faces=None, temperature_c=None
        )
        measured = replace(measured, reference=reference)
    residuals = Residuals(fit([_base()], observations_of(measured)))
    tried = survey(residuals, EFFECTS, 0.0, lambda text: None)
    assert len(tried.candidates) + len(tried.untestable) < 19
    found = coverage(residuals, [], tried.untestable, tried.absent, tried.tested, REFUSED)
    why = blindness(residuals, found, {"reference": 1.0}, 0.0)
    assert why is not None
    untested = len(tried.untestable)
    assert why.reason == f"{untested} of 19 effects cannot be tested with it"


def test_the_share_of_untested_effects_counts_every_tested_one() -> None:
    """At most half of the effects may be untestable; an effect that was tested without a result
    counts as tested."""
    residuals = _residuals()
    for tested, blind in ((10, False), (9, True)):
        found = Coverage(untestable={str(name): ["a thing"] for name in range(10)}, tested=tested)
        why = blindness(residuals, found, {"capture": 1.0, "reference": 1.0}, 0.0)
        assert (why is not None) == blind
