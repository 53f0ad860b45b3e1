"""Tests that the diagnosis of a long reference run, which searches in a part of the rows and then
fits every row, gives the same answer as a search in all rows."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference import design_matrix
from arctrue.workbench.inference.design_matrix import (
    BLOCK_ROWS,
    Term,
    block_columns,
    row_blocks,
)
from arctrue.workbench.inference.every_row import channel_figures, on_every_row
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.noise.row_noise import Factor
from arctrue.workbench.observations import Observations, part
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]
EFFECTS = built_in()
ROWS = 40_000
LIMIT = 10_000
ORDER = 37.3
NOISE_ARCSEC = 0.3


def _line(angle: Float) -> Float:
    return 0.05 * np.cos(ORDER * angle)


def _observations(limit: int, *, with_time: bool = True) -> Observations:
    """Return two runs of five turns, with a sine whose order lies between two integers."""
    random = np.random.default_rng(8)
    way = np.arange(ROWS // 2) * (5.0 * 360.0 / (ROWS // 2))
    target = np.concatenate([way, way[::-1]])
    angle = np.radians(target)
    error = 4.0 * np.cos(angle + 0.3) + _line(angle)
    rows = Reference(
        target_deg=target,
        error_arcsec=error + random.normal(0.0, NOISE_ARCSEC, ROWS),
        run=np.repeat([0, 1], ROWS // 2),
        time_s=np.arange(ROWS) * 0.01 if with_time else None,
    )
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(part, "MOST_ROWS", limit)
        made = MeasurementSet(Table(), None, rows, title="long")
        return observations_of(made, mask_outliers=False)


def _base() -> Term:
    return Term(EFFECTS["graduation_harmonics"](), {})


def test_the_part_is_stretches_of_every_run() -> None:
    observations = _observations(LIMIT, with_time=False)
    rows, whole = observations.reference, observations.stored_reference
    assert rows is not None
    assert whole is not None
    assert whole.run.size == ROWS
    assert rows.row is not None
    assert 0.8 * LIMIT <= rows.run.size <= LIMIT
    assert set(np.unique(rows.run)) == {0, 1}
    # Rows keep their numbers in the whole reference, so that the noise does not continue over a
    # gap.
    np.testing.assert_array_equal(rows.target_rad, whole.target_rad[rows.row])
    noise = fit([_base()], observations).noise.reference
    assert noise is not None
    assert float(noise.clock[-1]) == rows.row[-1]


def _all_at_once(searched: Solution) -> Solution:
    observations = _observations(10**9)
    noise = searched.noise.on(observations)
    return fit([_base()], observations, searched.context, noise=noise)


def _estimator(whole: Solution, blocks: Iterable[slice]) -> Float:
    """Return the matrix of generalised least squares for noise that is uncorrelated between blocks.

    It is (XᵀV⁻¹X)⁻¹XᵀV⁻¹, where X has the columns and a constant; only the rows of the coefficients
    are returned.
    """
    rows, noise = whole.observations.reference, whole.noise.reference
    assert rows is not None
    assert noise is not None
    (spectrum,) = noise.spectra
    columns = block_columns(whole.terms, whole.widths, rows, whole.context)
    columns = np.column_stack([columns, np.ones(rows.run.size)])
    precise, normal = np.empty_like(columns), np.zeros((columns.shape[1], columns.shape[1]))
    for block in blocks:
        factor = Factor(np.ascontiguousarray(noise.clock[block]), spectrum)
        whitened = factor.whiten(columns[block])
        precise[block] = factor.unwhiten_transposed(whitened)
        normal += whitened.T @ whitened
    return np.asarray(np.linalg.solve(normal, precise.T)[:-1])


@pytest.mark.parametrize("block_rows", [BLOCK_ROWS, pytest.param(10**6, marks=pytest.mark.large)])
def test_every_row_gives_the_fit_of_the_whole(block_rows: int) -> None:
    """With a single block, the fit in blocks equals the fit of all rows, because both compute the
    same sum. With more blocks, the correlation is cut at the end of each block.

    The cut changes the weights of the rows: it changes the coefficients by D·rows, where D is the
    difference of both estimators. White noise of ``NOISE_ARCSEC`` gives this change the standard
    uncertainty NOISE_ARCSEC·|D|, which for order 1 is 0.043 of the coefficient's own uncertainty.
    The sine of order 37.3 in the rows adds D times this sine.
    """
    searched = fit([_base()], _observations(LIMIT))
    whole = _all_at_once(searched)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design_matrix, "BLOCK_ROWS", block_rows)
        streamed = on_every_row(searched)
        figures = channel_figures(streamed, "reference")
        cut = _estimator(whole, row_blocks(ROWS))
    expected = channel_figures(whole, "reference")
    assert figures is not None
    assert expected is not None
    assert figures.rows == expected.rows == ROWS
    assert figures.rms_arcsec == pytest.approx(expected.rms_arcsec, rel=1e-4)
    sigma = np.sqrt(np.diag(whole.covariance))
    rows = whole.observations.reference
    assert rows is not None
    rounding = 1e-6 * sigma
    np.testing.assert_array_less(
        np.abs(streamed.coefficients - cut @ rows.measured_arcsec), rounding
    )
    change = cut - _estimator(whole, [slice(0, ROWS)])
    moved = streamed.coefficients - whole.coefficients - change @ _line(rows.target_rad)
    moved_sigma = NOISE_ARCSEC * np.linalg.norm(change, axis=1)
    np.testing.assert_array_less(np.abs(moved), 4.0 * moved_sigma + rounding)
    assert (moved_sigma.max() > rounding.max()) == (block_rows < ROWS)
    np.testing.assert_allclose(np.sqrt(np.diag(streamed.covariance)), sigma, rtol=0.01)
    # The part has a quarter of the rows, so that its uncertainty is twice as large.
    assert np.median(np.sqrt(np.diag(searched.covariance)) / sigma) == pytest.approx(2.0, rel=0.1)


def test_a_line_is_found_in_the_part_and_measured_in_all_rows() -> None:
    model = Model([ModelEffect("graduation_harmonics"), ModelEffect("periodic_error")])
    grown, solution = fitted(model, _observations(LIMIT), EFFECTS)
    assert solution.every_row
    order = grown.effects[1].parameters["order"]
    # This is the Cramér–Rao bound for two runs of five turns, each with half of the rows, and one
    # common phase.
    least_sigma = np.sqrt(6.0 / ROWS) * NOISE_ARCSEC / (np.pi * 0.05 * 5.0)
    assert order.sigma == pytest.approx(least_sigma, rel=0.2)
    assert order.value == pytest.approx(ORDER, abs=4.0 * least_sigma)
