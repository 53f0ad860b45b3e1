"""Tests of the limit on a correction's slope over the temperature range of the file, in C, in
Python and at the console."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_judged_orders import COUNTS, started, turn
from sim.tests.firmware.test_load import send, state
from sim.tests.firmware.test_save import Board

from arctrue.calibration.acceptance import of_limits
from arctrue.device.load import load_frames
from arctrue.gateware.coefficient_bounds import slope_and_amplitude
from arctrue.gateware.coefficient_file import read_coefficient_file, write_coefficient_file
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.thermal import ThermalLanes

ORDER = 40
COLD_C = 20.0
NAN = float("nan")


def following(
    slope_counts: tuple[float, float, float, float],
    range_c: tuple[float, float] = (NAN, NAN),
    amplitude: float = 21.0,
) -> Coefficients:
    """Return coefficients with order 40 and these thermal slopes. With 21 counts the slope |dε/dR|
    of the correction ε over the reading R is 0.005 at 20 °C."""
    cold = Coefficients.from_harmonics([ORDER], [amplitude], [0.0], COUNTS, 32)
    thermal = ThermalLanes.from_slopes({ORDER: np.array(slope_counts)}, COLD_C, 0.0, range_c)
    return dataclasses.replace(cold, thermal=thermal)


def answer(coefficients: Coefficients) -> str:
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    made.send(f"set counts_per_rev {COUNTS}")
    return send(made, load_frames(coefficients))[-1]


STEEP = (1640.0, 0.0, 0.0, 0.0)
"""Thermal slope that gives 8,221 counts at 25 °C: |dε/dR| is 1.97, and the amplitude exceeds the
range of a lane."""


def test_a_slope_that_becomes_too_steep_is_refused_everywhere() -> None:
    steep = following(STEEP)
    assert slope_and_amplitude(steep)[0] > 1.9
    assert answer(steep) == "error: load too_steep"
    objections = of_limits(steep)
    assert "too steep: |dε/dR| reaches" in objections[0]
    assert "between 10 and 30 °C" in objections[0]
    # In a range of ± 0.5 kelvin the slope stays below 1 and the amplitude below 8,192 counts.
    narrow = following(STEEP, (19.5, 20.5))
    assert slope_and_amplitude(narrow)[0] == pytest.approx(
        40 * 841.0 * 2 * np.pi / COUNTS, rel=1e-3
    )
    assert of_limits(narrow) == []
    assert answer(narrow) == "ok"


def test_an_amplitude_that_no_lane_holds_at_some_temperature_is_refused() -> None:
    """The loader refuses an amplitude that leaves the range of a lane at some temperature, although
    the slope of order 1 is small. An earlier version clipped the amplitude without a message."""
    cold = Coefficients.from_harmonics([1], [7000.0], [0.0], COUNTS, 32)
    thermal = ThermalLanes.from_slopes({1: np.array([150.0, 0.0, 0.0, 0.0])}, COLD_C)
    warm = dataclasses.replace(cold, thermal=thermal)
    assert slope_and_amplitude(warm)[0] < 0.1
    assert answer(warm) == "error: load out_of_range"
    assert "a lane reaches 8500 counts between 10 and 30 °C" in of_limits(warm)[0]


@pytest.mark.large
@given(
    st.lists(st.integers(1, 300), min_size=1, max_size=16, unique=True),
    st.integers(0, 2**32 - 1),
    st.tuples(st.floats(-40.0, 0.0), st.floats(0.0, 40.0)),
)
@settings(max_examples=100, deadline=None)
def test_the_bounds_hold_and_both_languages_have_the_same(
    orders: list[int], seed: int, reach: tuple[float, float]
) -> None:
    """The computed bounds are not below the largest slope and the largest amplitude at 2,001
    temperatures, and the bound of the slope is not far above. The C code agrees with the Python
    code to 1e-9."""
    ffi, library = c_library()
    random = np.random.default_rng(seed)
    cold = Coefficients.from_harmonics(
        orders, random.uniform(0, 300, len(orders)), random.uniform(-3, 3, len(orders)), COUNTS, 32
    )
    slopes = {n: random.normal(0.0, [3.0, 3.0, 0.3, 0.3]) for n in orders[:16]}
    range_c = (COLD_C + reach[0], COLD_C + reach[1])
    thermal = ThermalLanes.from_slopes(slopes, COLD_C, 0.0, range_c)
    warm = dataclasses.replace(cold, thermal=thermal)
    steepest, largest = slope_and_amplitude(warm)
    exact_slope = exact_size = 0.0
    written = cold.amplitudes_counts[: len(orders)] * np.exp(-1j * cold.phases_rad[: len(orders)])
    for celsius in np.linspace(thermal.least_c, thermal.most_c, 2001):
        now = written + [thermal.change_counts(n, float(celsius)) for n in orders]
        exact_slope = max(exact_slope, float(np.abs(now) @ orders) * 2 * np.pi / COUNTS)
        exact_size = max(exact_size, float(np.abs(now).max()))
    assert exact_slope <= steepest * (1 + 1e-12) + 1e-15
    assert exact_size <= largest * (1 + 1e-12)
    # The bounds come from 33 temperatures with the spacing h, 1/32 of the range. With the
    # coefficient c2 of the squared temperature, the bound of an amplitude exceeds the largest value
    # by at most |c2| h^2/4.
    assert steepest - exact_slope <= 0.25 * 0.6 * 4 * (80 / 32) ** 2 * sum(orders) * 6e-6 * 2
    model = ffi.new("struct thermal *")
    model.lanes, model.reference_mc = len(slopes), round(1000 * COLD_C)
    model.least_mc, model.most_mc = round(1000 * thermal.least_c), round(1000 * thermal.most_c)
    for place, order in enumerate(slopes):
        model.lane[place] = [order, *thermal.slopes[place].tolist()]
    bank = ffi.new("struct coefficients *")
    bank.lanes, bank.counts_per_rev = len(orders), COUNTS
    for place, order in enumerate(orders):
        bank.lane[place] = [
            int(cold.phase_offsets[place]),
            int(cold.amplitudes[place]),
            order,
        ]
    found = library.thermal_extent(model, bank)
    assert found.steepest == pytest.approx(steepest, rel=1e-9)
    assert found.largest_counts == pytest.approx(largest, rel=1e-9)


def test_a_range_goes_through_file_console_and_flash(tmp_path: Path) -> None:
    ranged = following((5.0, 0.0, 0.0, 0.0), (15.0, 24.5), amplitude=30.0)
    path = tmp_path / "c.toml"
    write_coefficient_file(path, ranged)
    assert read_coefficient_file(path) == ranged
    board = Board()
    board.firmware.send(f"set counts_per_rev {COUNTS}")
    board.core.see_index()
    board.firmware.step()
    frames = load_frames(ranged)
    assert any(frame.startswith("load range 15000 24500 ") for frame in frames)
    load_frames_forced = load_frames(ranged, force=True)
    assert set(send(board.firmware, load_frames_forced)) == {"ok"}
    thermal = board.firmware.application.load.received_thermal
    assert (thermal.least_mc, thermal.most_mc) == (15_000, 24_500)
    board.firmware.send("load abort")
    board.firmware.application.load.loaded = board.firmware.application.load.received
    board.firmware.application.load.thermal = thermal
    board.firmware.turn(turn(1))
    assert board.order("save").startswith("ok")
    board.power_on()
    saved = board.save.content.thermal
    assert (saved.least_mc, saved.most_mc) == (15_000, 24_500)


def test_a_file_without_a_range_has_the_preset_one(tmp_path: Path) -> None:
    """A file without a range has the preset range of ten kelvin to each side, and no frame with a
    range is sent; older files state no range."""
    text = coefficient_file_text(following((5.0, 0.0, 0.0, 0.0)))
    old = "".join(
        line + "\n" for line in text.splitlines() if not line.startswith(("least_c", "most_c"))
    )
    path = tmp_path / "c.toml"
    path.write_text(old, encoding="utf-8")
    read = read_coefficient_file(path)
    assert read.thermal is not None
    assert (read.thermal.least_c, read.thermal.most_c) == (10.0, 30.0)
    assert not any(" range " in frame for frame in load_frames(read))
    made = started()
    assert set(send(made, load_frames(read))) == {"ok"}
    thermal = made.application.load.received_thermal
    assert (thermal.least_mc, thermal.most_mc) == (10_000, 30_000)
    assert state(made) == "load waiting"


@pytest.mark.parametrize("range_c", [(21.0, 25.0), (10.0, 19.0), (25.0, 15.0)])
def test_a_range_without_the_reference_is_refused(range_c: tuple[float, float]) -> None:
    with pytest.raises(ValueError, match="expected a range that holds reference_c, 20"):
        following((5.0, 0.0, 0.0, 0.0), range_c)


@pytest.mark.parametrize("celsius", [5.0, 24.5, 40.0])
def test_beyond_the_range_the_lanes_stay(celsius: float) -> None:
    ffi, library = c_library()
    ranged = following((5.0, 2.0, 0.0, 0.0), (15.0, 24.5))
    assert ranged.thermal is not None
    model = ffi.new("struct thermal *")
    model.lanes, model.reference_mc, model.least_mc, model.most_mc = 1, 20_000, 15_000, 24_500
    model.lane[0] = [ORDER, *ranged.thermal.slopes[0].tolist()]
    lane = ffi.new("struct lane *", (0, int(ranged.amplitudes[0]), ORDER))
    held = library.thermal_lane_at(model, lane, celsius)
    limit = library.thermal_lane_at(model, lane, min(max(celsius, 15.0), 24.5))
    assert (held.amplitude, held.phase_offset) == (limit.amplitude, limit.phase_offset)
    assert ranged.at(celsius) == ranged.at(min(max(celsius, 15.0), 24.5))
    assert abs(int(ranged.at(celsius).amplitudes[0]) - held.amplitude) <= 1
