"""Defines a corrected table as an ophyd-async device, and the bluesky plan that calibrates it.

Values come from the PVs of ``arctrue device epics``. Coefficients are sent through the console of
``arctrue device run``, which requires the daemon's token and ``--allow-control``, because a PV
cannot check a token.
"""

from __future__ import annotations

import asyncio
from collections.abc import Generator
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.base.extras import needs_extras
from arctrue.calibration import CalibrationSettings, calibrate
from arctrue.device.announcement import Announcement
from arctrue.device.connection import ask, console_through, daemon_of
from arctrue.device.console import ConsoleError
from arctrue.device.epics_records import INVALID
from arctrue.device.load import DEVICE_LOADS, send_coefficients, wait_until_judged
from arctrue.gateware.coefficient_file import read_coefficient_file, write_coefficient_file
from arctrue.measurement import read_measurement_set

with needs_extras():
    from bluesky import plan_stubs as bps
    from bluesky import preprocessors as bpp
    from bluesky.protocols import Movable, Triggerable
    from bluesky.utils import Msg
    from ophyd_async.core import (
        Array1D,
        AsyncStatus,
        Device,
        Reference,
        SignalR,
        StandardReadable,
        StandardReadableFormat,
        observe_value,
    )
    from ophyd_async.epics.core import epics_signal_r, epics_signal_rw

CAPTURE_S = 400.0
"""Longest time of a capture in seconds, as in ``arctrue device epics``."""
JUDGED_S = 180.0
"""Longest time in seconds until captured turns have tested a loaded file. ``arctrue load`` waits
120 s unless the user states another time."""
TURN_S = 180.0
"""Longest time from one turn to the next, seconds."""


class NotVerifiedError(RuntimeError):
    """Is raised if the calibration raises an objection to the coefficients, or if the error that
    remains after loading is unknown or larger than permitted."""


class LoadedCoefficients(Device, Movable[Path]):
    """Coefficients of a device as an ophyd-async object whose position is the loaded coefficient
    file."""

    def __init__(self, port: str, turn: SignalR[int], name: str = "") -> None:
        """Store the device's ``port`` and the signal of its turns.

        Parameters
        ----------
        port : str
            Serial port of the device, or HOST:PORT of its daemon.
        turn : SignalR[int]
            Number of the latest turn.
        name : str
            Name in documents of bluesky.
        """
        self._port, self._turn = port, Reference(turn)
        super().__init__(name=name)

    @AsyncStatus.wrap
    async def set(self, value: Path) -> None:
        """Load a coefficient file; the move ends when turns have tested the file and the PVs show a
        later turn.

        Parameters
        ----------
        value : Path
            File of ``arctrue calibrate`` or ``arctrue export``.

        Raises
        ------
        LoadRefusedError
            If the device refuses the coefficients.
        ConsoleError
            If no daemon runs, the daemon is read-only, or turns do not test the coefficients within
            JUDGED_S seconds.
        TimeoutError
            If the PVs show no later turn within TURN_S seconds.
        ValueError, OSError
            If the file cannot be read or needs a part that no device can load.
        """
        last = await asyncio.to_thread(self._load, Path(value))
        async for number in observe_value(self._turn(), timeout=TURN_S):
            if number > last:
                return

    def _load(self, file: Path) -> int:
        """Load the file; return the number of the latest turn after the loading."""
        coefficients = read_coefficient_file(file, DEVICE_LOADS)
        daemon = self._daemon()
        console = console_through(daemon)
        try:
            sent = send_coefficients(console, coefficients, lambda done, of_all: None)
            wait_until_judged(console, sent, JUDGED_S)
        finally:
            console.close()
        return int((ask(daemon, "status")["latest"] or {}).get("turn", -1))

    def _daemon(self) -> Announcement:
        daemon = daemon_of(self._port)
        if daemon is None:
            text = "no daemon runs; start it with arctrue device run --allow-control"
            raise ConsoleError(f"{self._port}: {text}")
        return daemon


class CorrectedTable(StandardReadable, Triggerable):
    """A table that ``arctrue device epics`` serves; ``trigger`` captures the next turn."""

    def __init__(self, prefix: str, port: str, name: str = "") -> None:
        """Create the signals of the PVs with ``prefix``, and store the daemon's ``port``.

        Parameters
        ----------
        prefix : str
            Beginning of every PV, with the transport if it is not Channel Access:
            ``pva://LAB:TABLE:``.
        port : str
            Serial port of the device, or HOST:PORT of its daemon with the token in the environment
            variable ARCTRUE_DEVICE_TOKEN.
        name : str
            Name in documents of bluesky.
        """
        with self.add_children_as_readables(StandardReadableFormat.HINTED_SIGNAL):
            self.error_active = epics_signal_r(float, f"{prefix}ErrorActive")
            self.error_loaded = epics_signal_r(float, f"{prefix}ErrorLoaded")
        with self.add_children_as_readables():
            self.turn = epics_signal_r(int, f"{prefix}Turn")
            self.result = epics_signal_r(str, f"{prefix}Result")
            self.head_separation = epics_signal_r(float, f"{prefix}HeadSeparation")
            self.noise = epics_signal_r(float, f"{prefix}Noise")
            self.die_temperature = epics_signal_r(float, f"{prefix}DieTemperature")
            self.amplitudes = epics_signal_r(Array1D[np.float64], f"{prefix}Amplitudes")
            self.alarms = epics_signal_r(str, f"{prefix}Alarms")
            self.capture_set = epics_signal_r(str, f"{prefix}CaptureSet")
        self.connected = epics_signal_r(bool, f"{prefix}Connected")
        self.capture_fault = epics_signal_r(str, f"{prefix}CaptureFault")
        self.capture = epics_signal_rw(bool, f"{prefix}Capture")
        self.coefficients = LoadedCoefficients(port, self.turn)
        super().__init__(name=name)

    @AsyncStatus.wrap
    async def trigger(self) -> None:
        """Capture the next turn; ``capture_set`` is then the folder of the measurement set.

        Raises
        ------
        ConsoleError
            If the daemon could not capture a turn.
        """
        await self.capture.set(True, timeout=CAPTURE_S)
        fault = await self.capture_fault.get_value()
        if fault:
            raise ConsoleError(fault)


def calibrated_file(folder: Path, file: Path, settings: CalibrationSettings | None = None) -> Path:
    """Calibrate head 1 from a measurement set and write the coefficients, as ``arctrue calibrate``
    does.

    Parameters
    ----------
    folder : Path
        The measurement set.
    file : Path
        The coefficient file, which is replaced.
    settings : CalibrationSettings, optional
        Settings of the calibration; None: those of ``arctrue calibrate``.

    Returns
    -------
    Path
        ``file``.

    Raises
    ------
    NotVerifiedError
        If the calibration raises an objection to the coefficients; nothing is written.
    MeasurementError, ValueError, OSError
        If the set cannot be read or calibrated, or the file cannot be written.
    """
    calibration = calibrate(read_measurement_set(folder), settings or CalibrationSettings())
    if calibration.objections:
        raise NotVerifiedError(f"{folder}: {'; '.join(calibration.objections)}")
    write_coefficient_file(file, calibration.coefficients, folder.name)
    return file


def calibrate_load_verify(
    table: CorrectedTable,
    file: Path,
    limit_arcsec: float,
    settings: CalibrationSettings | None = None,
) -> Generator[Msg, Any, float]:
    """Return a plan that captures a turn, calibrates, loads the coefficients, and verifies them on
    further turns.

    The run has the streams ``before`` and ``after``, one event each. This program must be able to
    read the daemon's folder of captures.

    Parameters
    ----------
    table : CorrectedTable
        The table; it must turn.
    file : Path
        File to which the coefficients are written.
    limit_arcsec : float
        Largest permitted RMS of the error that remains after the correction, arcseconds.
    settings : CalibrationSettings, optional
        Settings of the calibration, for example the lanes of the gateware; None: those of
        ``arctrue calibrate``.

    Yields
    ------
    Msg
        Messages for the run engine.

    Returns
    -------
    float
        RMS of the remaining error after loading, arcseconds.

    Raises
    ------
    NotVerifiedError
        If that RMS is unknown or above the limit, or the calibration raises an objection.
    """

    left_arcsec = [np.nan]

    def run() -> Generator[Msg, Any, None]:
        yield from bps.trigger_and_read([table], name="before")
        folder = yield from bps.rd(table.capture_set)
        calibrated_file(Path(folder), file, settings)
        yield from bps.abs_set(table.coefficients, file, wait=True)
        readings = yield from bps.trigger_and_read([table], name="after")
        left = readings[table.error_loaded.name]
        if left.get("alarm_severity", 0) >= INVALID:
            raise NotVerifiedError(f"{table.name}: the device states no error for loaded orders")
        if not left["value"] <= limit_arcsec:
            raise NotVerifiedError(
                f"{table.name}: the loaded orders leave {left['value']:.3g}″ RMS; expected at most "
                f"{limit_arcsec:g}″"
            )
        left_arcsec[0] = float(left["value"])

    about = {"plan_name": "calibrate_load_verify", "limit_arcsec": limit_arcsec, "file": str(file)}
    yield from bpp.run_wrapper(run(), md=about)  # type: ignore[no-untyped-call]
    return left_arcsec[0]
