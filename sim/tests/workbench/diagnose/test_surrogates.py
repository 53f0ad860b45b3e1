"""The closed form over all surrogates against surrogates themselves."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from arctrue.workbench.diagnose.parts import ALWAYS, TEMPERATURE, settling_condition
from arctrue.workbench.diagnose.parts_scan import HIGHEST_ORDER, condition_shares, level_share
from arctrue.workbench.diagnose.surrogates import mean_square_moment


@pytest.mark.parametrize("lengths", [(5, 4), (1, 6), (7,)])
def test_the_closed_form_is_the_mean_over_every_shift_and_sign(lengths: tuple[int, ...]) -> None:
    random = np.random.default_rng(4)
    bounds = np.cumsum([0, *lengths]).tolist()
    groups = [slice(start, end) for start, end in itertools.pairwise(bounds)]
    residual = random.normal(size=bounds[-1]) + 0.7
    columns = random.normal(size=(bounds[-1], 2))
    total, count = np.zeros((2, 2)), 0
    for shifts in itertools.product(*(range(length) for length in lengths)):
        for signs in itertools.product((-1.0, 1.0), repeat=len(lengths)):
            made = np.concatenate(
                [
                    sign * np.roll(residual[group], shift)
                    for group, shift, sign in zip(groups, shifts, signs, strict=True)
                ]
            )
            moment = columns.T @ made
            total += np.outer(moment, moment)
            count += 1
    found = mean_square_moment(groups, residual, columns)
    np.testing.assert_allclose(found, total / count, rtol=1e-12)


def test_the_shares_of_the_level_add_up_to_one() -> None:
    """Else the products of parts would together be allowed more false alarms than stated."""
    orders = [None, *(np.arange(1, 2 * HIGHEST_ORDER + 1) / 2.0)]
    assert sum(level_share(order) for order in orders) == pytest.approx(1.0)


def test_each_octave_of_orders_has_about_the_same_share() -> None:
    """Sums of 1/k over an octave are log 2, within a term at its end."""
    octaves = [
        sum(level_share(order) for order in np.arange(low, 2 * low, 0.5)) for low in (2.0, 4.0, 8.0)
    ]
    assert max(octaves) < 1.2 * min(octaves)


def test_all_time_constants_of_a_settling_share_what_a_temperature_has() -> None:
    settlings = [settling_condition(constant, True) for constant in (1.0, 3.0, 9.0)]
    shares = condition_shares([ALWAYS, TEMPERATURE, *settlings])
    assert sum(shares) == pytest.approx(1.0)
    assert sum(shares[2:]) == pytest.approx(shares[1])
