"""Tests that ``arctrue calibrate --angle mean`` writes words with which the mean of four heads
gives the true angle."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

from arctrue.calibration.mean_banks import mean_angle_counts
from arctrue.cli import main
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import read_coefficient_file
from arctrue.measurement import write_measurement_set
from arctrue.studies.simulate.experiment import EXPERIMENTS
from arctrue.studies.simulate.simulated_set import SimulatedSet, Wanted, simulate_set
from arctrue.table import TableState


@pytest.fixture(scope="module")
def made() -> SimulatedSet:
    wanted = [Wanted("bearing_ball_pass", 0.25), Wanted("radial_error_motion", 0.2)]
    return simulate_set(wanted, EXPERIMENTS["lean"](), 4, heads=4)


def run(*words: str | Path) -> tuple[int, str]:
    answer = CliRunner().invoke(main, ["calibrate", *map(str, words)])
    return answer.exit_code, answer.output


def test_the_words_that_are_written_give_the_true_angle(tmp_path: Path, made: SimulatedSet) -> None:
    write_measurement_set(tmp_path / "set", made.measurement)
    code, said = run(
        tmp_path / "set", "--angle", "mean", "--orders", "12",
        "--out", tmp_path / "out", "--json", tmp_path / "mean.json",
    )  # fmt: skip
    assert code == 0, said
    assert "no set for a missing head" in said
    found = json.loads((tmp_path / "mean.json").read_text("utf-8"))
    assert found["noise_arcsec"] == pytest.approx(np.hypot(0.1, 0.0223), rel=0.05)
    coefficients = read_coefficient_file(tmp_path / "out" / "coefficients.toml", EVERYTHING)
    # The words correct a turn in which the axis is at another place; readings have no noise and no
    # rounding.
    angle = np.linspace(40.0, 46.0, 4001)
    state = TableState.at_rest(angle)
    table = made.table
    exact = np.array([table.reading_rad(head, state) for head in range(4)]) / table.count_rad
    counts = np.rint(exact).astype(np.int64)
    weights = np.array(found["weights"])
    shown = mean_angle_counts(coefficients, counts) - weights @ (counts - exact)
    left = (shown - angle / table.count_rad + (1 << 23)) % (1 << 24) * 0.07724762
    # Each of the 11 orders has u ≤ 0.0023″, and the error of the radii adds 4e-5 of the 100″ at
    # order 1. With two heads an error of 0.7″ would remain.
    assert np.std(left) < 0.04
    alone = (exact[0] - angle / table.count_rad) * 0.07724762
    assert np.std(alone) > 10.0


def test_head_1_alone_says_that_there_are_more(tmp_path: Path, made: SimulatedSet) -> None:
    write_measurement_set(tmp_path / "set", made.measurement)
    code, said = run(tmp_path / "set", "--orders", "8", "--out", tmp_path / "out")
    assert code in (0, 1), said
    assert "--angle mean uses all" in said


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (["--motion", "1-8"], "--motion is for --angle mean"),
        (["--angle", "mean", "--motion", "many"], "expected every, none, or orders"),
        (["--angle", "mean", "--motion", "8-2"], "orders such as 1-8 (first ≤ last)"),
        (["--angle", "mean", "--method", "fourier"], "--method is for --angle head1"),
    ],
)
def test_options_that_do_not_belong_together_are_refused(
    tmp_path: Path, made: SimulatedSet, words: list[str], expected: str
) -> None:
    write_measurement_set(tmp_path / "set", made.measurement)
    code, said = run(tmp_path / "set", *words, "--out", tmp_path / "out")
    assert code == 2
    assert expected in " ".join(said.split())


def test_two_heads_at_33_degrees_have_no_mean(tmp_path: Path) -> None:
    two = simulate_set([], EXPERIMENTS["lean"](), 4)
    write_measurement_set(tmp_path / "set", two.measurement)
    code, said = run(tmp_path / "set", "--angle", "mean", "--out", tmp_path / "out")
    assert code == 2
    assert "must stand at 180°" in " ".join(said.split())
