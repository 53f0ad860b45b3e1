"""Tests that the export writes a scratch of a fitted model into the gateware's local table."""

from __future__ import annotations

import json
import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as _run

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import load_frames
from arctrue.gateware.capability import EVERYTHING
from arctrue.gateware.coefficient_file import (
    CoefficientFileError,
    read_coefficient_file,
    write_coefficient_file,
)
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet
from arctrue.measurement import MeasurementSet, Reference, Table, write_measurement_set
from arctrue.workbench.effects.base import LocalError
from arctrue.workbench.effects.catalogue.graduation_defect import GraduationDefect
from arctrue.workbench.model.export import export_model
from arctrue.workbench.model.local_errors import at_heads_of_mean, table_of, taken_off_arcsec
from arctrue.workbench.model.model import Model, ModelEffect
from arctrue.workbench.model.taken_away import outcome
from arctrue.workbench.observations.build import observations_of

from .small_sets import Float, measurement_set, paper_error

TURN = 1 << 24
COUNT_ARCSEC = 1_296_000 / TURN
PLACE_DEG, WIDTH_DEG, HEIGHT_ARCSEC = 84.0, 0.6, -12.0


def bell(place_deg: float, width_deg: float, height_arcsec: float) -> LocalError:
    def error(reading_rad: np.ndarray) -> np.ndarray:
        away = np.angle(np.exp(1j * (reading_rad - np.radians(place_deg))))
        return np.asarray(height_arcsec * np.exp(-0.5 * (away / np.radians(width_deg)) ** 2))

    return LocalError(np.radians(place_deg), 5.0 * np.radians(width_deg), error)


@pytest.mark.parametrize(
    ("places_deg", "widths_deg", "windows", "exponent"),
    [
        ([359.9], [0.15], 1, 6),
        ([10.0, 200.0], [0.15, 0.4], 2, 6),
        ([10.0, 11.0, 200.0], [0.3, 1.0, 0.3], 2, 5),
        ([10.0, 80.0, 150.0, 220.0, 300.0], [1.0] * 5, 1, 0),
        ([90.0], [9.0], 1, 2),
    ],
)
def test_a_table_takes_bells_off(
    places_deg: list[float], widths_deg: list[float], windows: int, exponent: int
) -> None:
    """The table removes bell-shaped errors: at readings 997 counts apart over the whole turn, the
    difference between table and errors stays within the bound of interpolation and rounding."""
    errors = [bell(p, w, 12.0) for p, w in zip(places_deg, widths_deg, strict=True)]
    table = table_of(errors, TURN)
    assert (len(table.starts_counts), table.width_exponent) == (windows, exponent)
    reading = np.arange(0, TURN, 997) * 2.0 * np.pi / TURN
    total = np.sum([one.error_arcsec(reading) for one in errors], axis=0)
    left = np.abs(total - taken_off_arcsec(table, TURN, reading)).max()
    # The straight lines between the table's points err by step²/8 times the largest curvature; it
    # is h/w² for a bell of height h and width w, and bells may overlap. In addition, points and
    # readings are rounded, and at the end of its window a bell still has e^-12.5 of its height.
    step_deg = 360.0 / 2**exponent / (4096 / windows)
    lines = step_deg**2 / 8.0 * sum(12.0 / width**2 for width in widths_deg)
    steepest = 12.0 * 0.607 / (min(widths_deg) * 3600.0)
    outside = 12.0 * np.exp(-12.5) * len(errors)
    assert left <= lines + COUNT_ARCSEC * (2.0**-table.fraction_bits + steepest) + outside


@pytest.mark.parametrize(
    ("places_deg", "widths_deg", "windows", "exponent"),
    [
        # A window of 5.6 degrees about the first bell would end within the second bell.
        ([100.0, 103.1], [0.03, 0.3], 1, 6),
        # The middle of the second bell would lie at the border of the first bell's window.
        ([100.0, 102.8125], [0.085, 0.085], 1, 6),
        # The windows would overlap, and together the bells exceed the width of one window.
        ([100.0, 105.0], [0.2, 0.2], 1, 5),
        ([358.0, 3.0], [0.2, 0.2], 1, 5),
        # The windows would touch.
        ([10.0, 15.625], [0.1, 0.1], 1, 5),
        # One window begins 0.005 degrees after the end of the other one.
        ([10.0, 15.63], [0.5624, 0.5624], 2, 6),
        # Four windows of a quarter turn would touch: one window of a turn contains all.
        ([0.0, 90.0, 180.0, 270.0], [5.0] * 4, 1, 0),
        ([0.0, 80.0, 180.0, 270.0], [9.1] * 4, 1, 0),
        ([10.0, 11.0, 12.0, 13.0, 14.0, 15.0], [0.1] * 6, 1, 5),
        ([10.0, 100.0, 100.5, 200.0, 300.0], [0.2] * 5, 4, 6),
    ],
)
def test_no_window_ends_within_another_bell(
    places_deg: list[float], widths_deg: list[float], windows: int, exponent: int
) -> None:
    """The host has no objection to the table: from one count to the next, the correction changes by
    at most the change of the errors, plus the rounding of the points and the height of a bell at
    the end of its window."""
    errors = [bell(p, w, 5.0) for p, w in zip(places_deg, widths_deg, strict=True)]
    table = table_of(errors, TURN)
    assert (len(table.starts_counts), table.width_exponent) == (windows, exponent)
    lanes = Coefficients.from_harmonics([], [], [], TURN, 8)
    held = replace(lanes, extension=Extension(local_table=table))
    assert of_limits(held) == []
    width = TURN >> exponent
    # Every count near the ends of the windows and near the middles of the bells.
    ends = [start + end for start in table.starts_counts for end in (0, width)]
    middles = [round(place / 360.0 * TURN) for place in places_deg]
    for middle in [*ends, *middles]:
        reading = np.arange(middle - 20_000, middle + 20_000) * 2.0 * np.pi / TURN
        found = taken_off_arcsec(table, TURN, reading) / COUNT_ARCSEC
        true = sum(one.error_arcsec(reading) for one in errors) / COUNT_ARCSEC
        steepest = np.abs(np.diff(true)).max()
        outside = 5.0 / COUNT_ARCSEC * np.exp(-12.5) * len(errors)
        assert np.abs(np.diff(found)).max() <= steepest + 2.0**-table.fraction_bits + outside


OFFSETS_DEG = (0.0, 64.3, 177.0, 257.9)
WEIGHTS = (0.31, 0.22, 0.3, 0.17)


@pytest.mark.parametrize("heads", [2, 3, 4])
def test_a_scratch_is_taken_away_at_every_head_of_the_mean(heads: int) -> None:
    """The table leaves at most a tenth of a bell that is 20″ high and 0.2° wide, with 2²⁴ counts
    per turn."""
    weights = [round(weight * 65536) for weight in WEIGHTS[:heads]]
    weights[0] += 65536 - sum(weights)
    offsets = [round(place / 360.0 * TURN * 16) for place in OFFSETS_DEG[:heads]]
    mean = MeanSet(tuple(weights), tuple(offsets))
    scratch = bell(84.0, 0.2 / 2.3548, 20.0)
    table = table_of(at_heads_of_mean([scratch], mean, TURN), TURN)
    assert len(table.starts_counts) == {2: 2, 3: 4, 4: 4}[heads]
    reading = np.arange(0, TURN, 211) * 2.0 * np.pi / TURN
    total = np.zeros(reading.size)
    for weight, place in zip(weights, OFFSETS_DEG, strict=False):
        total += weight / 65536 * scratch.error_arcsec(reading + np.radians(place))
    left = total - taken_off_arcsec(table, TURN, reading)
    for weight, place in zip(weights, OFFSETS_DEG, strict=False):
        centre = np.radians(84.0 - place)
        near = np.abs(np.angle(np.exp(1j * (reading - centre)))) < np.radians(0.4)
        size = 20.0 * weight / 65536
        assert np.abs(total[near]).max() > 0.99 * size
        assert np.abs(left[near]).max() < size / 10.0
    assert np.abs(left).max() < 2.0 * min(weights) / 65536


def test_the_stated_remainder_is_that_of_the_common_table() -> None:
    """A wide scratch widens the windows of the table, so that its points miss the form of a narrow
    scratch; the stated remainder is that of the written table."""
    target = np.concatenate([np.arange(360.0), 250.0 + np.linspace(-0.3, 0.3, 601)])
    reference = Reference(target, np.zeros(target.size), standard_uncertainty_arcsec=0.1)
    observations = observations_of(
        MeasurementSet(Table(counts_per_rev=TURN), reference=reference, title="two scratches"),
        mask_outliers=False,
    )
    model = Model(
        [
            ModelEffect("graduation_defect", {}, {"place": 100.0, "width": 12.0}, ["b"], [1.0]),
            ModelEffect("graduation_defect", {}, {"place": 250.0, "width": 0.03}, ["b"], [10.0]),
        ]
    )
    effects = {"graduation_defect": GraduationDefect}
    held = export_model(
        model, observations, effects, lanes=4, temperature_c=None, with_local_table=True
    ).coefficients
    assert held.extension is not None
    assert held.extension.local_table is not None
    became = outcome(model, observations, effects, held, temperature_c=None)
    total = np.zeros(target.size)
    for place, width, height in ((100.0, 12.0, 1.0), (250.0, 0.03, 10.0)):
        # The width is the standard deviation of the bell.
        away = (target - place + 180.0) % 360.0 - 180.0
        total += height * np.exp(-0.5 * (away / width) ** 2)
    left = total - taken_off_arcsec(held.extension.local_table, TURN, np.radians(target))
    assert left.std() > 0.2
    # Each of the two parts is rounded to the points' words of 2⁻¹⁰ count or more.
    assert became.left_arcsec == pytest.approx(left.std(), abs=COUNT_ARCSEC)
    assert became.effects[1].left_arcsec == pytest.approx(left.std(), rel=0.05)


def test_an_error_that_no_point_holds_is_refused() -> None:
    with pytest.raises(ValueError, match="holds fewer than 8192"):
        table_of([bell(10.0, 1.0, 9000.0 * COUNT_ARCSEC)], TURN)


def scratched(disc: Float, temperature: Float, speed: float) -> Float:
    away = np.angle(np.exp(1j * (disc - np.radians(PLACE_DEG))))
    scratch = HEIGHT_ARCSEC * np.exp(-0.5 * (away / np.radians(WIDTH_DEG)) ** 2)
    return np.asarray(paper_error(disc, temperature, speed) + scratch)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("scratch") / "set"
    write_measurement_set(place, measurement_set(scratched, cycles=2, runs=2, turns=2))
    return place


@pytest.fixture(scope="module")
def model(folder: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    place = tmp_path_factory.mktemp("model") / "model.toml"
    answer = _run("add", "graduation_defect", folder, "--model", place)
    assert answer.exit_code == 0, answer.output
    return place


def test_a_scratch_is_written_and_read_back(folder: Path, model: Path, tmp_path: Path) -> None:
    """A file with a local table is read only for a core with LOCAL_TABLE. Its table removes the
    scratch, and the frames that load the file contain all points of the table."""
    words = ("export", folder, "--model", model, "--out", tmp_path, "--local-table")
    answer = _run(*words, "--json", tmp_path / "e.json")
    assert answer.exit_code == 0, answer.output
    said = re.search(r"in the local table: graduation_defect at (\S+)°", answer.output)
    assert said is not None, answer.output
    # The table is addressed by the reading, which 90″ of eccentricity shift by 0.025°.
    assert float(said[1]) == pytest.approx(PLACE_DEG, abs=0.05)
    (effect,) = (
        item
        for item in json.loads((tmp_path / "e.json").read_text())["effects"]
        if item["effect"] == "graduation_defect"
    )
    assert effect["by"] == "local table"
    assert effect["left_arcsec"] < 0.01 * effect["part_arcsec"]
    path = tmp_path / "coefficients.toml"
    with pytest.raises(CoefficientFileError, match="LOCAL_TABLE = true"):
        read_coefficient_file(path)
    held = read_coefficient_file(path, EVERYTHING)
    assert held.extension is not None
    assert held.extension.local_table is not None
    reading = np.radians(np.linspace(PLACE_DEG - 3.0, PLACE_DEG + 3.0, 2001))
    taken = taken_off_arcsec(held.extension.local_table, TURN, reading)
    true = scratched(reading, reading, 0.0) - paper_error(reading, reading, 0.0)
    # In each turn the fit has about 16 samples with 0.1″ of noise across the scratch, and the
    # reading differs from the angle by 0.025°.
    assert np.abs(taken - true).max() < 0.1 * abs(HEIGHT_ARCSEC)
    frames = [frame.split() for frame in load_frames(held) if frame.startswith("load points ")]
    points = [int(word) for frame in frames for word in frame[3:-1]]
    assert tuple(points[:4096]) == held.extension.local_table.points


def test_the_file_of_a_mean_gets_a_table_for_all_of_its_heads(
    folder: Path, model: Path, tmp_path: Path
) -> None:
    offsets = tuple(round(place / 360.0 * TURN * 16) for place in OFFSETS_DEG)
    mean = MeanSet((16384,) * 4, offsets)
    lanes = Coefficients.from_harmonics([1], [3.0], [0.2], TURN, 8)
    made = tmp_path / "mean.toml"
    write_coefficient_file(made, replace(lanes, extension=Extension(mean=mean)))
    words = ("export", folder, "--model", model, "--out", tmp_path, "--mean", made)
    answer = _run(*words, "--local-table")
    assert answer.exit_code == 0, answer.output
    held = read_coefficient_file(tmp_path / "coefficients.toml", EVERYTHING)
    assert held.extension is not None
    assert held.extension.mean == mean
    assert held.amplitudes.tolist() == lanes.amplitudes.tolist()
    table = held.extension.local_table
    assert table is not None
    assert len(table.starts_counts) == 4
    for place in OFFSETS_DEG:
        at = np.radians(np.array([PLACE_DEG - place]))
        taken = taken_off_arcsec(table, TURN, at)
        assert taken[0] == pytest.approx(HEIGHT_ARCSEC / 4.0, abs=0.1 * abs(HEIGHT_ARCSEC) / 4.0)
    assert _run(*words).exit_code != 0, "--mean needs --local-table"
    write_coefficient_file(made, lanes)
    answer = _run(*words, "--local-table")
    assert answer.exit_code != 0
    assert "it has no mean of heads" in " ".join(answer.output.split())


def test_a_table_of_a_mean_that_the_firmware_refuses_is_not_written(
    folder: Path, model: Path, tmp_path: Path
) -> None:
    """The slope of the mean's lanes is nearly at the limit, so that none is left for the table."""
    mean = MeanSet((32768,) * 2, (0, round(64.3 / 360.0 * TURN * 16)))
    lanes = Coefficients.from_harmonics([2000], [0.9999 * TURN / 4000 / np.pi], [0.2], TURN, 8)
    made = tmp_path / "mean.toml"
    write_coefficient_file(made, replace(lanes, extension=Extension(mean=mean)))
    words = ("export", folder, "--model", model, "--out", tmp_path, "--mean", made)
    answer = _run(*words, "--local-table")
    assert answer.exit_code != 0
    assert "the correction is too steep" in " ".join(answer.output.split())
    assert not (tmp_path / "coefficients.toml").exists()


def test_without_the_flag_it_is_left_and_said_so(folder: Path, model: Path, tmp_path: Path) -> None:
    answer = _run("export", folder, "--model", model, "--out", tmp_path)
    assert answer.exit_code == 0, answer.output
    assert "--local-table" in " ".join(answer.output.split())
    assert read_coefficient_file(tmp_path / "coefficients.toml").extension is None
