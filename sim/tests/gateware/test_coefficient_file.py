"""Tests that a coefficient file is read as it was written, and that errors name the wrong entry."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from arctrue.gateware.coefficient_file import (
    CoefficientFileError,
    read_coefficient_file,
    write_coefficient_file,
)
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.thermal import ThermalLanes

GOOD = coefficient_file_text(
    Coefficients.from_harmonics(
        [1, 2, 16_384], [1942.1, -30.25, 0.5], [0.4, 3.0, -1.0], 2**24, 8, 1.5
    ),
    title='table "A"',
)


@pytest.mark.filterwarnings("ignore:order")
@given(data=st.data())
def test_round_trip(tmp_path_factory: pytest.TempPathFactory, data: st.DataObject) -> None:
    counts_per_rev = data.draw(st.sampled_from([4, 1000, 65536, 12_345_677, 2**24]))
    lanes = data.draw(st.sampled_from([1, 5, 64]))
    used = data.draw(st.integers(0, lanes))
    rng = np.random.default_rng(data.draw(st.integers(0, 2**32)))
    written = Coefficients.from_harmonics(
        rng.integers(0, 65536, used),
        rng.uniform(-8191.9, 8191.9, used) * 10.0 ** -rng.integers(0, 6, used),
        rng.uniform(-7.0, 7.0, used),
        counts_per_rev,
        lanes,
        float(rng.uniform(-8191.0, 8191.0)),
    )
    path = tmp_path_factory.mktemp("file") / "coefficients.toml"
    write_coefficient_file(path, written)
    assert read_coefficient_file(path) == written
    assert [entry.name for entry in path.parent.iterdir()] == [path.name]


@pytest.mark.parametrize("encoding", ["utf-8-sig", "crlf"])
def test_other_editors(tmp_path: Path, encoding: str) -> None:
    path = tmp_path / "c.toml"
    if encoding == "crlf":
        path.write_bytes(GOOD.replace("\n", "\r\n").encode())
    else:
        path.write_text(GOOD, encoding=encoding)
    assert read_coefficient_file(path).lanes == 8


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("schema = 1", "schema = 4", "schema: expected one of 1, 2, 3, found 4"),
        ("schema = 1", "", "schema: is missing"),
        ("schema = 1", "schema = 1\ncolour = 3", "colour: is not known"),
        ('title = "table \\"A\\""', "title = 3", "title: expected a text, found 3"),
        ("counts_per_rev = 16777216", "counts_per_rev = 3", "counts_per_rev: 3"),
        ("counts_per_rev = 16777216", "counts_per_rev = 1e6", "counts_per_rev: expected a whole"),
        ("counts_per_rev = 16777216", "counts_per_rev = 65536", r"lane\[1\].phase_step: found"),
        ("lanes = 8", "lanes = 65", "lanes: expected a whole number from 1 to 64, found 65"),
        ("lanes = 8", "lanes = true", "a whole number from 1 to 64, found true"),
        ("lanes = 8", "lanes = 2", r"lane\[3\].lane: expected a whole number from 0 to 1"),
        ("lane = 1\n", "lane = 0\n", r"lane\[2\].lane: lane 0 is listed twice"),
        ("counts = 1.5", "counts = 1.6", "offset.counts: found 1.6, but word = 3072 is 1.5"),
        ("counts = 1.5", "counts = nan", "offset.counts: expected a finite number"),
        ("word = 3072", "", "offset.word: is missing"),
        ("word = 3072\n", "word = 33554432\n", "offset.counts"),
        ("order = 2", "order = 3", r"lane\[2\].phase_step: found"),
        ("order = 2", "order = 65536", r"lane\[2\].order: expected a whole number from 0 to 65535"),
        ("order = 2", 'order = "2"', 'from 0 to 65535, found "2"'),
        ("order = 2", "", r"lane\[2\].order: is missing"),
        ("amplitude = -61952", "amplitude = 61952", r"lane\[2\].amplitude_arcsec: found"),
        ("[[lane]]", "[lanes_]", "is not TOML"),
        ("[offset]", "offset = 3\n[other]", r"expected a table \[offset\], found 3"),
        ("schema = 1", "schema = ", "is not TOML"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert old in GOOD
    path = tmp_path / "c.toml"
    path.write_text(GOOD.replace(old, new), encoding="utf-8")
    with pytest.raises(CoefficientFileError, match=message) as caught:
        read_coefficient_file(path)
    assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    ("amplitude", "arcsec", "phase", "degrees"),
    [(2**24, 632.8125, 0, 0.0), (0, 0.0, 2**24, 0.0), (0, 0.0, -1, 0.0), (0, 0.0, 2**70, 0.0)],
)
def test_words_outside_the_formats_are_refused(
    tmp_path: Path, amplitude: int, arcsec: float, phase: int, degrees: float
) -> None:
    path = tmp_path / "c.toml"
    path.write_text(
        "schema = 1\ncounts_per_rev = 16777216\nlanes = 1\n"
        "[offset]\ncounts = 0\nword = 0\n[[lane]]\n"
        f"lane = 0\norder = 0\namplitude_arcsec = {arcsec}\nphase_deg = {degrees}\nphase_step = 0\n"
        f"phase_offset = {phase}\namplitude = {amplitude}\n",
        encoding="utf-8",
    )
    with pytest.raises(CoefficientFileError, match=r"c\.toml: "):
        read_coefficient_file(path)


@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe\x00", b"PK\x03\x04"])
def test_files_that_are_none(tmp_path: Path, content: bytes | None) -> None:
    path = tmp_path / "c.toml"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(CoefficientFileError, match=r"c\.toml: "):
        read_coefficient_file(path)


def thermal() -> Coefficients:
    """Return a bank with thermal slopes for order 1 and for order 2, whose amplitude is zero at 20
    °C."""
    lanes = ThermalLanes.from_slopes(
        {1: np.array([18.5, -7.25, 0.01, 0.0]), 2: np.array([0.0, 3.0, 0.0, -0.5])}, 20.0, 60.0
    )
    cold = Coefficients.from_harmonics(
        [1, 2, 16_384], [1942.1, 0.0, 0.5], [0.4, 0.0, 1.0], 2**24, 8
    )
    return dataclasses.replace(cold, thermal=lanes)


def test_lanes_that_follow_the_temperature(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    write_coefficient_file(path, thermal())
    assert read_coefficient_file(path) == thermal()
    assert "schema = 2\n" in path.read_text("utf-8")
    assert "schema = 1\n" in GOOD, (
        "a file without new parts keeps schema 1, which older readers read"
    )
    # The expected correction, at 24 °C and many angles, has coefficients c0 + c1 (T - T0) + c2 (T -
    # T0)^2.
    angle = np.arange(0, 2**24, 99_991)
    turn = angle * 2.0 * np.pi / 2**24
    expected = (
        1942.1 * np.cos(turn + 0.4)
        + (18.5 * 4 + 0.01 * 16) * np.cos(turn)
        - 7.25 * 4 * np.sin(turn)
        + (3.0 * 4 - 0.5 * 16) * np.sin(2 * turn)
        + 0.5 * np.cos(16_384 * turn + 1.0)
    )
    found = thermal().at(24.0).error_counts(angle)
    # The bound is half a unit of the amplitude for each of three lanes, and half a unit of the
    # phase times 2,000 counts.
    assert np.abs(found - expected).max() < 3 / 4096 + 2000 * np.pi / 2**24
    assert thermal().at(20.0).error_counts(angle) == pytest.approx(
        dataclasses.replace(thermal(), thermal=None).error_counts(angle), abs=1 / 2048
    )


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("reference_c = 20.0", "reference_c = 2000.0", "reference_c: 2000.0, expected"),
        ("reference_c = 20.0\n", "", "temperature.reference_c: is missing"),
        (
            "[temperature]",
            "[temperatures]",
            "temperatures: is not known (did you mean temperature?)",
        ),
        ("sensor_time_constant_s = 60.0", "sensor_time_constant_s = -1.0", "expected 0 to"),
        ("schema = 2", "schema = 1", "temperature: is not known"),
        ("schema = 2", "schema = 4", "expected one of 1, 2, 3, found 4"),
        ("slope = [19398656, ", "slope = [19398657, ", "change both or neither"),
        ("slope = [19398656, ", "slope = [1.5, ", "slope[1]: expected a whole number, found 1.5"),
        ("slope = [19398656, ", "slope = [", "expected 4 whole numbers"),
        ("slope_arcsec_per_k = [", "slope_arcsec_per_k = [nan, ", "expected 2 finite numbers"),
    ],
)
def test_what_is_wrong_with_slopes_is_named(
    tmp_path: Path, old: str, new: str, message: str
) -> None:
    text = coefficient_file_text(thermal())
    assert text.count(old) >= 1
    path = tmp_path / "c.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CoefficientFileError, match=r"c\.toml: ") as found:
        read_coefficient_file(path)
    assert message in str(found.value)
