from __future__ import annotations

import shutil
import subprocess

import pytest

from arctrue.gateware.register_types import Field, Register
from arctrue.generated import registers
from tb.registers import arctrue_registers_model as model_map
from tb.support.simulation import ROOT, simulate


def test_register_block() -> None:
    simulate("arctrue_registers_harness", "tb.registers.arctrue_registers_bench")


def test_generated_names_equal_the_model() -> None:
    """The generated addresses, masks and reset values in Python equal those of the handwritten
    model."""
    by_address = {register.address: register for register in registers.REGISTERS}

    def mask(register: Register) -> int:
        return sum(field.mask for field in register.fields)

    for address, (bits, reset, _) in model_map.READ_WRITE.items():
        register = by_address[address]
        assert mask(register) == bits, register.path
        assert sum((field.reset or 0) << field.shift for field in register.fields) == reset
    for address, (bits, port) in model_map.READ_ONLY.items():
        register = by_address[address]
        assert mask(register) == bits, register.path
        assert register.path.replace(".", "_") == port
        assert not register.writable
    assert registers.CONTROL_CAPTURE_ENABLE_MASK == 0b100
    assert registers.COEFFICIENTS_ADDRESS == model_map.COEFFICIENTS
    assert registers.CAPTURE_ADDRESS == model_map.CAPTURE
    assert registers.MEAN_ADDRESS == model_map.MEAN
    assert registers.LOCAL_PLACE_CHOICE_ADDRESS == model_map.LOCAL_PLACE
    assert registers.LOCAL_POINTS_ADDRESS == model_map.LOCAL_POINTS
    assert registers.TURN_STEPS_ADDRESS == model_map.TURN_STEPS
    assert registers.TURN_NUMBER_ADDRESS == model_map.TURN_NUMBER
    assert registers.FURTHER_CAPTURE_ADDRESS == model_map.FURTHER_CAPTURE
    assert registers.MAP_BYTES == 1 << 19


def test_registers_do_not_overlap() -> None:
    taken: dict[int, str] = {}
    for register in registers.REGISTERS:
        for word in range(register.words):
            address = register.address + 4 * word
            assert address not in taken, f"{register.path} overlaps {taken[address]}"
            windows = (
                (model_map.HEADS, 256),
                (model_map.CONDITIONS, 64),
                (model_map.LOCAL_PLACE, 32),
                (model_map.TURN_NUMBER, 4),
            )
            has_window = any(first <= address < first + size for first, size in windows)
            assert address < registers.COEFFICIENTS_ADDRESS or has_window
            taken[address] = register.path
        bits = 0
        for field in register.fields:
            assert not bits & field.mask, f"{register.path}.{field.name} overlaps its neighbour"
            bits |= field.mask


@pytest.mark.parametrize(
    ("field", "value", "word"),
    [
        (Field("a", 4, 3), 5, 0x50),
        (Field("a", 0, 8, signed=True), -1, 0xFF),
        (Field("a", 8, 8, signed=True), -128, 0x8000),
    ],
)
def test_field_values(field: Field, value: int, word: int) -> None:
    assert field.put(value) == word
    assert field.get(word | ~field.mask & 0xFFFFFFFF) == value


@pytest.mark.parametrize("value", [-1, 8])
def test_field_refuses_what_does_not_fit(value: int) -> None:
    with pytest.raises(ValueError, match="expected 0 to 7"):
        Field("a", 0, 3).put(value)


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no C compiler")
def test_c_header_compiles_and_places_the_registers() -> None:
    """The C header compiles with the firmware's options (C11, no warnings), and its addresses equal
    the model's."""
    program = """
    #include <stddef.h>
    #include "arctrue_registers.h"
    static_assert(offsetof(arctrue_registers_t, control) == 0x20, "");
    static_assert(offsetof(arctrue_registers_t, snapshot) == 0x100, "");
    static_assert(offsetof(arctrue_registers_t, head2) == 0xE0, "");
    static_assert(offsetof(arctrue_registers_t, coefficients) == 0x1000, "");
    static_assert(offsetof(arctrue_registers_t, capture) == 0x20000, "");
    """
    flags = ["-std=c11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-x", "c", "-"]
    subprocess.run(
        ["gcc", *flags, "-I", str(ROOT / "build" / "generated" / "c")],
        input=program,
        text=True,
        check=True,
        capture_output=True,
    )


def check_windows(generics: dict[str, int | str], environment: dict[str, str]) -> None:
    """Compare the answers at every address with the model's, for a core with these generics."""
    simulate(
        "arctrue_registers_harness",
        "tb.registers.arctrue_registers_bench",
        generics=generics,
        testcase=("every_word_of_the_map", "random_accesses_as_the_model"),
        environment=environment,
    )


@pytest.mark.parametrize(
    ("heads", "failover"),
    [
        (2, False),
        pytest.param(3, False, marks=pytest.mark.large),
        pytest.param(4, False, marks=pytest.mark.large),
        pytest.param(3, True, marks=pytest.mark.large),
        pytest.param(4, True, marks=pytest.mark.large),
    ],
)
def test_windows_of_the_mean_and_of_further_heads(heads: int, failover: bool) -> None:
    """A core accepts or refuses an access to every address as the register map states for its
    heads."""
    check_windows(
        {"HEADS": heads, "MEAN": "true", "FAILOVER": str(failover).lower()},
        {"HEADS": str(heads), **({"FAILOVER": "yes"} if failover else {})},
    )


@pytest.mark.parametrize(
    "built",
    [
        ("LOCAL_TABLE", "REAL_ORDERS"),
        pytest.param(("LOCAL_TABLE",), marks=pytest.mark.large),
        pytest.param(("REAL_ORDERS",), marks=pytest.mark.large),
    ],
    ids=" ".join,
)
def test_windows_of_the_local_table_and_of_real_orders(built: tuple[str, ...]) -> None:
    """A core accepts accesses to the points and the window ``local_place`` of the local table, to
    turn steps and turn number if these are built, and refuses accesses to the addresses next to
    them."""
    check_windows(dict.fromkeys(built, "true"), dict.fromkeys(built, "yes"))
