"""Tests the ophyd-async device and its plan with PVAccess, the daemon and the firmware's
console."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import ARCSEC, Disc
from sim.tests.cli.test_load import file_of
from sim.tests.cli.test_monitor import Device
from sim.tests.device.daemon_process import daemon
from sim.tests.device.epics_process import PREFIX, free_ports, pvs
from sim.tests.faults.scene import Scene
from sim.tests.faults.setting import COUNTS as SCENE_COUNTS
from sim.tests.faults.setting import POLL_CLOCKS, steady, true_error_counts
from sim.tests.firmware.test_estimates import DISC
from sim.tests.instrument.sizes import LANES
from sim.tests.instrument.turning import Turning

from arctrue.calibration import CalibrationSettings
from arctrue.gateware.coefficient_file import read_coefficient_file

pytest.importorskip("p4p", reason="softioc has x86-64 wheels only")
pytest.importorskip("ophyd_async")
from bluesky import RunEngine
from bluesky import plan_stubs as bps
from bluesky.utils import FailedStatus
from ophyd_async.core import init_devices

from arctrue.device.bluesky_table import (
    CorrectedTable,
    NotVerifiedError,
    calibrate_load_verify,
)


@pytest.fixture(scope="module")
def ports() -> Iterator[None]:
    """Set the same ports for all tests, because ophyd-async makes its PVAccess client once per
    process."""
    with pytest.MonkeyPatch.context() as patch:
        for name, value in free_ports().items():
            patch.setenv(name, value)
        yield


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[Device]:
    made = Device()
    os.close(made.far)  # the daemon is a separate program, which opens the port itself
    with made.running(monkeypatch):
        yield made


@pytest.fixture(scope="module")
def engine() -> RunEngine:
    return RunEngine()


def table_of(port: str) -> CorrectedTable:
    with init_devices(timeout=60.0):
        table = CorrectedTable(f"pva://{PREFIX}", port, name="table")
    # The device is connected only at the end of the block of init_devices.
    return table  # noqa: RET504


def test_a_plan_calibrates_loads_and_verifies(
    ports: None, engine: RunEngine, device: Device, tmp_path: Path
) -> None:
    """The plan writes a file that agrees with the disc's equation within 0.1″; noise and
    quantisation change the coefficients by less than this."""
    documents: list[tuple[str, dict[str, Any]]] = []
    left: list[float] = []
    file = tmp_path / "coefficients.toml"

    def plan() -> Any:
        left.append((yield from calibrate_load_verify(table, file, 0.1)))

    with (
        daemon(device.port, tmp_path / "store", "--allow-control"),
        pvs(device.port, "--allow-control"),
    ):
        table = table_of(device.port)
        engine(plan(), lambda name, document: documents.append((name, document)))
        # The second trigger must start a capture, although it writes the value that the PV already
        # has.
        engine(bps.trigger(table, wait=True))
    assert 0.0 <= left[0] <= 0.1
    events = [document["data"] for name, document in documents if name == "event"]
    streams = [document["name"] for name, document in documents if name == "descriptor"]
    assert streams == ["before", "after"]
    assert events[1]["table-turn"] > events[0]["table-turn"]
    assert events[1]["table-error_loaded"] == left[0]
    assert Path(events[0]["table-capture_set"]).is_dir()
    assert len(list((tmp_path / "store" / "captures").iterdir())) == 3
    assert documents[-1][1]["exit_status"] == "success"

    # The test decodes the file's words by their format, and compares the result with the disc's
    # equation at the true angles.
    found = read_coefficient_file(file)
    reading = np.linspace(0.0, 2.0 * np.pi, 3600, endpoint=False)
    phase = reading[:, None] * found.orders + 2.0 * np.pi * found.phase_offsets / 2**24
    counts = np.cos(phase) @ (found.amplitudes / 2**11)
    made_arcsec = counts * 1_296_000.0 / found.counts_per_rev
    # Two heads at 33° hardly see order 11 (11 · 33° = 363°): its 0.4″ are not significant in 600
    # samples.
    seen = Disc({order: wave for order, wave in DISC.orders.items() if order != 11})
    expected_arcsec = seen.error_rad(DISC.true_angle(reading)) / ARCSEC
    assert np.std(made_arcsec - expected_arcsec) < 0.1


@pytest.mark.large
def test_the_plan_runs_on_the_compiled_instrument(
    ports: None, engine: RunEngine, tmp_path: Path
) -> None:
    """The plan runs on the compiled gateware and firmware with a simulated table. A count is 79″,
    so that its rounding is 23″ RMS."""
    scene = Scene(steady(300.0))
    turning = Turning(scene.instrument, POLL_CLOCKS)
    turning.last = 250
    file, left = tmp_path / "coefficients.toml", list[float]()

    def plan() -> Any:
        # The rounding of both heads together is 32″ RMS, of which the fit removes almost nothing.
        settings = CalibrationSettings(most_order=8, lanes=LANES)
        left.append((yield from calibrate_load_verify(table, file, 1.3 * 33.0, settings)))

    turning.start()
    port = turning.port.name
    with (
        daemon(port, tmp_path / "store", "--allow-control"),
        pvs(port, "--allow-control"),
    ):
        table = table_of(port)
        engine(plan())
    turning.end()
    assert turning.firmware.telemetry[-1]["loaded_arcsec"] <= 1.3 * 33.0
    assert 0.0 < left[0] <= 1.3 * 33.0
    found = read_coefficient_file(file)
    angle = np.linspace(0.0, 2.0 * np.pi, 3600, endpoint=False)
    error_counts = true_error_counts(angle)
    reading = angle + 2.0 * np.pi * error_counts / SCENE_COUNTS
    phase = reading[:, None] * found.orders + 2.0 * np.pi * found.phase_offsets / 2**24
    made_counts = np.cos(phase) @ (found.amplitudes / 2**11)
    # The rounding of the difference of two heads is 0.41 counts RMS. The four lanes have eight
    # coefficients of a fit to 600 samples, and the separation of the heads magnifies the two of
    # order 1 by 1/(2 sin 16.5°) = 1.8: 0.41 · √(8/600) · 1.8 = 0.09 counts. The bound is three
    # times this.
    assert np.std(made_counts - error_counts) < 0.27


@pytest.mark.large
def test_what_is_wrong_or_not_allowed_fails_the_plan(
    ports: None, engine: RunEngine, device: Device, tmp_path: Path
) -> None:
    wrong = file_of(tmp_path, {1: (150.0, 0.4), 5: (8.0, 0.0)})
    with daemon(device.port, tmp_path / "store"), pvs(device.port, "--allow-control"):
        table = table_of(device.port)
        with pytest.raises(FailedStatus) as read_only:
            engine(bps.abs_set(table.coefficients, wrong, wait=True))
        assert "read-only" in str(read_only.value.__cause__)
    with (
        daemon(device.port, tmp_path / "store", "--allow-control"),
        pvs(device.port, "--allow-control"),
    ):
        with pytest.raises(FailedStatus) as refused:
            engine(bps.abs_set(table.coefficients, wrong, wait=True))
        assert "worse_prediction" in str(refused.value.__cause__)
        with pytest.raises(NotVerifiedError, match="expected at most 0″"):
            engine(calibrate_load_verify(table, tmp_path / "made.toml", 0.0))
