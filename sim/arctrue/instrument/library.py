"""Declares the C interface of the instrument's library; see native/abi.cpp and
native/firmware.c."""

from __future__ import annotations

import ctypes
from ctypes import (
    POINTER,
    c_char_p,
    c_double,
    c_int,
    c_int32,
    c_int64,
    c_uint8,
    c_uint16,
    c_uint32,
    c_uint64,
    c_void_p,
)
from functools import cache
from pathlib import Path
from typing import Any

NEED_PIECE = ctypes.CFUNCTYPE(c_int, c_void_p, c_int64)
"""Type of the function that the harness calls during a run to request the piece of the curves that
begins at a clock; the function returns 0 after it has set the piece."""


class Disturbance(ctypes.Structure):
    """C structure of a fault; see native/stimulus.h."""

    _fields_ = (
        ("first_clock", c_int64),
        ("clocks", c_int64),
        ("invert", c_uint16),
        ("low", c_uint16),
        ("high", c_uint16),
        ("probability", c_double),
    )


class TrackView(ctypes.Structure):
    """C structure of a recorded track; see native/abi.cpp. Its arrays are valid until the next
    clock."""

    _fields_ = (
        *((name, c_int64) for name in ("position", "edges", "illegal", "dropped")),
        *((name, c_int64) for name in ("kept", "bins", "indices")),
        ("kept_clock", POINTER(c_int64)),
        ("kept_position", POINTER(c_int64)),
        ("kept_angle", POINTER(c_double)),
        ("bin_edges", POINTER(c_int64)),
        ("bin_sum", POINTER(c_double)),
        ("bin_lowest", POINTER(c_double)),
        ("bin_highest", POINTER(c_double)),
        ("index_clock", POINTER(c_int64)),
        ("index_position", POINTER(c_int64)),
    )


_HANDLE = c_void_p
# name of the function: (type of its result, types of its arguments)
_FUNCTIONS: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "instrument_new": (_HANDLE, ()),
    "instrument_delete": (None, (_HANDLE,)),
    "instrument_message": (c_char_p, (_HANDLE,)),
    "instrument_clock": (c_int64, (_HANDLE,)),
    "instrument_true_angle": (c_double, (_HANDLE,)),
    "instrument_interrupt": (c_int, (_HANDLE,)),
    "instrument_hold_reset": (None, (_HANDLE, c_int)),
    "instrument_run": (c_int, (_HANDLE, c_int64, c_double, c_int, c_int)),
    "instrument_read": (c_int, (_HANDLE, c_uint32, c_void_p, c_int64, POINTER(c_uint32))),
    "instrument_write": (c_int, (_HANDLE, c_uint32, c_void_p, c_int64, POINTER(c_uint32))),
    "instrument_stall": (None, (_HANDLE, c_uint32, c_uint64)),
    "instrument_attach_curves": (
        None,
        (_HANDLE, NEED_PIECE, c_void_p, c_int64, c_int64, c_int64, c_double, c_int),
    ),
    "instrument_piece": (None, (_HANDLE, c_int64, c_int64, c_int64, c_int64, c_void_p)),
    "instrument_attach_events": (None, (_HANDLE, c_int64, c_void_p, c_void_p, c_uint8)),
    "instrument_detach": (None, (_HANDLE,)),
    "instrument_disturb": (None, (_HANDLE, c_int64, c_void_p, c_uint64)),
    "instrument_record": (
        None,
        (_HANDLE, c_int64, c_int64, c_int64, c_double, c_double, c_double),
    ),
    "instrument_stop_recording": (None, (_HANDLE,)),
    "instrument_track": (None, (_HANDLE, c_int, POINTER(TrackView))),
    "instrument_trace": (None, (_HANDLE, c_int64)),
    "instrument_traced": (c_int64, (_HANDLE, POINTER(POINTER(c_uint16)))),
    "firmware_bus_new": (_HANDLE, (_HANDLE,)),
    "firmware_bus_delete": (None, (_HANDLE,)),
    "firmware_bus_read": (c_uint32, (_HANDLE, c_uint32)),
    "firmware_new": (_HANDLE, (_HANDLE,)),
    "firmware_delete": (None, (_HANDLE,)),
    "firmware_start": (None, (_HANDLE,)),
    "firmware_fault": (None, (_HANDLE,)),
    "firmware_power_on": (None, (_HANDLE,)),
    "firmware_flash": (c_void_p, (_HANDLE,)),
    "firmware_flash_bytes": (c_uint32, ()),
    "firmware_step": (None, (_HANDLE,)),
    "firmware_type": (None, (_HANDLE, c_char_p)),
    "firmware_said": (c_char_p, (_HANDLE,)),
    "firmware_phase": (c_char_p, (_HANDLE,)),
    "firmware_thermometer": (None, (_HANDLE, c_int, c_double, c_double)),
    "firmware_set": (c_int, (_HANDLE, c_char_p, c_double)),
    "firmware_coefficients": (
        c_uint32,
        (_HANDLE, POINTER(c_uint64), POINTER(c_uint32), POINTER(c_int32)),
    ),
}


class FirmwareBus(ctypes.Structure):
    """First fields of the C structure FirmwareBus in native/abi.cpp."""

    _fields_ = (
        ("harness", c_void_p),
        ("accesses", c_int64),
        ("calculation_clocks", c_int64),
        ("first_response", c_int),
        ("first_address", c_uint32),
    )


@cache
def load(path: Path) -> Any:
    """Load the library and declare the types of its functions."""
    library = ctypes.CDLL(str(path), mode=ctypes.RTLD_LOCAL)
    for name, (result, arguments) in _FUNCTIONS.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library
