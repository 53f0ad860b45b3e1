"""Tests of single rules of the verdict; each test makes a set for its rule."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.special import ndtr
from sim.tests.workbench.small_sets import CAPTURE_NOISE, measurement_set, paper_error

from arctrue.studies.benchmark.diagnosis import diagnosed
from arctrue.studies.simulate.experiment import full
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.workbench.diagnose.diagnosis import Diagnosis, diagnose
from arctrue.workbench.diagnose.evidence import survey
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.held_out import held_out
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.scan.steps import LEAST_STEP_ROWS, step_trials
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()
COUNT_ARCSEC = 1_296_000 / (1 << 24)


def _weak(name: str, size: float, seed: int) -> Diagnosis:
    """Diagnose a set of four runs with 2,000 samples each and ten polygon cycles; no effect counts
    as negligible, however small it is."""
    made = simulate_set([Wanted(name, size)], full().smaller(2000, 10), seed)
    _, found = diagnosed(made.measurement, 0.0)
    return found


@pytest.mark.large
def test_two_orders_of_a_warm_run_are_no_vibration() -> None:
    """The diagnosis names no vibration for two orders that exist only in the warm run. A line with
    a free phase in every run could absorb such an order, but the other runs do not contain the
    line."""

    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        warmer = temperature - 20.0
        return (
            paper_error(disc, temperature, speed)
            + 0.3 * warmer * np.cos(disc + 0.7)
            + 0.3 * warmer * np.cos(2 * disc - 0.4)
        )

    terms = [Term(EFFECTS["graduation_harmonics"](), {})]
    found = diagnose(observations_of(measurement_set(error)), terms, EFFECTS)
    assert found.verdict in ("named", "unknown")
    if found.named is not None:
        assert found.named.name == "thermal_eccentricity"


def test_a_step_in_the_last_turn_can_be_held_out() -> None:
    """Held-out rows confirm a step of 16 counts in the last turn. It comes after 2.6 of the 3 turns
    of the last run, and whichever fold is left out, rows remain on both sides of the step."""
    counts, noise = 16, CAPTURE_NOISE * np.sqrt(2.0)
    measurement = measurement_set(
        head2_only=lambda time, speed: counts * COUNT_ARCSEC * (time > 1800.0 + 31.2),
        reference=False,
    )
    observations = observations_of(measurement)
    base = Term(EFFECTS["graduation_harmonics"](), {})
    slip = EFFECTS["count_slip"]()
    place = places_of(slip, Residuals(fit([base], observations)))[0].nonlinear
    before, after = (
        held_out(terms, observations, fit(terms, observations).context).capture_rms_arcsec
        for terms in ([base], [base, Term(slip, place)])
    )
    assert before is not None
    assert after is not None
    assert before > 1.2 * noise
    # 14,400 rows with 41 coefficients determine the noise to a percent; the noise includes the
    # rounding of both heads.
    assert after == pytest.approx(np.hypot(noise, COUNT_ARCSEC / np.sqrt(6.0)), rel=0.03)


@pytest.mark.parametrize("size", [3.0, 3.5])
def test_a_step_pays_for_all_its_instants(size: float) -> None:
    """The corrected probability of a step equals the share of sets of simulated white noise in
    which the largest step is as large (two heads, one run with an offset)."""
    sets, rows = 4_000, 500
    noise = np.random.default_rng(15).normal(size=(sets, rows))
    before = np.arange(LEAST_STEP_ROWS, rows - LEAST_STEP_ROWS + 1)
    total = np.cumsum(noise, axis=1)
    bridge = total[:, before - 1] - total[:, -1:] * (before / rows)
    largest = np.max(np.abs(bridge) / np.sqrt(before * (1.0 - before / rows)), axis=1)
    share = float(np.mean(largest > size))
    # For large steps the formula is right to a tenth; the test allows four standard deviations of
    # the counted share in addition.
    reported = step_trials(size**2, rows) * 2.0 * float(ndtr(-size))
    assert share == pytest.approx(reported, abs=0.1 * reported + 4.0 * np.sqrt(reported / sets))


@pytest.mark.parametrize("rows", [1, 2, 3])
def test_rows_that_are_off_at_the_end_of_a_run_are_no_slip(rows: int) -> None:
    """Wrong rows at the end of a run are no slip: they are too few to distinguish a step from
    single wrong rows. They are not masked either, because they are wrong by 5 σ only."""
    made = measurement_set(reference=False)
    assert made.capture is not None
    made.capture.head2_counts[-rows:] += round(5.0 * CAPTURE_NOISE * np.sqrt(2.0) / COUNT_ARCSEC)
    observations = observations_of(made)
    assert observations.masked == ()
    base = fit([Term(EFFECTS["graduation_harmonics"](), {})], observations)
    times = made.capture.time_s[-4:]
    for place in places_of(EFFECTS["count_slip"](), Residuals(base)):
        assert place.nonlinear["run"] != 3.0 or place.nonlinear["instant"] <= times[0]


@pytest.mark.large
def test_many_faces_win_over_the_one_order_that_they_contain() -> None:
    """The diagnosis names the faces of a polygon and not order 4, which by chance is the largest
    order of the face errors: noise does not explain the other orders of these errors."""
    found = _weak("polygon_face_error", 0.1, 50_000)
    assert found.named is not None
    assert found.named.name == "polygon_face_error"


@pytest.mark.large
def test_weak_distortions_are_not_charged_for_multiples_that_are_not_there() -> None:
    """Weak distortions get no penalty for multiples that the set does not contain.

    The set contains only the first two multiples. With four multiples, the effect would have eight
    more columns, which fit noise.
    """
    found = _weak("subdivision_error", 0.015, 50_000)
    assert found.named is not None
    assert found.named.name == "subdivision_error"
    assert set(found.named.effect.integers("multiples")) <= {1, 2}


@pytest.mark.large
def test_a_near_tie_between_a_step_and_a_settling_is_said() -> None:
    """A slip of two counts fits almost as well as the true error of 0.25″, which settles in the
    first run."""
    found = _weak("settling_bracket", 0.25, 50_001)
    assert found.verdict in ("ambiguous", "unknown")
    assert found.candidates[0].name == "count_slip"
    assert found.described is not None
    assert found.described.effect.parts == ["settling", "head2"]  # type: ignore[attr-defined]


@pytest.mark.large
@pytest.mark.parametrize("seed", [3, 4])
def test_the_time_constant_of_a_settling_is_between_the_grid_points(seed: int) -> None:
    made = simulate_set([Wanted("settling_bracket", 2.0)], full().smaller(2000, 10), seed)
    truth = made.truth["effects"][0]["causes"][0]
    _, found = diagnosed(made.measurement)
    assert found.verdict == "unknown"
    assert found.described is not None
    condition = found.described.effect.condition  # type: ignore[attr-defined]
    # The error of 2″ lasts for some hundred rows with 0.15″ of noise, so that these rows determine
    # the time constant to a few percent.
    assert condition.time_constant_s == pytest.approx(truth["time_constant_s"], rel=0.1)


@pytest.mark.large
def test_a_line_at_one_speed_only_may_be_an_alias() -> None:
    """The diagnosis states that a vibration at one speed may be an alias. A vibration of 101.5 Hz,
    sampled at 167 Hz in the slow runs, appears at 65.2 Hz, but not in the fast run at 500 Hz."""
    made = simulate_set([Wanted("vibration", 0.02)], full().smaller(6000, 10), 40_005)
    _, found = diagnosed(made.measurement, 0.0)
    assert found.verdict == "ambiguous"
    assert found.effect_class == ["vibration"]
    assert found.next_measurement_kind == "samples"
    frequency = made.truth["effects"][0]["causes"][0]["frequency_hz"]
    rate = 6000 / 36.0
    assert found.candidates[0].nonlinear["frequency"] == pytest.approx(rate - frequency, abs=0.05)


@pytest.mark.large
def test_what_is_missing_with_the_named_one_is_said() -> None:
    """The diagnosis names one of two causes and also reports the other: the set has 0.4″/K of order
    1 and a reversal error of 0.8″."""

    def error(disc, temperature, speed):  # type: ignore[no-untyped-def]
        return paper_error(disc, temperature, speed) + 0.4 * (temperature - 20.0) * np.cos(disc)

    both = {"thermal_eccentricity", "hysteresis"}
    terms = [Term(EFFECTS["graduation_harmonics"](), {})]
    found = diagnose(observations_of(measurement_set(error, reversal_arcsec=0.8)), terms, EFFECTS)
    assert found.named is not None
    assert {found.named.name, *(item.name for item in found.further)} == both
    assert any("diagnose again" in sentence for sentence in sentences(found))
    alone = diagnose(observations_of(measurement_set(error)), terms, EFFECTS)
    assert alone.named is not None
    assert alone.further == []


def test_runs_of_two_turns_are_enough_for_a_ball_pass() -> None:
    """Runs of two turns are enough for a ball pass, although the last sample of two turns lies one
    step before their end."""
    observations = observations_of(measurement_set(turns=2))
    assert observations.longest_run_turns < 2.0
    assert EFFECTS["bearing_ball_pass"]().missing(observations) == []


def test_a_line_with_an_order_of_the_model_is_found_at_its_place() -> None:
    """The search finds a line at 11.82 next to the model's order 12, which absorbs a part of the
    line; three turns resolve 1/6 of an order.

    The residual has its maximum at 11.72. The tolerance of 0.01 is about a twentieth of the
    resolution.
    """
    order, turn_s = 11.82, 12.0
    observations = observations_of(
        measurement_set(
            runs=1,
            reference=False,
            head2_only=lambda time, speed: 0.6 * np.cos(2 * np.pi * order / turn_s * time),
        )
    )
    base = fit([Term(EFFECTS["graduation_harmonics"](), {})], observations)
    found = places_of(EFFECTS["bearing_ball_pass"](), Residuals(base))
    assert found[0].nonlinear["order"] == pytest.approx(order, abs=0.01)


@pytest.mark.parametrize(
    ("constant_arcsec", "confirmed"),
    [pytest.param(0.5, False, marks=pytest.mark.large), (5.0, True)],
)
def test_a_constant_that_the_interpolation_may_have_is_no_head_angle(
    constant_arcsec: float, confirmed: bool
) -> None:
    """The diagnosis names no misplaced head for a constant that interpolation errors may cause.

    If the phase between the two signals of a head differs by ψ from 90°, the reading gets the error
    ψ/2·(1 ± cos 2φ): a constant and a wave of equal size, here 1″. Each head may have this constant
    of 1″, so that a constant of up to 2″ in R₂ − R₁ does not prove a misplaced head.
    """
    made = measurement_set(electrical=lambda phase: np.cos(2.0 * phase), reference=False)
    assert made.capture is not None
    made.capture.head2_counts[:] += round(constant_arcsec / COUNT_ARCSEC)
    names = ("graduation_harmonics", "subdivision_error", "head_angle_error")
    effects = {name: EFFECTS[name] for name in names}
    model = [
        Term(effects["graduation_harmonics"](), {}),
        Term(effects[names[1]](multiples=[2]), {}),
    ]
    residuals = Residuals(fit(model, observations_of(made)))
    found = survey(residuals, effects, 0.5 * COUNT_ARCSEC, lambda text: None)
    first = next(item for item in found.candidates if item.name == "head_angle_error")
    assert first.p_corrected < 1e-4
    assert found.confirmed(first) == confirmed
