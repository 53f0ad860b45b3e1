"""Tests of the functions that the firmware provides in place of the C library's, against this
machine's C library and against exact integers.

The tests compile the files for this machine and rename each function, so that the process keeps its
own library. test_qemu.py runs the same files on the ARM.
"""

from __future__ import annotations

import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from cffi import FFI
from sim.tests.firmware.library import FIRMWARE

ROUNDING = ("rint", "floor", "ceil")
CONVERSIONS = ("__aeabi_ul2d", "__aeabi_l2d")
MEMORY = ("memcpy", "memset", "memcmp", "strlen", "strncmp")


@pytest.fixture(scope="module")
def own(tmp_path_factory: pytest.TempPathFactory) -> tuple[FFI, Any]:
    """Return the three files as a library; every function has the prefix own_."""
    library = tmp_path_factory.mktemp("own") / "own.so"
    names = (*ROUNDING, *CONVERSIONS, *MEMORY)
    files = [str(FIRMWARE / "board" / f"{name}.c") for name in ("rounding", "wide_integer")]
    command = ["gcc", "-std=c11", "-O1", "-fPIC", "-shared", "-Wall", "-Wextra", "-Werror"]
    command += ["-fno-builtin", "-fsanitize=undefined", "-fno-sanitize-recover=all"]
    command += [f"-D{name}=own_{name}" for name in names]
    command += [*files, str(FIRMWARE / "board" / "memory.c"), "-o", str(library), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    ffi = FFI()
    ffi.cdef(
        "\n".join(f"double own_{name}(double x);" for name in ROUNDING)
        + """
        double own___aeabi_ul2d(uint64_t value);
        double own___aeabi_l2d(int64_t value);
        void *own_memcpy(void *to, const void *from, size_t bytes);
        void *own_memset(void *to, int value, size_t bytes);
        int own_memcmp(const void *first, const void *second, size_t bytes);
        size_t own_strlen(const char *text);
        int own_strncmp(const char *first, const char *second, size_t most);
        """
    )
    assert Path(library).exists()
    return ffi, ffi.dlopen(str(library))


@pytest.mark.parametrize("name", ROUNDING)
def test_rounding_equals_the_c_library(own: tuple[FFI, Any], name: str) -> None:
    """All 64 bits of the results agree, also the sign of 0, for halves and the numbers next to
    them, values of every exponent, 2^52 and above, and infinity."""
    random = np.random.default_rng(1)
    near = np.arange(-9, 10) / 2.0
    every = np.ldexp(random.uniform(-1.0, 1.0, 4000), random.integers(-60, 80, 4000))
    large = np.array([2.0**51 + 0.5, 2.0**52 - 0.5, 2.0**52, 2.0**53, np.inf, 0.0, 5e-324])
    values = np.concatenate((near, np.nextafter(near, 99), np.nextafter(near, -99), every))
    values = np.concatenate((values, large, -large))
    mine = np.array([getattr(own[1], f"own_{name}")(value) for value in values])
    assert mine.tobytes() == getattr(np, name)(values).tobytes()
    assert np.isnan(getattr(own[1], f"own_{name}")(float("nan")))


def test_conversions_round_like_exact_integers(own: tuple[FFI, Any]) -> None:
    """The conversions equal those of Python, which rounds an integer to the nearest double and
    halves to even."""
    random = np.random.default_rng(2)
    some = [
        int(value) >> int(shift) for value, shift in random.integers(0, [1 << 63, 63], (4000, 2))
    ]
    ties = [(1 << bit) + (1 << bit - 53) + more for bit in range(53, 63) for more in (-1, 0, 1)]
    for value in [0, 1, (1 << 63) - 1, *some, *ties]:
        assert own[1].own___aeabi_ul2d(value) == float(value)
        assert own[1].own___aeabi_ul2d(value + (1 << 63)) == float(value + (1 << 63))
        assert own[1].own___aeabi_l2d(value) == float(value)
        assert own[1].own___aeabi_l2d(-value - 1) == float(-value - 1)


def test_memory_equals_bytes(own: tuple[FFI, Any]) -> None:
    """The functions are right for every start within a word and every length up to seven words; the
    bytes around do not change."""
    ffi, library = own
    source = bytes(range(1, 33))
    for start in range(4):
        for length in range(29):
            room = ffi.new("char[32]", b"." * 32)
            library.own_memcpy(room + start, ffi.from_buffer(source) + start, length)
            wanted = source[start : start + length]
            assert ffi.buffer(room)[:] == b"." * start + wanted + b"." * (32 - start - length)
            library.own_memset(room + start, 0x1A5, length)
            wanted = b"\xa5" * length
            assert ffi.buffer(room)[:] == b"." * start + wanted + b"." * (32 - start - length)


def test_comparisons(own: tuple[FFI, Any]) -> None:
    _, library = own
    for first, second in ((b"abc", b"abd"), (b"\xff", b"\x01"), (b"abc", b"abc"), (b"ab", b"abc")):
        for most in range(5):
            sign = (first[:most] > second[:most]) - (first[:most] < second[:most])
            assert np.sign(library.own_strncmp(first, second, most)) == sign
        sign = (first[:1] > second[:1]) - (first[:1] < second[:1])
        assert np.sign(library.own_memcmp(first, second, 1)) == sign
        assert library.own_memcmp(first, second, 0) == 0
        assert library.own_strlen(first) == len(first)
