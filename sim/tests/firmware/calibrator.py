"""Calls the calibration library from Python: passes captures to the C code and returns its
estimates."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.library import firmware

from arctrue.generated import registers

Float = NDArray[np.float64]
ALPHA_RAD = float(np.radians(33.0))
BOTH_INDICES_SEEN = 0b11


def header_flag(name: str) -> int:
    """Return the bit of this flag in the capture header, from the register map."""
    (register,) = [r for r in registers.REGISTERS if r.path == "capture_header.flags"]
    (field,) = [f for f in register.fields if f.name == name]
    return 1 << field.shift


@dataclass
class CaptureInC:
    """A capture in the form of the C code, with the arrays that hold its memory."""

    capture: Any
    words: NDArray[np.int32]
    further: NDArray[np.int32]
    """Readings of heads 3 and 4."""


def words_of_bank(counts: NDArray[np.integer]) -> NDArray[np.int32]:
    """Return counts (2, n) modulo 2³², sample by sample."""
    return np.ascontiguousarray(counts.T.astype(np.int64).astype(np.uint32).view(np.int32))


def capture_in_c(counts: NDArray[np.integer], **fields: int) -> CaptureInC:
    """Return a capture in the form of the capture memory, from ``counts`` (heads, n)."""
    ffi, _ = firmware()
    # Counts are modulo 2^32, as in the position registers.
    words = words_of_bank(counts[:2])
    capture = ffi.new("struct capture *")
    further = words_of_bank(np.resize(counts[2:], (2, counts.shape[1])))
    capture.heads = len(counts)
    if len(counts) > 2:
        capture.further = ffi.cast("int32_t *", further.ctypes.data)
        capture.start = [int(row[0]) % COUNTS for row in counts] + [0] * (4 - len(counts))
    capture.words = ffi.cast("int32_t *", words.ctypes.data)
    capture.samples = counts.shape[1]
    capture.flags = BOTH_INDICES_SEEN
    capture.counts_per_rev = COUNTS
    capture.clock_hz = 100_000_000
    capture.period_clocks = 100_000
    for name, value in fields.items():
        setattr(capture, name, value)
    return CaptureInC(capture, words, further)


def verify(capture: CaptureInC, most_order: int = 32) -> tuple[str, Any, Any]:
    """Verify a capture and return (reason, turn, fault) of the C code."""
    ffi, library = firmware()
    turn, fault = ffi.new("struct turn *"), ffi.new("struct capture_fault *")
    reason = library.capture_verify(capture.capture, most_order, turn, fault)
    return ffi.string(library.refusal_name(reason)).decode(), turn, fault


def settings(orders: int = 32, **fields: Any) -> Any:
    ffi, _ = firmware()
    made = ffi.new("struct calibration_settings *")
    made.nominal_separation_rad = ALPHA_RAD
    made.orders = orders
    for name, value in fields.items():
        setattr(made, name, value)
    return made


def estimate(method: str, capture: CaptureInC, orders: int = 32, **fields: Any) -> tuple[str, Any]:
    """Verify the capture and return (reason, estimate) of ``fourier`` or ``least_squares``."""
    ffi, library = firmware()
    reason, turn, _ = verify(capture, orders)
    assert reason == "none", reason
    asked = settings(orders, **fields)
    library.turn_align(turn, asked.nominal_separation_rad)
    workspace = ffi.new(f"struct {method}_workspace *")
    made = ffi.new("struct estimate *")
    code = getattr(library, f"{method}_estimate")(workspace, turn, asked, made)
    return ffi.string(library.refusal_name(code)).decode(), made


def values_of(made: Any) -> Float:
    """Return the cosines, then the sines, in arcseconds."""
    harmonics = [made.harmonic[place] for place in range(made.orders)]
    return np.array([h.cosine for h in harmonics] + [h.sine for h in harmonics])


def per_order(made: Any, name: str) -> Float:
    """Return one field of every order's result, named ``name``."""
    return np.array([getattr(made.harmonic[place], name) for place in range(made.orders)])
