"""Tests of identifiability: undetermined and correlated coefficients, and smallest detectable
sizes."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from sim.tests.workbench.small_sets import (
    ALPHA,
    CAPTURE_NOISE,
    COUNTS_PER_REV,
    RUNS,
    SAMPLES_A_TURN,
    TURNS,
    Float,
    measurement_set,
)

from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.part_conditions import ALWAYS
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.detectable import needed_gain
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.identifiability import identifiability
from arctrue.workbench.inference.likelihood_ratio import Null, evidence
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

EFFECTS = built_in()


def _graduation(**settings: object) -> Term:
    return Term(EFFECTS["graduation_harmonics"](**settings), {})


def test_blind_order_and_unseparable_motion_are_reported() -> None:
    alone = observations_of(measurement_set(runs=1, reference=False))
    reported = identifiability(fit([_graduation(orders=[1, 2, 120])], alone))
    assert reported.undetermined == [
        "graduation_harmonics: cos 120",
        "graduation_harmonics: sin 120",
    ]
    assert reported.rank == 4 + 1
    motion = Term(EFFECTS["radial_error_motion"](orders=[2]), {})
    # Without a reference, the difference determines only two of the six columns of order 2.
    reported = identifiability(fit([_graduation(orders=[1, 2]), motion], alone))
    assert any("2" in name for name in reported.undetermined)
    both = observations_of(measurement_set())
    assert identifiability(fit([_graduation()], both)).undetermined == []


def test_weak_orders_are_the_weakest() -> None:
    reported = identifiability(
        fit([_graduation()], observations_of(measurement_set(reference=False)))
    )
    # At 33° the heads magnify order 11 by a factor of 19, and the other 19 orders by less than 2.
    assert {name.split()[-1] for name in list(reported.weakest)[:2]} == {"11"}
    sigma = next(iter(reported.weakest.values()))
    rows = len(RUNS) * SAMPLES_A_TURN * TURNS
    expected = np.sqrt(2.0 / rows * 2.0 * (CAPTURE_NOISE**2 + 0.0772**2 / 12.0)) / abs(
        np.exp(11j * np.radians(33.0)) - 1.0
    )
    assert sigma == pytest.approx(expected, rel=0.05)


def test_half_a_turn_correlates_what_a_turn_keeps_apart() -> None:
    made = measurement_set(runs=1, reference=False)
    assert made.capture is not None
    half = {
        name: getattr(made.capture, name)[: SAMPLES_A_TURN // 2]
        for name in ("run", "time_s", "head1_counts", "head2_counts", "temperature_c")
    }
    cut = observations_of(replace(made, capture=replace(made.capture, **half)))
    orders = [1, 2, 3, 4]
    assert identifiability(fit([_graduation(orders=orders)], cut)).correlated
    whole = observations_of(made)
    assert not identifiability(fit([_graduation(orders=orders)], whole)).correlated


@pytest.mark.large
def test_smallest_effect_is_found_in_nearly_all_sets_and_half_of_it_in_fewer() -> None:
    absent = {"hysteresis": EFFECTS["hysteresis"]}
    base = fit([_graduation()], observations_of(measurement_set(runs=1, cycles=2)))
    smallest = identifiability(base, absent).smallest_arcsec["hysteresis"]["reference"]
    needed = needed_gain(1, 1)
    # For one column at 1 %, the threshold has z = 2.576 and the power adds z = 1.645.
    assert needed == pytest.approx((2.5758 + 1.6449) ** 2, rel=1e-3)
    found = {1.0: 0, 0.4: 0}
    for size in found:
        for seed in range(25):
            # Half of the reversal error acts in each direction, so that the RMS of the effect is
            # half of the reversal error.
            made = measurement_set(
                runs=1, cycles=2, seed=seed, reversal_arcsec=2.0 * smallest * size
            )
            residuals = Residuals(fit([_graduation()], observations_of(made)))
            # As in the diagnosis, the noise is estimated again with the effect in the model.
            null = Null(residuals)
            found[size] += evidence(null, EFFECTS["hysteresis"](), {}).gain > 6.635
    # 95 % of 25 are 23.75; the probability of fewer than 20 is 1/800. At 0.4 of the size, 19 % are
    # expected.
    assert found[1.0] >= 20
    assert found[0.4] <= 14


def test_canonical_correlations_against_numpy() -> None:
    observations = observations_of(measurement_set(runs=2, reference=False))
    model = [_graduation(orders=[1, 2])]
    noise = white_noise(observations, (0.1, None))
    residuals = Residuals(fit(model, observations, noise=noise))
    rows = observations.capture
    assert rows is not None
    first = Term(ProductOfParts.of(ALWAYS, (3.0,), "head2"), {})
    second = Term(ProductOfParts.of(ALWAYS, (2.9, 4.0), "head2"), {})
    found = canonical_correlations(residuals, first, second)

    base = np.hstack(
        [
            EFFECTS["graduation_harmonics"](orders=[1, 2]).capture_columns(
                rows, {}, residuals.solution.context
            ),
            np.eye(2)[rows.run],
        ]
    )
    bases = []
    for orders in ((3.0,), (2.9, 4.0)):
        waves = [wave(k * rows.angle_rad) for k in orders for wave in (np.cos, np.sin)]
        columns = np.stack(waves, axis=1)
        columns = columns - base @ np.linalg.lstsq(base, columns, rcond=None)[0]
        bases.append(np.linalg.qr(columns)[0])
    expected = np.linalg.svd(bases[0].T @ bases[1], compute_uv=False)
    # The prior of the index constrains the offsets of the runs, which numpy's computation lacks;
    # this causes a difference of 1 in 10⁴.
    np.testing.assert_allclose(found, expected, atol=2e-3)
    assert 0.3 < found[0] < 0.999


def test_an_effect_is_wholly_like_itself_and_unlike_another_order() -> None:
    residuals = Residuals(fit([_graduation(orders=[1])], observations_of(measurement_set(runs=1))))
    three, five = (Term(ProductOfParts.of(ALWAYS, (k,), "disc"), {}) for k in (3.0, 5.0))
    np.testing.assert_allclose(canonical_correlations(residuals, three, three), 1.0, atol=1e-6)
    assert np.max(canonical_correlations(residuals, three, five)) < 0.1
    inside = Term(ProductOfParts.of(ALWAYS, (1.0,), "disc"), {})
    # A column that the model already spans has no canonical direction.
    assert canonical_correlations(residuals, inside, three).size == 0


X_ARCSEC, Y_ARCSEC, MOTION_ORDER = 4.0, 0.8, 3
SIGMAS = 5.0
"""Largest accepted deviation in stated standard uncertainties; a value exceeds it with p < 10⁻⁶."""


def _moving_axis() -> MeasurementSet:
    """Return a set whose axis moves by x = 4.0″ and y = 0.8″ at order 3, from the geometry of the
    heads: head 1 reads y, head 2 reads x sin α + y cos α."""

    def motion(angle: Float) -> tuple[Float, Float]:
        return X_ARCSEC * np.cos(MOTION_ORDER * angle), Y_ARCSEC * np.sin(MOTION_ORDER * angle)

    measured = measurement_set()
    capture, reference = measured.capture, measured.reference
    assert capture is not None
    assert reference is not None
    to_rad = 2.0 * np.pi / COUNTS_PER_REV
    x, y = motion(to_rad * capture.head1_counts)
    for counts, moved in (
        (capture.head1_counts, y),
        (capture.head2_counts, x * np.sin(ALPHA) + y * np.cos(ALPHA)),
    ):
        counts += np.round(moved / 3600.0 / 360.0 * COUNTS_PER_REV).astype(np.int64)
    reference.error_arcsec[:] += motion(np.radians(reference.target_deg))[1]
    return measured


@pytest.mark.parametrize("grown", [False, True], ids=["fitted", "from the score"])
def test_motion_that_the_disc_may_replace_has_no_uncertainty(grown: bool) -> None:
    """For each order, two heads and a reference give four numbers for six unknowns: cosine and sine
    of x, of y and of the graduation.

    Without order 3 of the disc in the model, x and y are determined.
    """
    observations = observations_of(_moving_axis())
    motion = Term(EFFECTS["radial_error_motion"](orders=[MOTION_ORDER]), {})
    if grown:
        residuals = Residuals(fit([_graduation()], observations))
        score = residuals.score(motion.effect, {})
        solution = residuals.solution_with(motion.effect, {}, score)
    else:
        solution = fit([_graduation(), motion], observations)
    disc, axis = solution.parameters()
    for name in ("x_cos_3", "x_sin_3", "y_cos_3", "y_sin_3"):
        assert np.isnan(axis[name].sigma), axis[name]
    assert np.isnan(disc["order_3_amplitude"].sigma)
    assert disc["order_2_amplitude"].sigma > 0.0
    angle = np.linspace(0.0, 2.0 * np.pi, 12, endpoint=False)
    # Order 3 of the small set's disc is a graduation, so that it does not count.
    expected = X_ARCSEC * np.sin(ALPHA) * np.cos(3.0 * angle)
    expected += Y_ARCSEC * (np.cos(ALPHA) * np.sin(3.0 * angle) - np.sin(3.0 * (angle + ALPHA)))
    for name, wave in (("cos", np.cos), ("sin", np.sin)):
        found = axis[f"separable_{name}_3"]
        truth = 2.0 * float(np.mean(expected * wave(3.0 * angle)))
        assert abs(found.value - truth) < SIGMAS * found.sigma
        assert found.sigma < 0.2
    left_out = fit([_graduation(orders=[1, 2, 5]), motion], observations)
    assert all(item.sigma > 0.0 for values in left_out.parameters() for item in values.values())
