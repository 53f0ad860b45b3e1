"""Gives access to the registers of the compiled core over its bus."""

from __future__ import annotations

import ctypes
from collections.abc import Coroutine, Sequence
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from arctrue.gateware.extension import Conditions
from arctrue.gateware.local_table import LocalTable
from arctrue.gateware.register_access import CaptureBank, CoefficientSet, RegisterMap, Snapshot
from arctrue.instrument.compiled_core import CompiledCore
from arctrue.instrument.errors import BusError

_T = TypeVar("_T")


def _now(coroutine: Coroutine[Any, Any, _T]) -> _T:
    """Return the result of a coroutine that never waits; over this bus, RegisterMap never waits."""
    try:
        coroutine.send(None)
    except StopIteration as done:
        result: _T = done.value
        return result
    raise AssertionError("an access to the compiled core never waits")


class CoreOnBus(CompiledCore):
    """The compiled core with the processor's access to its registers."""

    @cached_property
    def registers(self) -> RegisterMap:
        """Registers by name, with asynchronous methods; this class has the same methods in a
        synchronous form."""
        return RegisterMap(self._read_async, self._write_async)

    @property
    def interrupt(self) -> bool:
        """Level of the interrupt line."""
        return bool(self.library.instrument_interrupt(self.handle))

    def stall_bus(self, most_clocks: int, seed: int = 1) -> None:
        """Delay all channels of the bus by random times.

        Parameters
        ----------
        most_clocks : int
            Largest delay; each delay lasts 0 … ``most_clocks`` clocks.
        seed : int
            Seed of the random numbers.
        """
        self.library.instrument_stall(self.handle, most_clocks, seed)

    def read_words(self, address: int, count: int) -> list[int]:
        """Read words of 32 bits from the bus.

        Parameters
        ----------
        address : int
            Byte address of the first word.
        count : int
            Number of words.

        Returns
        -------
        list of int
            The words.

        Raises
        ------
        BusError
            If the core refuses the access.
        """
        words: NDArray[np.uint32] = np.zeros(count, dtype=np.uint32)
        failed = ctypes.c_uint32()
        response = self.library.instrument_read(
            self.handle, address, words.ctypes.data, count, ctypes.byref(failed)
        )
        self._check(response, failed.value)
        values: list[int] = words.tolist()
        return values

    def write_words(self, address: int, words: Sequence[int]) -> None:
        """Write words of 32 bits to the bus.

        Parameters
        ----------
        address : int
            Byte address of the first word.
        words : sequence of int
            The words.

        Raises
        ------
        BusError
            If the core refuses the access.
        """
        data = np.array([word & 0xFFFF_FFFF for word in words], dtype=np.uint32)
        failed = ctypes.c_uint32()
        response = self.library.instrument_write(
            self.handle, address, data.ctypes.data, data.size, ctypes.byref(failed)
        )
        self._check(response, failed.value)

    def _check(self, response: int, address: int) -> None:
        if response < 0:
            self._fail()
        if response:
            raise BusError(address, response)

    async def _read_async(self, address: int, count: int) -> Sequence[int]:
        return self.read_words(address, count)

    async def _write_async(self, address: int, words: Sequence[int]) -> None:
        self.write_words(address, words)

    def read(self, path: str) -> int:
        """Return the value of a register with a single field, or of ``register.field``.

        Parameters
        ----------
        path : str
            Name of the register, or of register and field.

        Returns
        -------
        int
            The value.
        """
        return _now(self.registers.read(path))

    def read_fields(self, path: str) -> dict[str, int]:
        """Return the values of all fields of a register.

        Parameters
        ----------
        path : str
            Name of the register.

        Returns
        -------
        dict
            Values by the names of the fields.
        """
        return _now(self.registers.read_fields(path))

    def write(self, path: str, value: int) -> None:
        """Write a value to the only field of a register.

        Parameters
        ----------
        path : str
            Name of the register.
        value : int
            The value.
        """
        _now(self.registers.write(path, value))

    def update(self, path: str, **values: int) -> None:
        """Change some fields of a register and keep the other fields.

        Parameters
        ----------
        path : str
            Name of the register.
        **values : int
            Values by the names of the fields.
        """
        _now(self.registers.update(path, **values))

    def command(self, *names: str) -> None:
        """Set bits of the register ``command`` for one clock.

        Parameters
        ----------
        *names : str
            Names of the bits.
        """
        _now(self.registers.command(*names))

    def snapshot(self) -> Snapshot:
        """Return positions, angles and times of heads 1 and 2 and of the output at one clock.

        Returns
        -------
        Snapshot
            The state of the core at this clock.
        """
        return _now(self.registers.snapshot())

    def read_capture(self) -> CaptureBank:
        """Return the capture bank that is ready; ``command("capture_release")`` releases it.

        Returns
        -------
        CaptureBank
            The samples of a turn.
        """
        return _now(self.registers.read_capture())

    def write_coefficients(self, coefficients: CoefficientSet) -> None:
        """Write all lanes to the idle coefficient bank; ``command("swap")`` makes it active.

        Parameters
        ----------
        coefficients : CoefficientSet
            The words of all lanes.
        """
        _now(self.registers.write_coefficients(coefficients))

    def write_conditions(self, conditions: Conditions, counts_per_rev: int) -> None:
        """Write the parameters of direction and speed to their idle bank.

        They are scaled to this instrument's clock; ``command("swap")`` makes this bank active.

        Parameters
        ----------
        conditions : Conditions
            The parameters.
        counts_per_rev : int
            Counts a turn.
        """
        _now(self.registers.write_conditions(conditions, counts_per_rev, self.clock_hz))

    def write_local_table(self, table: LocalTable) -> None:
        """Write a local table to its idle bank; ``command("swap")`` makes this bank active.

        Parameters
        ----------
        table : LocalTable
            The table.
        """
        _now(self.registers.write_local_table(table))
