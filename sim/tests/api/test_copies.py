"""Tests that results can be pickled and copied, and that nobody can change a stored result."""

from __future__ import annotations

import copy
import pickle

import numpy as np
import pytest

import arctrue as at

AMPLITUDE = "graduation_harmonics.order_1_amplitude"
MODEL = at.Model().having(graduation_harmonics={"orders": [1, 2]})


@pytest.fixture(scope="module")
def data() -> at.Dataset:
    angle = np.tile(np.arange(24) * 15.0, 4)
    noise = np.random.default_rng(2).normal(0.0, 0.01, angle.size)
    return at.Dataset.from_arrays(
        reference={"target_deg": angle, "error_arcsec": 2.0 * np.cos(np.deg2rad(angle)) + noise}
    )


@pytest.mark.large
def test_a_fit_survives_pickle_and_deepcopy(data: at.Dataset) -> None:
    found = at.fit(
        data,
        MODEL,
        bounds={AMPLITUDE: (0.0, 3.0)},
        fix={"graduation_harmonics.order_2_amplitude": 0.01},
    )
    expected = found.params[AMPLITUDE].interval()
    assert len(found.correlations)
    for again in (pickle.loads(pickle.dumps(found)), copy.deepcopy(found)):
        assert again.params.valuesdict() == found.params.valuesdict()
        assert again.params[AMPLITUDE].interval() == pytest.approx(expected, abs=1e-6)
        assert dict(again.correlations) == dict(found.correlations)
        np.testing.assert_array_equal(again.predict([10.0]), found.predict([10.0]))


def test_an_estimator_survives_pickle(data: at.Dataset) -> None:
    estimator = at.FitEstimator(MODEL).fit(data)
    again = pickle.loads(pickle.dumps(estimator))
    np.testing.assert_array_equal(again.predict([10.0]), estimator.predict([10.0]))


def test_a_comparison_survives_pickle(data: at.Dataset) -> None:
    found = at.compare(data, MODEL)
    assert pickle.loads(pickle.dumps(found)).data == found.data


def test_a_diagnosis_survives_pickle(data: at.Dataset) -> None:
    found = at.diagnose(data, MODEL)
    again = pickle.loads(pickle.dumps(found))
    assert (again.verdict, again.data) == (found.verdict, found.data)


def test_the_covariance_cannot_be_changed(data: at.Dataset) -> None:
    found = at.fit(data, MODEL)
    with pytest.raises(ValueError, match="read-only"):
        found.covariance[0, 0] = 1.0
    with pytest.raises(TypeError):
        found.correlations[AMPLITUDE, AMPLITUDE] = 1.0  # type: ignore[index]


def test_scikit_learn_knows_whether_it_is_fitted(data: at.Dataset) -> None:
    validation = pytest.importorskip("sklearn.utils.validation")
    exceptions = pytest.importorskip("sklearn.exceptions")
    estimator = at.FitEstimator(MODEL)
    with pytest.raises(exceptions.NotFittedError):
        validation.check_is_fitted(estimator)
    validation.check_is_fitted(estimator.fit(data))


def test_a_model_and_its_results_are_short_texts(data: at.Dataset) -> None:
    """A terminal shows the names of the effects instead of every coefficient."""
    found = at.fit(data, MODEL)
    assert repr(found.model) == "Model(effects=['graduation_harmonics'])"
    assert str(found) == found.fit_report()
    assert "coefficients" not in repr(at.FitEstimator(found.model))
