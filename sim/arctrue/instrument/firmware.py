"""Runs the firmware's C sources as the processor of the instrument."""

from __future__ import annotations

import ctypes
import json
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from arctrue.gateware.coefficients import Coefficients
from arctrue.generated.number_formats import LANES_MAX
from arctrue.instrument.errors import BusError, InstrumentError
from arctrue.instrument.library import FirmwareBus

_ANSWERS = ("", "is not a parameter of the firmware", "is out of range", "must be a whole number")


class Core(Protocol):
    """The methods of the instrument that the firmware needs."""

    library: Any
    handle: Any
    clock_hz: float

    @property
    def clock(self) -> int:
        """Number of clocks since power-on."""

    @property
    def ended(self) -> bool:
        """True after the end of the stimulus."""

    @property
    def message(self) -> str:
        """Latest message of the harness."""

    def run(self, clocks: int, *, stage: str = "") -> None:
        """Run the core for ``clocks`` clocks."""

    def read(self, path: str) -> int:
        """Return the value of a register with a single field, or of ``register.field``."""


class Firmware:
    """The firmware without its hardware drivers, compiled for this machine (docs/firmware.md).

    Every register access of the firmware is made on the simulated bus and takes its clocks. A
    calculation takes ``calculation_clocks`` between reading a bank and using the result.

    Parameters
    ----------
    instrument : Core
        The core on whose bus the firmware makes its accesses.
    """

    def __init__(self, instrument: Core) -> None:
        """Create the processor; its parameters have their presets."""
        self._instrument = instrument
        self._library = instrument.library
        self._bus = self._library.firmware_bus_new(instrument.handle)
        self._processor = self._library.firmware_new(self._bus)
        self._view = ctypes.cast(self._bus, ctypes.POINTER(FirmwareBus)).contents
        self.telemetry: list[dict[str, Any]] = []
        """Telemetry lines of all turns since this object was created."""
        self.listener: Callable[[str], None] | None = None
        """Function that receives every text that the console prints, telemetry included."""
        self.thermometer: Callable[[], float | None] | None = None
        """Function that returns the present temperature, °C, or None if the thermometer does not
        answer."""
        self.send("telemetry on")

    def close(self) -> None:
        """Free the memory of the firmware's C code."""
        if self._processor:
            self._library.firmware_delete(self._processor)
            self._library.firmware_bus_delete(self._bus)
            self._processor = self._bus = None

    @property
    def accesses(self) -> int:
        """Number of the firmware's bus accesses since this object was created."""
        return int(self._view.accesses)

    @property
    def calculation_clocks(self) -> int:
        """Number of clocks that one calibration takes."""
        return int(self._view.calculation_clocks)

    @calculation_clocks.setter
    def calculation_clocks(self, clocks: int) -> None:
        self._view.calculation_clocks = clocks

    def set(self, name: str, value: float) -> None:
        """Set a parameter like ``set`` on the console, but without re-arming the heads.

        Call :meth:`start` after setting parameters that are registers.

        Parameters
        ----------
        name : str
            Name of the parameter.
        value : float
            Its value, in the unit in which the command ``set`` of the console takes it.

        Raises
        ------
        InstrumentError
            If the firmware refuses the name or the value.
        """
        answer = self._library.firmware_set(self._processor, name.encode(), float(value))
        if answer:
            raise InstrumentError(f"parameter {name} = {value:g}: {name} {_ANSWERS[answer]}")

    def start(self) -> None:
        """Make the firmware find the core, set it up and re-arm its heads.

        Raises
        ------
        InstrumentError
            If the firmware does not accept the core.
        """
        self._library.firmware_start(self._processor)
        self._check_bus()
        if self.phase == "no_core":
            raise InstrumentError("the firmware finds no core, or the core refused its set-up")

    def fault(self) -> None:
        """Restart the firmware as after a fault; the core continues to run."""
        self._library.firmware_fault(self._processor)
        self._check_bus()

    @property
    def flash(self) -> bytes:
        """Content of the non-volatile memory, which the command ``save`` writes."""
        size = int(self._library.firmware_flash_bytes())
        return ctypes.string_at(self._library.firmware_flash(self._processor), size)

    def power_on(self, flash: bytes) -> None:
        """Start like a board with this flash content; it replaces :meth:`start`.

        Parameters
        ----------
        flash : bytes
            Content of the non-volatile memory, as :attr:`flash` gives it.

        Raises
        ------
        InstrumentError
            If the flash has another size, or no core is accepted.
        """
        size = int(self._library.firmware_flash_bytes())
        if len(flash) != size:
            raise InstrumentError(f"the flash has {size} bytes, found {len(flash)}")
        ctypes.memmove(self._library.firmware_flash(self._processor), flash, size)
        self._library.firmware_power_on(self._processor)
        self._check_bus()
        if self.phase == "no_core":
            raise InstrumentError("the firmware finds no core, or the core refused its set-up")

    def step(self) -> str:
        """Run one round of the firmware's main loop.

        Returns
        -------
        str
            Output of the console without telemetry.
        """
        if self.thermometer is not None:
            celsius = self.thermometer()
            self._library.firmware_thermometer(
                self._processor,
                celsius is not None,
                0.0 if celsius is None else celsius,
                self._instrument.clock_hz,
            )
        self._library.firmware_step(self._processor)
        self._check_bus()
        return self._said()

    def send(self, line: str) -> str:
        """Type a line at the console.

        Parameters
        ----------
        line : str
            The line without its end.

        Returns
        -------
        str
            The answer.
        """
        return self.type(line.encode() + b"\r")

    def type(self, characters: bytes) -> str:
        """Type characters at the console; a line may come in parts.

        Parameters
        ----------
        characters : bytes
            Characters that the console receives; a zero byte ends the sequence.

        Returns
        -------
        str
            Answer to the lines that are complete, without telemetry.
        """
        self._library.firmware_type(self._processor, characters)
        self._check_bus()
        return self._said()

    def run(
        self,
        clocks: int | None = None,
        *,
        until: Callable[[Firmware], object] | None = None,
        poll_clocks: int = 5000,
        stage: str = "",
    ) -> None:
        """Run the core for some time, and the firmware's main loop with it.

        Parameters
        ----------
        clocks : int, optional
            Number of clocks after which the run ends; None: only ``until`` ends the run.
        until : callable, optional
            Function that is called with this object after every round; the run ends when it returns
            a true value.
        poll_clocks : int
            Number of clocks from one round of the main loop to the next.
        stage : str
            Name of this part of the run, for ``report_run``.

        Raises
        ------
        InstrumentError
            If ``clocks`` is None and the stimulus ends before ``until`` returns a true value.
        """
        instrument = self._instrument
        last = None if clocks is None else instrument.clock + clocks
        while True:
            self.step()
            if until is not None and until(self):
                return
            left = poll_clocks if last is None else last - instrument.clock
            if left <= 0:
                return
            ended = instrument.ended
            instrument.run(min(poll_clocks, left), stage=stage)
            if last is None and ended:
                raise InstrumentError(
                    f"the motion ended while the firmware was still in phase {self.phase}, "
                    f"after {len(self.telemetry)} turns"
                )

    @property
    def phase(self) -> str:
        """State: ``no_core``, ``wait_for_index``, ``capture``, ``swap`` or ``held`` (stopped after
        several faults in a row, or because the settings are lost)."""
        return str(self._library.firmware_phase(self._processor).decode())

    @property
    def coefficients(self) -> Coefficients | None:
        """Active coefficient bank as the firmware wrote it; None before the first swap of banks."""
        return self.active_bank(self._instrument.read("counts_per_rev_active"))

    def active_bank(self, counts_per_rev: int) -> Coefficients | None:
        """Return the active coefficient bank without a bus access.

        Parameters
        ----------
        counts_per_rev : int
            Counts a turn.

        Returns
        -------
        Coefficients or None
            The bank; None before the first swap.
        """
        steps = (ctypes.c_uint64 * LANES_MAX)()
        offsets = (ctypes.c_uint32 * LANES_MAX)()
        amplitudes = (ctypes.c_int32 * LANES_MAX)()
        lanes = self._library.firmware_coefficients(self._processor, steps, offsets, amplitudes)
        if not lanes:
            return None
        return Coefficients(
            np.array(steps[:lanes], dtype=np.uint64),
            np.array(offsets[:lanes], dtype=np.uint32),
            np.array(amplitudes[:lanes], dtype=np.int32),
            0,
            counts_per_rev,
        )

    def _said(self) -> str:
        text = self._library.firmware_said(self._processor).decode()
        if text and self.listener is not None:
            self.listener(text)
        rest = []
        for line in text.splitlines():
            if line.startswith("{"):
                self.telemetry.append(json.loads(line))
            else:
                rest.append(line)
        return "\n".join(rest)

    def _check_bus(self) -> None:
        response, address = self._view.first_response, self._view.first_address
        if response:
            self._view.first_response = 0
            if response < 0:
                raise InstrumentError(self._instrument.message)
            raise BusError(address, response)
