"""Tests probabilities of Student's t and of F against scipy.stats."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from scipy import stats

from arctrue.workbench.numeric.distributions import (
    f_limit,
    student_limit,
    student_log_density,
    student_quantile,
    student_upper_p,
)


@pytest.mark.parametrize("freedom", [1.0, 2.5, 30.0, 1e5, np.inf])
@pytest.mark.parametrize("p", [1e-12, 1e-4, 0.05, 0.4])
def test_student(freedom: float, p: float) -> None:
    limit = stats.t.isf(p, freedom)
    assert student_limit(p, freedom) == pytest.approx(limit, rel=1e-8)
    assert student_upper_p(limit, freedom) == pytest.approx(p, rel=1e-7)
    assert student_quantile(1.0 - p, freedom) == pytest.approx(
        stats.t.ppf(1.0 - p, freedom), rel=1e-6
    )


def test_density() -> None:
    values = np.linspace(-30.0, 30.0, 61)
    for freedom in (1.0, 3.0, 200.0):
        expected = stats.t.logpdf(values, freedom)
        assert student_log_density(values, freedom) == pytest.approx(expected, rel=1e-10)


@pytest.mark.parametrize("p", [1e-30, 1e-12, 1e-4, 0.05])
@pytest.mark.parametrize(("above", "below"), [(1, 3.0), (2, 10.5), (24, 300.0), (3, 1e4)])
def test_f(p: float, above: int, below: float) -> None:
    limit = f_limit(p, above, below)
    assert stats.f.sf(limit, above, below) == pytest.approx(p, rel=1e-6)


def test_a_diagnosis_does_not_import_scipy_stats() -> None:
    """A diagnosis does without scipy.stats, because its import would take a large part of a
    command's start."""
    program = "import sys; import arctrue.cli.diagnose; sys.exit('scipy.stats' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0
