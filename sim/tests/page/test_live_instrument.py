"""Test of the page of a running device with the compiled instrument and four heads.

The daemon opens the instrument's serial port. The core is the compiled netlist, and the firmware is
that of the board. The table heats, its disc creeps, its axis moves and a head fails. The table has
2¹⁶ counts of 19.8″ per turn, so that a turn takes less than a second.
"""

from __future__ import annotations

import dataclasses
import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest
from playwright.sync_api import Page, expect
from sim.tests.device.daemon_process import daemon
from sim.tests.instrument.turning import Turning
from sim.tests.page.page_server import page_server

from arctrue.device.announcement import FOLDER_VARIABLE
from arctrue.instrument import HEAD2_A, Firmware, PinFault
from arctrue.measurement import read_measurement_set
from arctrue.studies.heads.device import HeadsDevice
from arctrue.studies.revolution.settings import RevolutionSettings
from arctrue.table import DISC_RADIUS_M, Motion
from arctrue.table.causes.creeping_centre import CreepingCentre
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.temperature import TemperatureCourse
from tests.page.in_browser import needs_browser, picture

pytestmark = needs_browser

SETTINGS = RevolutionSettings(
    lines=256, interpolation=256, lanes=4, samples=1200, orders=8, clocks_per_count=1.15
)
ARCSEC_A_METRE = np.degrees(1.0 / DISC_RADIUS_M) * 3600.0
CIRCLE_M = 2e-6
"""Radius of the circle on which the axis moves three times per turn: 7.6″ at the disc's radius."""
CREEP_M_A_TURN = 0.4e-6j
"""Drift of the disc's centre: 1.5″ more in each turn."""
HEAT_M_A_K = 2e-6
"""Thermal shift of the disc's centre, perpendicular to the drift: 7.6″ per kelvin."""
WARM_K = 4.0
FIRST_WARM_TURN, LAST_WARM_TURN = 4.0, 6.0
CALIBRATED, DRIFTED, ALL_HEADS, ALL = 3, 8, 10, 90
"""Numbers of the turns at which the phases of the test end: calibration by two heads, drift,
calibration by four heads, and the whole test.

The mean of four heads does not contain the motion of the disc's centre.
"""
SIGMAS = 5.0
U_CIRCLE_ARCSEC = 0.4
"""Standard uncertainty of the radius of the axis' circle, as the orbit shows it.

A count of 19.8″ has a rounding of 5.7″ RMS. Four heads give x and y of a sample to 5.7″ · √(2/4) =
4.0″. The component of a circle has √2 times the uncertainty of a mean; over 1,200 samples this is
4.0″ · √(2/1,200) = 0.16″. The drift of the disc during the turn adds as much, so that the value is
about twice as large.
"""


def turning_table() -> tuple[HeadsDevice, Turning]:
    """Return the device and the thread that turns its table; the table has all causes of error."""
    device = HeadsDevice(SETTINGS)
    # The running average is off, so that the firmware evaluates each turn alone.
    device.firmware.set("keep", 0.0)
    turn_s = 2.0 * np.pi / SETTINGS.speed_rad_s
    course = TemperatureCourse(
        (FIRST_WARM_TURN * turn_s, LAST_WARM_TURN * turn_s), (20.0, 20.0 + WARM_K)
    )
    motion = Motion.steady(SETTINGS.speed_rad_s, 100.0 * turn_s, start_rad=-0.2)
    causes = (
        RadialMotion(3, complex(CIRCLE_M)),
        CreepingCentre(CREEP_M_A_TURN),
        ThermalCentre(complex(HEAT_M_A_K)),
    )
    instrument, firmware = device.instrument, device.firmware
    instrument.attach(device.table(*causes), dataclasses.replace(motion, temperature=course))
    firmware.start()
    begin, hertz = instrument.clock, instrument.clock_hz
    firmware.thermometer = lambda: float(
        course.at(np.array([(instrument.clock - begin) / hertz]))[0]
    )
    return device, Turning(instrument, SETTINGS.poll_clocks)


@pytest.fixture
def turning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> Iterator[tuple[HeadsDevice, Turning]]:
    monkeypatch.setenv(FOLDER_VARIABLE, str(tmp_path / "run"))
    device, made = turning_table()
    made.start()
    yield device, made
    made.end()


def circle_arcsec(x: list[float], y: list[float]) -> float:
    """Return the radius of the circle with three periods per turn, which the closed path contains;
    the points have equal steps of angle."""
    path = np.array(x[:-1]) + 1j * np.array(y[:-1])
    place = 2.0 * np.pi * (np.arange(path.size) + 0.5) / path.size
    return max(abs(np.mean(path * np.exp(sense * 3j * place))) for sense in (1, -1))


@pytest.mark.large
def test_drift_heat_orbit_and_a_fault_of_the_compiled_instrument(
    turning: tuple[HeadsDevice, Turning], page: Page, tmp_path: Path
) -> None:
    device, instrument = turning
    store, state, port = tmp_path / "store", tmp_path / "state", instrument.port.name
    with (
        daemon(port, store, "--no-alarm-capture"),
        page_server(tmp_path, state, "--device", port) as address,
    ):
        page.goto(f"{address}/device/")
        main = page.locator("main")
        instrument.last = CALIBRATED
        expect(main).to_have_attribute("data-turn", str(CALIBRATED))
        # The coefficients stay fixed, so that the page shows the drift of the table since the
        # calibration.
        instrument.order(lambda firmware: firmware.send("freeze on"))
        instrument.last = DRIFTED
        expect(main).to_have_attribute("data-turn", str(DRIFTED))

        shown = page.request.get(f"{address}/device/state").json()
        since = shown["since"]["calibration"]
        first_order = next(c for c in since["changes"] if c["quantity"] == "order 1")
        turns = DRIFTED - since["turn"]
        assert turns >= 5
        moved_m = HEAT_M_A_K * WARM_K + CREEP_M_A_TURN * turns
        expected_arcsec = abs(moved_m) * ARCSEC_A_METRE
        assert first_order["u_arcsec"] < 0.05 * expected_arcsec
        assert first_order["size_arcsec"] == pytest.approx(
            expected_arcsec, abs=SIGMAS * first_order["u_arcsec"]
        )
        row = page.locator("#changed tbody tr", has_text="order 1").first
        expect(row).to_contain_text(f"{first_order['size_arcsec']:.3f}″")
        expect(row).to_contain_text("changed")
        expect(page.locator("#changed tbody")).to_contain_text(f"temperature, table{WARM_K:.1f} °C")
        # The error is far above the 2″ at which the firmware raises the alarm.
        expect(page.locator("#alarm-list")).to_contain_text("error")
        expect(page.locator("#events")).to_contain_text("new alarm: error")
        # The firmware finds the circles of the axis only after it has found the places of all
        # heads.
        expect(page.locator("#axis")).to_be_hidden()
        instrument.order(lambda _: device.calibrate_alone())
        instrument.last = ALL_HEADS
        expect(main).to_have_attribute("data-turn", str(ALL_HEADS))
        shown = page.request.get(f"{address}/device/state").json()
        circle = CIRCLE_M * ARCSEC_A_METRE
        radii = next(c for c in shown["charts"]["axis"] if c["name"] == "3 a turn, forward")
        assert radii["arcsec"][-1] == pytest.approx(circle, abs=SIGMAS * U_CIRCLE_ARCSEC)
        expect(page.locator("#chart-axis .main-svg").first).to_be_visible()

        # A click diagnoses a capture of all heads, which also gives the orbit of the axis.
        instrument.last = ALL
        page.get_by_role("button", name="Take a capture").click()
        page.wait_for_url(re.compile(r"/s/[0-9a-f]{16}/1/$"))
        instrument.last = 0
        (kept,) = state.glob("*/set")
        capture = read_measurement_set(kept).capture
        assert capture is not None
        assert len(capture.heads) == 4
        page.goto(f"{address}/device/")
        expect(page.locator("#orbit-note")).to_contain_text("4 heads")
        expect(page.locator("#chart-orbit .main-svg").first).to_be_visible()
        mean = page.evaluate(
            "(({x, y}) => [Array.from(x), Array.from(y)])"
            "(document.getElementById('chart-orbit').data[1])"
        )
        assert circle_arcsec(*mean) == pytest.approx(circle, abs=SIGMAS * U_CIRCLE_ARCSEC)
        picture(page, "instrument")

        # A wire of head 2 breaks: the firmware refuses the next turns, and the page states the
        # reason.
        def break_a_wire(_: Firmware) -> None:
            broken = PinFault(device.instrument.clock + 1000, 10**9, low=HEAD2_A)
            device.instrument.disturb(broken)

        instrument.order(break_a_wire)
        instrument.last = instrument.turns() + 3
        expect(page.locator("#now tbody")).to_contain_text("resultrefused")
        expect(page.locator("#now tbody")).to_contain_text("reasonstands_still")
        picture(page, "instrument_fault")
