"""Tests each guard of the diagnosis alone; ``make mutate`` removes a guard and runs its test.

Small numbers and small sets keep each test below a few seconds.
"""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.stats import chi2, f_oneway
from sim.tests.workbench.small_sets import measurement_set, paper_error

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose import classes
from arctrue.workbench.diagnose import evidence as weighing
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.diagnose.every_pass import at_other_speeds, on_every_pass
from arctrue.workbench.diagnose.lack_of_fit import analysis_of_variance, fisher_p
from arctrue.workbench.diagnose.parts_scan import (
    PartsCandidate,
    _natural,
    _without_idle_conditions,
    condition_shares,
    level_share,
)
from arctrue.workbench.diagnose.rules import of_a_class
from arctrue.workbench.diagnose.rules.instead_of_an_effect import described_by_parts
from arctrue.workbench.diagnose.rules.without_an_effect import left_undescribed
from arctrue.workbench.diagnose.survey import FitOfChannel, Survey
from arctrue.workbench.effects.part_conditions import ALWAYS, TEMPERATURE
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.held_out import Improvement, folds_of, holds_out
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import corrected_p_value
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.noise.degrees_of_freedom import degrees_of_freedom
from arctrue.workbench.noise.noise import index_variance
from arctrue.workbench.noise.row_noise import RowNoise
from arctrue.workbench.noise.spectrum import Spectrum
from arctrue.workbench.observations import Observations
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](orders=[1, 2, 3, 4, 5]), {})


def _reference(error: NDArray[np.float64], target_deg: NDArray[np.float64]) -> Observations:
    """Return a reference of one run with a row every tenth of a second."""
    rows = Reference(
        target_deg=target_deg, error_arcsec=error, time_s=0.1 * np.arange(error.size),
        direction=np.where(np.gradient(target_deg) < 0.0, -1, 1),
    )  # fmt: skip
    return observations_of(MeasurementSet(Table(), None, rows, title="guards"))


# Probabilities


def test_every_place_that_was_looked_at_is_charged() -> None:
    """The probability is corrected for all searched places. A χ² of 30 with two columns has the
    probability p at one place, and after a search of m places, Šidák's correction gives 1 − (1 −
    p)^m."""
    single = float(chi2.sf(30.0, 2))
    assert corrected_p_value(30.0, 2, 5000.0, 1) == pytest.approx(
        1.0 - (1.0 - single) ** 5000, rel=1e-6
    )


def test_every_candidate_is_charged() -> None:
    assert corrected_p_value(30.0, 2, 1.0, 20) == pytest.approx(20.0 * chi2.sf(30.0, 2), rel=1e-6)


def test_every_survey_of_a_diagnosis_is_charged() -> None:
    """The probability is corrected for all surveys: a diagnosis repeats the survey with one and
    with two named effects in the model."""
    made = measurement_set(runs=3, turns=1, reversal_arcsec=0.1)
    residuals = Residuals(fit([_base()], observations_of(made)))
    effects = {name: built_in()[name] for name in ("hysteresis", "thermal_head_drift")}
    once, thrice = (
        weighing.survey(residuals, effects, 0.0, lambda _: None, looks=looks) for looks in (1, 3)
    )
    for first, charged in (
        (once.candidates[0], thrice.candidates[0]),
        (once.parts[0], thrice.parts[0]),
    ):
        assert charged.p_corrected < 0.1
        assert charged.p_corrected == pytest.approx(3.0 * first.p_corrected, rel=1e-6)


def test_noise_that_is_little_known_makes_a_gain_less_rare() -> None:
    assert corrected_p_value(12.0, 1, 1.0, 1, freedom=4.0) > 4.0 * chi2.sf(12.0, 1)


def test_shares_of_the_false_alarms_of_products_add_up_to_one() -> None:
    orders = [None, *(np.arange(1, 61) / 2.0).tolist()]
    assert sum(level_share(order) for order in orders) == pytest.approx(1.0)
    assert sum(condition_shares([ALWAYS, TEMPERATURE])) == pytest.approx(1.0)


# Rows that are left out


def _improvement(gain: float, information: float) -> list[Improvement]:
    return [Improvement(0.0, 0.0, gain, information)]


def test_a_fall_within_two_standard_errors_is_none() -> None:
    """A gain within two standard errors of zero does not count. With an information of 100, a real
    gain has the mean 50 and the standard error 10: a gain of 15 does not count, 25 does."""
    assert not holds_out(_improvement(15.0, 100.0))
    assert holds_out(_improvement(25.0, 100.0))


def test_what_left_out_rows_cannot_show_must_not_get_worse() -> None:
    """If left-out rows cannot confirm a gain, they must not show a loss beyond two standard errors.
    With an information of 16, a real gain has the mean 8 and the standard error 4, so that −9
    counts as a loss."""
    assert holds_out(_improvement(-7.0, 16.0))
    assert not holds_out(_improvement(-9.0, 16.0))


def test_rows_side_by_side_are_left_out_apart_and_stations_not_together() -> None:
    target = np.tile(np.arange(24) * 15.0, 8)
    folds = folds_of(_reference(np.zeros(target.size), target)).reference
    assert folds is not None
    rounds = folds.reshape(-1, 4)
    assert np.all(np.sort(rounds, axis=1) == np.arange(4))
    # The number of stations, 24, is a multiple of the number of folds, four. If row i were
    # in fold i modulo 4, all visits of a station would be in one fold.
    of_stations = folds.reshape(8, 24)
    assert all(np.unique(of_stations[:, station]).size > 1 for station in range(24))


# Noise


def _slow_noise(seed: int) -> NDArray[np.float64]:
    """Return slow noise of 0.3″ with a time constant of 4 s plus 0.1″ of white noise, in 600 rows a
    tenth of a second apart."""
    clock = 0.1 * np.arange(600)
    drawn = RowNoise(
        clock,
        np.array([0]),
        (Spectrum(0.01, np.array([4.0]), np.array([0.09])),),
        np.ones(clock.size),
    )
    return drawn.draw(np.random.default_rng(seed))


def test_slow_noise_is_a_part_of_the_noise_and_no_effect() -> None:
    noise = fit([_base()], _reference(_slow_noise(2), 0.6 * np.arange(600))).noise.reference
    assert noise is not None
    slow = float(sum(spectrum.variances.sum() for spectrum in noise.spectra))
    assert slow > 0.5 * sum(spectrum.variance for spectrum in noise.spectra)
    # After whitening, neighbouring rows are no longer correlated.
    left = noise.whiten(_slow_noise(2))
    assert abs(float(np.corrcoef(left[1:], left[:-1])[0, 1])) < 0.15


def test_the_noise_with_an_effect_is_estimated_anew() -> None:
    """The noise is estimated again with the effect in the model, because the slow noise has
    absorbed a ramp of 6″. If the noise is estimated with the ramp in the model, the ramp is
    significant."""
    random = np.random.default_rng(4)
    ramp = np.linspace(-3.0, 3.0, 600) + random.normal(0.0, 0.1, 600)
    target = np.tile(np.arange(60) * 6.0, 10)
    residuals = Residuals(fit([_base()], _reference(ramp, target)))
    drift = EFFECTS["reference_drift"]()
    found = evidence(Null(residuals), drift, {})
    assert found.gain > 5.0 * residuals.score(drift, {}).gain
    assert found.gain > 50.0


def test_a_channel_without_repeats_does_not_know_its_noise() -> None:
    """The diagnosis does not know the noise of a channel without repeats: 24 readings with 41
    coefficients have a residual of 0, which does not show their scatter."""
    target = np.arange(24) * 15.0
    error = np.random.default_rng(1).normal(0.0, 0.2, 24)
    terms = [Term(EFFECTS["graduation_harmonics"](), {})]
    assert fit(terms, _reference(error, target)).unknown_noise == {"reference"}


def test_four_runs_do_not_know_the_index_better_than_the_prior_allows() -> None:
    """Four offsets that agree by chance do not make the index variance small: the prior of ±1 count
    per head keeps the weight of six runs."""
    observations = observations_of(measurement_set(runs=1, turns=1, reference=False))
    prior = observations.index_sigma_arcsec**2
    variance, worth = index_variance(observations, np.zeros(4))
    assert variance == pytest.approx(prior * worth / (worth + 4.0))
    assert variance > 0.5 * prior


def test_what_is_known_from_the_runs_has_the_freedom_of_the_runs() -> None:
    noise: Any = SimpleNamespace(groups=(), index_variance=1.0, index_freedom=6.0)
    freedom, share = degrees_of_freedom(noise, (None, None), np.ones(4), {})
    assert freedom == pytest.approx(10.0)
    assert share == 1.0


# Lack of fit


def test_means_of_groups_are_judged_by_the_scatter_within_them() -> None:
    random = np.random.default_rng(6)
    values = random.normal(size=60)
    group = np.repeat(np.arange(6), 10)
    expected = f_oneway(*np.split(values, 6)).pvalue
    assert analysis_of_variance(values, group) == pytest.approx(expected)


@pytest.mark.parametrize("count", [64, 65])
def test_a_line_below_the_nyquist_frequency_is_a_line(count: int) -> None:
    """The highest frequency with a phase is 31/64 or 32/65 periods per row."""
    random = np.random.default_rng(5)
    line = np.cos(2.0 * np.pi * ((count - 1) // 2) / count * np.arange(count) + 0.4)
    assert fisher_p(line + random.normal(0.0, 0.1, count)) < 1e-10


def test_a_line_pays_for_all_frequencies() -> None:
    """The probability of a sine is corrected for all frequencies: in white noise, a sine with p
    below 5 % occurs in about 5 % of the sets. Fewer than 16 of 120 sets may have such a sine, which
    allows four standard deviations."""
    random = np.random.default_rng(9)
    assert sum(fisher_p(random.normal(size=256)) < 0.05 for _ in range(120)) < 16


# Effects that occur once


def _candidate(base: Solution, term: Term) -> Any:
    grown = fit([*base.terms, term], base.observations, base.context, noise=base.noise)
    return SimpleNamespace(
        effect=term.effect,
        solution=grown,
        name=term.effect.name,
        nonlinear=term.nonlinear,
        evidence=None,
    )


def test_an_order_of_one_run_alone_is_no_property_of_the_disc() -> None:
    def once(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + (speed > 0.0) * np.cos(25 * disc)

    order = Term(EFFECTS["high_order_graduation"](), {"order": 25.0})
    for error, real in ((once, False), (_always, True)):
        made = measurement_set(error, runs=2, turns=1, reference=False)
        base = fit([_base()], observations_of(made))
        assert on_every_pass(_candidate(base, order), base) is real


def test_passes_are_asked_with_the_model_that_the_effect_was_weighed_with() -> None:
    """The comparison of the runs uses the noise with which the effect was judged. Order 25 is in
    both runs, and order 1 is 10″ larger in one of them. Only a fit with other noise follows this
    run.

    Such a fit changes order 1; this change must not count against order 25.
    """

    def uneven(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return _always(disc, temperature, speed) + 10.0 * (speed > 0.0) * np.cos(disc)

    made = measurement_set(uneven, runs=2, turns=1, reference=False)
    base = fit([_base()], observations_of(made))
    item = _candidate(base, Term(EFFECTS["high_order_graduation"](), {"order": 25.0}))

    def of_one_run(solution: Solution) -> Solution:
        moved = solution.coefficients.copy()
        moved[0] += 5.0
        return replace(solution, coefficients=moved)

    item.solution = of_one_run(item.solution)
    assert not on_every_pass(item, base)
    weighed_with: Any = SimpleNamespace(
        base=SimpleNamespace(solution=of_one_run(base)), index_share=0.0
    )
    item.evidence = weighed_with
    assert on_every_pass(item, base)


def test_what_the_offset_of_a_run_takes_is_not_asked_of_its_rows() -> None:
    """The rows of a run need not show an error that the offset of the run has absorbed: head 2 is
    displaced by 9″ in all rows.

    The rows of one run are 0.03″ higher, as if the index had scattered.
    """
    made = measurement_set(
        runs=3, turns=1, reference=False, head2_only=lambda time, speed: 9.0 + 0.0 * time
    )
    base = fit([_base()], observations_of(made))
    item = _candidate(base, Term(EFFECTS["head_angle_error"](), {}))
    rows = base.observations.capture
    assert rows is not None
    lifted = rows.difference_arcsec + 0.03 * (rows.run == 2)
    capture = replace(rows, difference_arcsec=lifted)
    there = replace(base, observations=replace(base.observations, capture=capture))
    assert on_every_pass(item, there)


def test_slow_noise_of_one_run_does_not_contradict_what_the_runs_show() -> None:
    """Head 2 is displaced by 9″. The offsets of the runs show this; the rows of a run show only the
    small change of the slope, which slow noise of 1″ in one run imitates."""
    made = measurement_set(
        runs=3, turns=1, reference=False, head2_only=lambda time, speed: 9.0 + 0.0 * time
    )
    base = fit([_base()], observations_of(made))
    item = _candidate(base, Term(EFFECTS["head_angle_error"](), {}))
    rows = base.observations.capture
    assert rows is not None
    change = item.solution.capture_prediction_arcsec(False) - base.capture_prediction_arcsec(False)
    wave = change - (np.bincount(rows.run, change) / np.bincount(rows.run))[rows.run]
    noisy = rows.difference_arcsec + wave / np.std(wave) * (rows.run == 1)
    capture = replace(rows, difference_arcsec=noisy)
    there = replace(base, observations=replace(base.observations, capture=capture))
    assert not on_every_pass(item, there)
    of_the_runs: Any = SimpleNamespace(base=SimpleNamespace(solution=there), index_share=0.9)
    item.evidence = of_the_runs
    assert on_every_pass(item, there)


def test_a_run_that_stands_out_by_chance_is_no_disturbance() -> None:
    """A run that stands out by chance does not contradict an effect. The set does not contain the
    tested waves; the test sets their size to 1.2 σ in each run, as noise would cause.

    Even the run with the largest such wave shows only noise, so that the other runs cannot
    contradict the wave.
    """
    base = fit([_base()], observations_of(measurement_set(turns=1, reference=False)))
    for order in range(21, 61):
        wave = Term(EFFECTS["high_order_graduation"](), {"order": float(order)})
        item = _candidate(base, wave)
        before = np.concatenate([base.coefficients, np.zeros(2)])
        change = item.solution.capture_prediction_arcsec(False)
        change = change - base.capture_prediction_arcsec(False)
        assert base.capture_sigma_arcsec is not None
        size = 1.2 * base.capture_sigma_arcsec * np.sqrt(base.observations.runs)
        if not np.linalg.norm(change) > 0.0:
            continue
        scale = size / np.linalg.norm(change)
        moved = before + scale * (item.solution.coefficients - before)
        item.solution = replace(item.solution, coefficients=moved)
        assert on_every_pass(item, base), order


def _always(disc, temperature, speed):  # type: ignore[no-untyped-def]
    return paper_error(disc, temperature, speed) + np.cos(25 * disc)


def test_a_frequency_of_one_speed_alone_is_no_vibration() -> None:
    line = Term(EFFECTS["vibration"](), {"frequency": 7.0})
    for slowest, real in ((1.0, False), (0.0, True)):

        def shaken(time, speed, slowest=slowest):  # type: ignore[no-untyped-def]
            return (abs(speed) > slowest) * np.cos(2.0 * np.pi * 7.0 * time)

        made = measurement_set(runs=3, turns=1, reference=False, head2_only=shaken)
        base = fit([_base()], observations_of(made))
        assert at_other_speeds(_candidate(base, line)) is real


def test_a_slow_effect_far_above_the_scatter_is_no_slow_noise(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A slow effect far above the scatter is not taken for slow noise. A delay of 40 ms on a ramp
    to 40°/s and back causes an error of up to 5,760″, which rises and falls once in a minute."""
    # With NEAR_P = 0, a small p is no reason to estimate the noise again; the only reason is that
    # the effect removes most of a channel's residual variance.
    monkeypatch.setattr(weighing, "NEAR_P", 0.0)
    time = np.arange(0.0, 60.0, 0.1)
    speed = np.where(time < 30.0, time, 60.0 - time) * 40.0 / 30.0
    noise = np.random.default_rng(9).normal(0.0, 20.0, time.size)
    error = -speed * 3600.0 * 0.04 + noise
    found = diagnose(_reference(error, np.cumsum(speed) * 0.1), [_base()], EFFECTS)
    assert found.verdict == "named"
    assert found.named is not None
    assert found.named.name == "latency"
    latency = found.named.parameters()["latency"]
    # The speed of a row is the slope over 65 rows, 6.5 s, which is not exact at the ends and at the
    # top of the ramp.
    assert latency.value == pytest.approx(40_000.0, rel=0.05)


# Other effects that fit the same rows


def test_an_effect_that_the_set_cannot_test_forbids_a_sure_name() -> None:
    """The diagnosis gives no sure name if the set cannot test another effect: the set goes up and
    back at one speed, at which a delay would look like the reversal error."""
    random = np.random.default_rng(7)
    up = np.arange(360.0)
    target = np.tile(np.concatenate([up, up[::-1]]), 2)
    side = np.tile(np.repeat([1.0, -1.0], 360), 2)
    error = 2.0 * side + random.normal(0.0, 0.2, target.size)
    found = diagnose(_reference(error, target), [_base()], EFFECTS)
    assert found.verdict == "ambiguous"
    assert set(found.decision.look_alikes) == {"latency"}
    assert found.effect_class == ["hysteresis", "latency"]


@pytest.mark.parametrize(("cycles", "verdict"), [(1, "ambiguous"), (2, "named")])
def test_a_single_reversal_is_a_step_in_time_as_well(cycles: int, verdict: str) -> None:
    """A single reversal also looks like a step in time: all stations are visited first upwards and
    then downwards."""
    made = measurement_set(cycles=cycles, reversal_arcsec=2.0, turns=1)
    found = diagnose(observations_of(made), [_base()], EFFECTS)
    assert found.verdict == verdict
    assert found.effect_class[0] == "hysteresis"
    # By definition the effect equals the product with the direction alone; therefore the answer
    # adds no description by parts.
    assert found.described is None


def test_what_says_why_goes_before_what_says_what_is_seen(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    line = SimpleNamespace(name="periodic_error", effect=EFFECTS["periodic_error"](), nonlinear={})
    gear = SimpleNamespace(
        name="drive_gear_error", effect=EFFECTS["drive_gear_error"](), nonlinear={}
    )
    both: Any = [line, gear]
    for as_good, kept in ((True, [gear]), (False, [line, gear])):
        monkeypatch.setattr(classes, "stands_in", lambda item, other, is_it=as_good: is_it)
        assert classes.without_unspecific(both) == kept


def test_a_more_natural_frame_is_left_only_for_odds_of_twenty_to_one() -> None:
    disc, head = (
        PartsCandidate(ProductOfParts.of(ALWAYS, (2.0,), frame), gain, 2, 1.0, 1.0)  # type: ignore[arg-type]
        for frame, gain in (("disc", 100.0), ("head2", 104.0))
    )
    assert _natural([disc, head], 1000) is disc
    assert _natural([disc, PartsCandidate(head.effect, 107.0, 2, 1.0, 1.0)], 1000) is not disc


def test_a_condition_that_adds_nothing_is_not_a_part() -> None:
    plain = PartsCandidate(ProductOfParts.of(ALWAYS, (2.0,), "disc"), 100.0, 2, 1.0, 1.0)
    warm = PartsCandidate(ProductOfParts.of(TEMPERATURE, (2.0,), "disc"), 104.0, 2, 1.0, 1.0)
    order = [ALWAYS, TEMPERATURE]
    assert _without_idle_conditions([warm, plain], order, 1000) == [plain]


# Ordered rules, tested with the numbers in this file


def _left(p_value: float, residual: float, noise: float, matters: float = 0.0) -> Any:
    channels = {"reference": FitOfChannel(residual, noise, p_value)}
    survey = SimpleNamespace(channels=channels, matters_arcsec=matters, detections=Detections())
    return SimpleNamespace(best=None, survey=survey)


def test_a_sure_lack_of_fit_is_unknown_only_where_it_is_large() -> None:
    assert left_undescribed(_left(1e-6, 0.30, 0.20)) is not None
    # The excess √(0.201² − 0.2²) is a tenth of the noise. Where 1″ matters, an excess of 0.3″ does
    # not count either.
    assert left_undescribed(_left(1e-6, 0.201, 0.20)) is None
    assert left_undescribed(_left(1e-6, 0.36, 0.20, matters=1.0)) is None
    assert left_undescribed(_left(1e-3, 0.30, 0.20)) is None


def test_a_product_of_parts_needs_odds_of_150_to_1_over_a_name() -> None:
    product = SimpleNamespace(
        effect=ProductOfParts.of(TEMPERATURE, (2.0,), "disc"),
        solution=SimpleNamespace(observations=SimpleNamespace(has_temperature=True)),
    )
    for ahead, is_unknown in ((11.0, True), (9.0, False)):
        case: Any = SimpleNamespace(product=product, ahead=ahead, depth=2)
        assert (described_by_parts(case) is not None) is is_unknown


def test_a_near_tie_with_a_product_of_parts_is_no_name(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(of_a_class, "_of_class", lambda case, verdict, **is_named: verdict)
    best = SimpleNamespace(lacking_variety=[])
    similar = SimpleNamespace(larger=[])
    for ahead, verdict in ((-5.0, "ambiguous"), (-7.0, None)):
        case: Any = SimpleNamespace(
            best=best,
            similar=similar,
            stand_in=SimpleNamespace(),
            ahead=ahead,
            rivals=[],
            others={},
            confounded_effect=None,
        )
        assert of_a_class.cannot_be_split(case) == verdict


def test_what_moves_the_prediction_by_less_than_what_matters_is_negligible() -> None:
    seen: Any = Survey(SimpleNamespace(), 0.04, 20)  # type: ignore[arg-type]
    for size, matters in ((0.05, True), (0.03, False)):
        item: Any = SimpleNamespace(size_arcsec={"capture": size})
        assert seen.matters(item) is matters
