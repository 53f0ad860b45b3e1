"""Tests that ``FitEstimator`` follows scikit-learn's conventions: clone and grid search accept
it."""

from __future__ import annotations

import numpy as np
import pytest

import arctrue as at

NAME = "graduation_harmonics.order_1_amplitude"


@pytest.fixture(scope="module")
def data() -> at.Dataset:
    angle = np.tile(np.arange(24) * 15.0, 4)
    error = 2.0 * np.cos(np.deg2rad(angle)) + 0.01 * np.sin(np.arange(96))
    return at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error})


@pytest.fixture
def estimator() -> at.FitEstimator:
    return at.FitEstimator(
        at.Model().having(graduation_harmonics={"orders": [1]}), bounds={NAME: (0.0, 1.5)}
    )


def test_parameters_are_those_of_the_constructor(estimator: at.FitEstimator) -> None:
    found = estimator.get_params()
    assert set(found) == {"model", "fix", "bounds", "tie"}
    again = type(estimator)(**found)
    assert all(again.get_params()[name] is value for name, value in found.items())
    assert estimator.set_params(fix={NAME: 1.0}) is estimator
    assert estimator.get_params(deep=False)["fix"] == {NAME: 1.0}
    with pytest.raises(ValueError, match=r"fixed is not a parameter.*fix"):
        estimator.set_params(tie=None, fixed={})
    assert "bounds=" in repr(estimator)
    assert "tie" not in repr(estimator)


def test_it_fits_and_predicts_as_the_function(data: at.Dataset, estimator: at.FitEstimator) -> None:
    with pytest.raises(ValueError, match="not fitted yet"):
        estimator.predict([0.0])
    assert estimator.fit(data) is estimator
    same = at.fit(data, estimator.model, bounds=estimator.bounds)
    assert estimator.result_.params[NAME].value == same.params[NAME].value
    assert same.params[NAME].value <= 1.5 + 1e-9
    np.testing.assert_array_equal(estimator.predict([0.0, 90.0]), same.predict([0.0, 90.0]))


def test_scikit_learn_clones_it_and_walks_a_grid(
    data: at.Dataset, estimator: at.FitEstimator
) -> None:
    base = pytest.importorskip("sklearn.base")
    selection = pytest.importorskip("sklearn.model_selection")
    estimator.fit(data)
    copy = base.clone(estimator)
    assert not hasattr(copy, "result_")
    # clone() copies the model, like every parameter that is not an estimator; all other parameters
    # of the clone are equal to the original ones.
    assert copy.get_params()["bounds"] == estimator.bounds
    values = [
        copy.set_params(**point).fit(data).result_.params[NAME].value
        for point in selection.ParameterGrid({"bounds": [None, {NAME: (0.0, 1.0)}]})
    ]
    assert values == pytest.approx([2.0, 1.0], abs=0.01)
