"""Tests of loaded lanes that follow the table's temperature, and of the thermometer values that are
accepted."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import ARCSEC_PER_COUNT, active_coefficients
from sim.tests.firmware.test_load import READINGS, file_of, send, state, turn
from sim.tests.firmware.test_save import Board

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients
from arctrue.gateware.thermal import ThermalLanes
from arctrue.table.temperature import TemperatureCourse

COLD_C = 20.0
RATE_ARCSEC, RATE_RAD = 1.5, 1.1
"""Amplitude (″) and phase by which order 1 changes per kelvin."""
CLOCK_HZ = 100_000_000


def warm(celsius: float) -> Disc:
    """Return the disc at a temperature that shifts the disc's centre."""
    cold = 150.0 * np.exp(0.4j)
    now = cold + RATE_ARCSEC * (celsius - COLD_C) * np.exp(1j * RATE_RAD)
    return Disc({1: (abs(now), float(np.angle(now))), 2: (6.0, 4.2), 7: (1.2, 2.9)})


def following(time_constant_s: float = 0.0) -> Coefficients:
    """Return coefficients with order 1 at 20 °C and the change of order 1 per kelvin."""
    cold = file_of({1: (150.0, 0.4)})
    per_k = RATE_ARCSEC / ARCSEC_PER_COUNT
    slope = np.array([per_k * math.cos(RATE_RAD), -per_k * math.sin(RATE_RAD), 0.0, 0.0])
    thermal = ThermalLanes.from_slopes({1: slope}, COLD_C, time_constant_s)
    return Coefficients(
        cold.phase_steps, cold.phase_offsets, cold.amplitudes, 0, cold.counts_per_rev, thermal
    )


class Thermometer:
    """The thermometer of the table; if its temperature is None, it does not answer."""

    def __init__(self, made: Firmware) -> None:
        ffi, library = c_library()
        self.celsius: float | None = COLD_C
        self.made = made
        self.now_s = 0.0
        self.reads = 0
        self._call = ffi.callback("temperature_read", self._read)
        library.application_use_thermometer(made.application, self._call, ffi.NULL)

    def _read(self, _: Any, celsius: Any) -> bool:
        self.reads += 1
        if self.celsius is None:
            return False
        celsius[0] = self.celsius
        return True

    def pass_time(self, seconds: float, steps: int = 1) -> None:
        """Advance the core's clock in steps, and run the main loop after each step."""
        for _ in range(steps):
            self.now_s += seconds / steps
            clocks = round(self.now_s * CLOCK_HZ)
            self.made.core.set("snapshot.time", clocks)
            self.made.core.words[address_of_upper_time()] = clocks >> 32
            # The first step may swap the bank, and the second does the work after the swap.
            self.made.step(2)


def address_of_upper_time() -> int:
    from sim.tests.firmware.model_core import address

    return address("snapshot.time") + 4


@pytest.fixture
def running() -> Firmware:
    """Return a firmware that is calibrated at 20 °C, with a thermometer and a loaded thermal
    model."""
    made = Firmware(ModelCore())
    made.thermometer = Thermometer(made)
    made.library.application_start(made.application)
    made.core.see_index()
    made.send("set orders 8")
    made.thermometer.pass_time(2.0, 4)
    for seed in range(1, 4):
        made.turn(turn(seed, disc=warm(COLD_C)))
    assert set(send(made, load_frames(following()))) == {"ok"}
    made.turn(turn(4, disc=warm(COLD_C)))
    assert state(made) == "load active"
    return made


def order1_left(made: Firmware, celsius: float) -> float:
    """Return the largest error of the corrected reading in arcseconds, without the subdivision
    error."""
    angle = READINGS * (2.0 * np.pi / COUNTS)
    wrong = np.rad2deg(angle - warm(celsius).true_angle(angle)) * 3600.0
    applied = active_coefficients(made.core).error_counts(READINGS) * ARCSEC_PER_COUNT
    return float(np.abs(wrong - applied).max())


def test_the_correction_follows_between_two_turns(running: Firmware) -> None:
    for celsius in (20.3, 21.0, 21.9, 21.0):
        running.thermometer.celsius = celsius
        assert order1_left(running, celsius) > 0.4
        running.thermometer.pass_time(4.0, 8)
        # Half a count is 0.04″, and the calibration leaves 0.05″ in the other orders.
        assert order1_left(running, celsius) < 0.12
    assert int(field(running, "temperature_swaps")) == 4


def test_without_the_thermometer_it_does_not(running: Firmware) -> None:
    running.send("temperature none")
    running.send("set temperature_jump_k 10")
    running.thermometer.celsius = 22.0
    running.thermometer.pass_time(4.0, 8)
    assert order1_left(running, 22.0) > 2.5


def test_a_change_below_the_step_is_not_worth_a_bank(running: Firmware) -> None:
    running.send("set temperature_step_counts 100")
    running.send("set temperature_jump_k 10")
    swaps = running.application.swaps
    running.thermometer.celsius = 22.0
    running.thermometer.pass_time(4.0, 8)
    assert running.application.swaps == swaps
    assert 100 * ARCSEC_PER_COUNT > 2 * RATE_ARCSEC
    running.thermometer.celsius = 27.0
    running.thermometer.pass_time(2.0, 4)
    assert running.application.swaps == swaps + 1


def test_the_calibration_continues_during_it(running: Firmware) -> None:
    """The calibration follows order 2, which changes, while order 1 follows the temperature."""
    running.send("set keep 0")
    running.thermometer.celsius = 20.9
    running.thermometer.pass_time(2.0, 4)
    moved = Disc({**warm(20.9).orders, 2: (9.0, 4.2)})
    for seed in range(5, 9):
        assert running.turn(turn(seed, disc=moved))["result"] in ("applied", "kept")
    angle = READINGS * (2.0 * np.pi / COUNTS)
    wrong = np.rad2deg(angle - moved.true_angle(angle)) * 3600.0
    applied = active_coefficients(running.core).error_counts(READINGS) * ARCSEC_PER_COUNT
    assert np.abs(wrong - applied).max() < 0.3
    rows = [line.split() for line in running.send("show harmonics").splitlines()[1:-1]]
    assert rows[0][-1] == "loaded"


def test_the_host_tells_the_temperature() -> None:
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    made.core.see_index()
    made.step()
    send(made, load_frames(following()))
    assert made.send("temperature 22").strip() == "ok"
    made.turn(turn(4, disc=warm(22.0)))
    assert state(made) == "load active"
    assert order1_left(made, 22.0) < 8.0, "orders 2 and 7 remain, order 1 does not"
    assert made.turn(turn(5, disc=warm(22.0)))["table_c"] == 22.0
    for bad in ("temperature warm", "temperature 500", "temperature -60"):
        assert made.send(bad).startswith(("error: expected a temperature", "error: a temperature"))
    assert made.send("temperature sensor") == "error: no thermometer answers\r\n"


def field(made: Firmware, name: str) -> str:
    lines = made.send("status").splitlines()
    (value,) = [line.split(" ", 1)[1] for line in lines if line.startswith(f"{name} ")]
    return value


@pytest.mark.parametrize(
    ("shows", "fault"),
    [(None, "silent"), (85.0, "jumped"), (22.5, "jumped"), (200.0, "silent")],
)
def test_a_thermometer_that_fails_leaves_the_last_good_model(
    running: Firmware, shows: float | None, fault: str
) -> None:
    running.thermometer.celsius = 20.8
    running.thermometer.pass_time(2.0, 4)
    running.thermometer.celsius = shows
    running.thermometer.pass_time(5.0, 10)
    assert field(running, "thermometer_state") == fault
    assert order1_left(running, 20.8) < 0.12, "the lanes keep their values"
    telemetry = running.turn(turn(9, disc=warm(20.8)))
    assert (telemetry["alarms"], telemetry["thermometer"], telemetry["table_c"]) == (
        ["thermometer"],
        fault,
        20.8,
    )
    # The advice about "jumped" names the temperature, all other advice names the thermometer.
    subjects = ("advice the thermometer", "advice the temperature")
    assert any(line.startswith(subjects) for line in running.send("status").splitlines())
    running.thermometer.celsius = 21.2
    if fault == "jumped":
        running.thermometer.pass_time(2.0, 4)
        assert field(running, "thermometer_state") == fault, (
            "the fault lasts until the operator ends it"
        )
        running.send("temperature sensor")
    running.thermometer.pass_time(2.0, 4)
    assert field(running, "thermometer_state") == "good"
    assert order1_left(running, 21.2) < 0.12


def test_a_thermometer_that_comes_back_warmer_is_believed(running: Firmware) -> None:
    """The firmware accepts a warmer thermometer after its cable was off for two minutes, and
    continues without the operator."""
    running.thermometer.celsius = None
    running.thermometer.pass_time(120.0, 240)
    assert field(running, "thermometer_state") == "silent"
    running.thermometer.celsius = COLD_C + 1.5
    running.thermometer.pass_time(2.0, 4)
    assert field(running, "thermometer_state") == "good"
    assert order1_left(running, COLD_C + 1.5) < 0.12


def test_after_a_silence_not_everything_is_believed(running: Firmware) -> None:
    """The firmware accepts a change of 3 K per minute of silence, but not one of 20 K after two
    minutes, because no table warms so fast."""
    running.thermometer.celsius = None
    running.thermometer.pass_time(120.0, 240)
    running.thermometer.celsius = COLD_C + 20.0
    running.thermometer.pass_time(0.6)
    assert field(running, "thermometer_state") == "silent", "one reading alone may have a wrong bit"
    running.thermometer.pass_time(2.0, 4)
    assert field(running, "thermometer_state") == "jumped"
    assert order1_left(running, COLD_C) < 0.12


def followed(readings: list[float | None], lag_s: float = 0.0, every_s: float = 0.5) -> Any:
    """Return the firmware's state of the table's temperature after these readings; None stands for
    no answer."""
    ffi, library = c_library()
    at = iter(readings)

    def read(_: Any, celsius: Any) -> bool:
        value = next(at)
        celsius[0] = 0.0 if value is None else value
        return value is not None

    call = ffi.callback("temperature_read", read)
    table, limits = ffi.new("struct table_temperature *"), ffi.new("struct temperature_limits *")
    limits.jump_k = 1.0
    library.table_temperature_use(table, call, ffi.NULL)
    for number in range(len(readings)):
        library.table_temperature_follow(table, limits, lag_s, (number + 1) * every_s)
    return table


def test_the_first_reading_is_confirmed_before_it_is_used() -> None:
    """The firmware confirms the first reading before it uses it, because an ADT7420 shows 0 °C
    until its first conversion."""
    _, library = c_library()
    table = followed([0.0, 21.0])
    assert not library.table_temperature_is_known(table)
    table = followed([0.0, 21.0, 21.01, 21.0])
    assert (table.state, table.celsius) == (library.TEMPERATURE_GOOD, 21.0)
    table = followed([0.0, 21.0, 0.0, 21.0, 0.0, 21.0])
    assert not library.table_temperature_is_known(table), "no two readings in a row agree"


@pytest.mark.parametrize("lag_s", [0.0, 3.0, 60.0])
def test_a_long_pause_leaves_a_temperature(lag_s: float) -> None:
    """After a long pause the observer, which removes the thermometer's lag, starts again: the lag
    has decayed completely, and the gains of a continued observer would be undefined."""
    readings = [20.0] * 8 + [None] * 1200 + [20.5] * 3
    table = followed(readings, lag_s)
    assert table.celsius == pytest.approx(20.5, abs=0.1)


def test_a_core_whose_time_begins_again_does_not_freeze_the_thermometer(
    running: Firmware,
) -> None:
    """The thermometer is still used after another bitstream or a reset of the fabric, when the
    readings' clock starts again at 0."""
    running.thermometer.pass_time(100.0, 200)
    running.thermometer.now_s = 0.0
    running.thermometer.celsius = COLD_C + 0.8
    running.thermometer.pass_time(1.0, 2)
    assert float(field(running, "thermometer_c")) == pytest.approx(COLD_C + 0.8)
    assert order1_left(running, COLD_C + 0.8) < 0.12
    running.send("set temperature_still_s 5")
    running.thermometer.pass_time(6.0, 12)
    assert field(running, "thermometer_state") == "unchanged"
    running.thermometer.celsius = None
    running.thermometer.now_s = 0.0
    running.thermometer.pass_time(2.0, 4)
    assert field(running, "thermometer_state") == "silent"


def test_one_wrong_reading_is_not_taken(running: Firmware) -> None:
    running.thermometer.celsius = 60.0
    running.thermometer.pass_time(0.5)
    running.thermometer.celsius = 20.1
    running.thermometer.pass_time(1.0, 2)
    assert field(running, "thermometer_state") == "good"
    assert order1_left(running, 20.1) < 0.12


def test_a_thermometer_that_stands_still_is_noticed(running: Firmware) -> None:
    running.send("set temperature_still_s 60")
    running.thermometer.pass_time(55.0, 100)
    assert field(running, "thermometer_state") == "good"
    running.thermometer.pass_time(10.0, 20)
    assert field(running, "thermometer_state") == "unchanged"
    running.thermometer.celsius = COLD_C + 1 / 128
    running.thermometer.pass_time(1.0, 2)
    assert field(running, "thermometer_state") == "good"


def test_a_silent_thermometer_is_not_asked_all_the_time(running: Firmware) -> None:
    running.thermometer.celsius = None
    before = running.thermometer.reads
    running.thermometer.pass_time(5.0, 1000)
    assert 9 <= running.thermometer.reads - before <= 11


def test_the_lag_is_taken_off() -> None:
    """For a table that warms evenly, read with a lag of 60 s in steps of 1/128 K, the firmware
    removes the lag: after 37.5 s the mean error is below 0.003 K and the largest below 1/16 K."""
    ffi, library = c_library()
    lag_s, rate = 60.0, 0.05
    course = TemperatureCourse((0.0, 300.0), (COLD_C, COLD_C + 300 * rate))
    times = np.arange(0.5, 299.0, 0.5)
    shown = np.rint(course.lagging(times, lag_s) * 128) / 128
    at = iter(shown)
    call = ffi.callback("temperature_read", lambda _, c: c.__setitem__(0, next(at)) or True)
    table, limits = ffi.new("struct table_temperature *"), ffi.new("struct temperature_limits *")
    limits.jump_k = 1.0
    library.table_temperature_use(table, call, ffi.NULL)
    found = []
    for now in times:
        library.table_temperature_follow(table, limits, lag_s, float(now))
        found.append(table.celsius)
    behind = course.at(times) - np.array(found)
    assert (course.at(times) - shown)[-1] == pytest.approx(lag_s * rate, rel=0.02)
    # Three equal poles leave (1 + x + x²/2)·e⁻ˣ of the error at the start of the slope, with x =
    # t·16/τ; after x = 10 this is below 0.003. Half a step of the readings, times the gains, adds
    # about 0.05 K.
    late = behind[times > 37.5]
    assert abs(late.mean()) < 0.003
    assert late.std() < 0.02
    assert np.abs(late).max() < 8 / 128


@given(
    st.floats(0.0, 300.0),
    st.floats(-math.pi, math.pi),
    st.tuples(*[st.floats(-20.0, 20.0)] * 4),
    st.floats(-5.0, 5.0),
)
@settings(max_examples=100, deadline=None)
def test_a_lane_at_a_temperature(
    amplitude: float, phase: float, slopes: tuple[float, ...], warmth: float
) -> None:
    """The C code's lane at each temperature equals the sum of cosines, and the bank that the host
    computes."""
    ffi, library = c_library()
    thermal = ThermalLanes.from_slopes({3: np.array(slopes)}, COLD_C)
    cold = Coefficients.from_harmonics([3], [amplitude], [phase], COUNTS, 4)
    cold = Coefficients(cold.phase_steps, cold.phase_offsets, cold.amplitudes, 0, COUNTS, thermal)
    model = ffi.new("struct thermal *")
    model.lanes, model.reference_mc = 1, round(1000 * COLD_C)
    library.thermal_preset_range(model)
    model.lane[0] = [3, *thermal.slopes[0].tolist()]
    words = (int(cold.phase_offsets[0]), int(cold.amplitudes[0]), 3)
    lane = ffi.new("struct lane *", words)
    made = library.thermal_lane_at(model, lane, COLD_C + warmth)
    angle = np.linspace(0.0, 2.0 * np.pi, 37)
    expected = (
        amplitude * np.cos(3 * angle + phase)
        + (slopes[0] + slopes[2] * warmth) * warmth * np.cos(3 * angle)
        + (slopes[1] + slopes[3] * warmth) * warmth * np.sin(3 * angle)
    )
    turned = 2.0 * np.pi * made.phase_offset / 2**24
    found = made.amplitude / 2048 * np.cos(3 * angle + turned)
    # The bound is two words of the amplitude (2⁻¹¹ count each), plus two words of the phase (2⁻²⁴
    # turn each) times the amplitude in counts.
    of_phase = 2.0 * 2.0 * np.pi * 2.0**-24 * abs(made.amplitude) / 2048
    assert np.abs(found - expected).max() < 2 / 2048 + of_phase
    host = cold.at(COLD_C + warmth)
    assert abs(int(host.amplitudes[0]) - made.amplitude) <= 1


def test_what_cannot_be_loaded() -> None:
    made = Firmware(ModelCore())
    made.library.application_start(made.application)
    begin, lane, temperature, slope, end = load_frames(following())
    assert send(made, [temperature, slope]) == ["error: load wrong_frame"] * 2
    assert send(made, [begin, slope]) == ["ok", "error: load out_of_range"], "the set has no lane"
    assert send(made, [begin, lane, temperature, slope, slope]) == [
        *["ok"] * 4,
        "error: load wrong_frame",
    ]
    assert send(made, [begin, lane, slope, end])[-1] == "error: load wrong_crc", "T0 is missing"
    assert send(made, [begin, lane, slope.replace("slope 0 1 ", "slope 0 2 ")])[-1] == (
        "error: load wrong_crc"
    )


def test_it_is_saved_with_its_slopes() -> None:
    board = Board()
    for seed in range(1, 4):
        board.firmware.turn(turn(seed, disc=warm(COLD_C)))
    send(board.firmware, load_frames(following(60.0)))
    board.firmware.turn(turn(4, disc=warm(COLD_C)))
    assert board.order("save").startswith("ok, record 1")
    board.power_on()
    board.firmware.send("temperature 23")
    board.firmware.turn(turn(5, disc=warm(23.0)))
    assert board.status("saved") == ["confirmed"]
    assert order1_left(board.firmware, 23.0) < 0.7, "only the subdivision error remains"
    assert board.firmware.application.load.thermal.time_constant_ms == 60_000
