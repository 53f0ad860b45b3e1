"""Tests that one term of equation (9) in VHDL equals its model; a picture shows the term's error
and the bounds."""

from pathlib import Path

import numpy as np
import pytest

from arctrue.gateware.table_rotation import error_bound
from arctrue.report.cordic_error import cosine_error, draw_cordic_error
from arctrue.studies.paper.appendix import cosine_bound
from tb.harmonic.harmonic_generics import DEFAULT, OTHERS, environment, generics
from tb.support.simulation import ROOT, simulate

BENCH = "tb.harmonic.harmonic_lane_bench"


@pytest.mark.parametrize("add_partner", [pytest.param("false", marks=pytest.mark.large), "true"])
@pytest.mark.parametrize(("width", "iterations"), OTHERS[:2])
def test_other_generics(width: int, iterations: int, add_partner: str) -> None:
    values = generics(width, iterations)
    simulate(
        "harmonic_lane",
        BENCH,
        generics={**values, "ADD_PARTNER": add_partner},
        environment=environment(**values, ADD_PARTNER=add_partner, ANGLES=2500),
    )


@pytest.mark.parametrize("add_partner", ["false", pytest.param("true", marks=pytest.mark.large)])
def test_from_the_table(add_partner: str, tmp_path: Path) -> None:
    """The error of the cosine from the table stays within the sum of the errors that the header of
    table_rotation states."""
    file = tmp_path / "cosines.npz"
    generics = {"ADD_PARTNER": add_partner, "ROTATION": "table"}
    simulate(
        "harmonic_lane",
        BENCH,
        generics=generics,
        environment=environment(**generics, ANGLES=20_000, COSINES_FILE=str(file)),
    )
    with np.load(file) as simulated:
        error = cosine_error(simulated["phase"], simulated["cosine"])
    assert np.abs(error).max() <= error_bound()


@pytest.mark.large
@pytest.mark.parametrize("add_partner", ["false", "true"])
def test_default_on_20000_phases(add_partner: str, tmp_path: Path) -> None:
    file = tmp_path / "cosines.npz"
    simulate(
        "harmonic_lane",
        BENCH,
        generics={"ADD_PARTNER": add_partner},
        environment=environment(ADD_PARTNER=add_partner, ANGLES=20_000, COSINES_FILE=str(file)),
    )
    with np.load(file) as simulated:
        phase, cosine = simulated["phase"], simulated["cosine"]
    assert phase.size >= 20_000
    assert np.abs(cosine_error(phase, cosine)).max() <= cosine_bound(*DEFAULT)
    picture = ROOT / "build" / "reports" / "cordic_error.png"
    draw_cordic_error(picture, (phase, cosine))
    assert picture.stat().st_size > 20_000
