"""Tests of the import of a periodic error: a file with times and errors, but no angle."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.importing.choices import AmbiguousError, Choices
from arctrue.importing.questions import Import
from arctrue.importing.reader import ReadSettings
from arctrue.importing.settings import Settings
from arctrue.measurement import Reference

TIME_S = 2.0 * np.arange(300)
ERROR_ARCSEC = np.round(7.0 * np.sin(2.0 * np.pi * TIME_S / 480.0), 2)


def _imported(path: Path, **stated: object) -> Reference:
    settings = Settings(sign="reading-true", **stated)  # type: ignore[arg-type]
    found = Import([path], "", ReadSettings(), settings).run(Choices()).measurement.reference
    assert found is not None
    return found


@pytest.fixture
def named(tmp_path: Path) -> Path:
    rows = [f"{t:.2f},{e:.2f}" for t, e in zip(TIME_S, ERROR_ARCSEC, strict=True)]
    (tmp_path / "pe.csv").write_text("\n".join(["Time [s],Error [arcsec]", *rows]) + "\n")
    return tmp_path / "pe.csv"


def test_the_speed_of_the_axis_gives_its_angle(named: Path) -> None:
    found = _imported(named, rate_deg_s=0.25)
    np.testing.assert_allclose(found.target_deg, 0.25 * TIME_S, atol=1e-9)
    np.testing.assert_allclose(found.error_arcsec, ERROR_ARCSEC, atol=1e-9)
    assert found.time_s is not None
    np.testing.assert_array_equal(found.time_s, TIME_S)


def test_without_a_speed_the_message_states_the_option(named: Path) -> None:
    """An axis that follows the stars turns by 360° in a sidereal day of 86,164.0905 s."""
    with pytest.raises(AmbiguousError, match=r"--rate 0\.004178075"):
        _imported(named)
    assert pytest.approx(360.0 / 86_164.0905, rel=1e-6) == 0.004178075


def test_columns_without_names_need_three_options(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "pe.txt", np.column_stack([TIME_S, ERROR_ARCSEC]), fmt="%.2f")
    with pytest.raises(AmbiguousError, match=r"--column time=.*--column error=.*--rate"):
        _imported(tmp_path / "pe.txt")
    found = _imported(
        tmp_path / "pe.txt",
        columns={"time": "1", "error": "2"},
        units={"time": "s", "error": "arcsec"},
        rate_deg_s=0.25,
    )
    np.testing.assert_allclose(found.target_deg, 0.25 * TIME_S, atol=1e-9)


def test_a_speed_of_zero_is_refused(named: Path) -> None:
    with pytest.raises(ValueError, match="other than 0"):
        _imported(named, rate_deg_s=0.0)
