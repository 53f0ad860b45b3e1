"""Tests that each part of a schema 3 file is read, and that errors name the missing generic."""

from __future__ import annotations

import dataclasses
import re
from pathlib import Path

import numpy as np
import pytest

from arctrue.device.load import load_frames
from arctrue.gateware.capability import EVERYTHING, Capability
from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.gateware.coefficient_file_text import coefficient_file_text
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import Conditions, LocalTable, PhaseSource
from arctrue.gateware.mean_set import MeanSet
from arctrue.gateware.thermal import ThermalLanes

ROOT = Path(__file__).parents[3]
COUNTS = 2**24
PLAIN = Coefficients.from_harmonics([1, 3], [12.5, -7.0], [0.5, 1.0], COUNTS, 4, 1.5)
FOUR = MeanSet((20000, 15536, 14000, 16000), (0, 24606584, 160, 7), 2, 0, (0, 12, 255, 3))
THREE = MeanSet((40000, 30000, 0, -4464), (0, 5, 0, 6), 1, 3)
WITHOUT_3 = dataclasses.replace(PLAIN, extension=Extension(mean=THREE))
HALF_ORDER = dataclasses.replace(
    PLAIN,
    phase_steps=np.array([1 << 24, 3 << 24, 71 * 2**24 + 6710886, 1 << 23], dtype=np.uint64),
    amplitudes=np.array([25600, -14336, 300, 20480], dtype=np.int32),
)
PARTS = {
    "MEAN = true": Extension(mean=MeanSet((32768, 32768), (0, 16 * (COUNTS // 2)))),
    "HEADS = 4, MEAN = true": Extension(mean=FOUR),
    "MODULATORS = true": Extension(
        modulators=((0, "direction"), (1, "word_a")), conditions=Conditions(2560, 4, 90.0)
    ),
    # Lanes 2 and 3 have the orders 71.4 and 0.5; ``turn_steps`` has the fractions of the orders in
    # 2⁻⁴⁸ turn.
    "REAL_ORDERS = true": Extension(
        turn_steps=((2, round(0.4 * 2**48)), (3, 1 << 47)),
        phase_sources=((2, PhaseSource("probe", -1, 12345)), (3, PhaseSource("heads"))),
    ),
    "LOCAL_TABLE = true": Extension(
        local_table=LocalTable((-131072, 5, 131071), (4194304, 0), 6, 8)
    ),
    "HEADS = 4, MEAN = true, FAILOVER = true": Extension(
        mean=dataclasses.replace(FOUR, delays_clocks=()), without=(WITHOUT_3,)
    ),
}


def with_part(generics: str) -> Coefficients:
    base = HALF_ORDER if generics.startswith("REAL") else PLAIN
    return dataclasses.replace(base, extension=PARTS[generics])


@pytest.mark.parametrize("generics", PARTS)
def test_each_part_is_read_as_written_and_refused_without_its_generic(
    tmp_path: Path, generics: str
) -> None:
    path = tmp_path / "c.toml"
    path.write_text(coefficient_file_text(with_part(generics)), encoding="utf-8")
    assert "schema = 3\n" in path.read_text("utf-8")
    assert read_coefficient_file(path, EVERYTHING) == with_part(generics)
    needed = PARTS[generics].needs
    assert read_coefficient_file(path, needed) == with_part(generics)
    with pytest.raises(CoefficientFileError, match=re.escape(f"is built with {generics};")):
        read_coefficient_file(path)
    for field in dataclasses.fields(Capability):
        if getattr(needed, field.name) != getattr(Capability(), field.name):
            less = dataclasses.replace(needed, **{field.name: getattr(Capability(), field.name)})
            with pytest.raises(CoefficientFileError, match=f"with {field.name.upper()} = "):
                read_coefficient_file(path, less)


@pytest.mark.parametrize("has_sets", [False, True])
def test_all_parts_in_one_file_with_temperature(tmp_path: Path, has_sets: bool) -> None:
    """A file can contain all parts and temperature slopes. Only sets for a missing head and lanes
    of non-integer orders exclude each other, so there are two cases."""
    # The prepared set must have the delays and conditions of the file.
    conditions = Conditions(16, 0, 30.0)
    of_set = Extension(
        mean=dataclasses.replace(THREE, delays_clocks=FOUR.delays_clocks), conditions=conditions
    )
    everything = dataclasses.replace(
        HALF_ORDER,
        phase_steps=np.array([1 << 24, 3 << 24, 0, (not has_sets) << 23], dtype=np.uint64),
        thermal=ThermalLanes.from_slopes({3: np.array([1.0, 2.0, 0.0, 0.5])}, 20.0, 60.0),
        extension=Extension(
            FOUR,
            conditions,
            ((1, "speed"),),
            () if has_sets else ((3, 1 << 47),),
            LocalTable((1, 2, 3), (0,), 0, 10),
            (dataclasses.replace(PLAIN, extension=of_set),) if has_sets else (),
        ),
    )
    path = tmp_path / "c.toml"
    path.write_text(coefficient_file_text(everything), encoding="utf-8")
    assert read_coefficient_file(path, EVERYTHING) == everything


def test_the_words_of_the_mean_are_those_of_the_map() -> None:
    assert FOUR.words() == [0, 24606584, 160, 7, 20000, 15536, 14000, 16000, 0xF1]
    assert THREE.words()[7:] == [(1 << 32) - 4464, 0xB0]
    assert MeanSet((65536, 0), (0, 0)).words() == [0, 0, 0, 0, 65536, 0, 0, 0, 0x30]


def test_the_example_of_the_page_is_read(tmp_path: Path) -> None:
    page = (ROOT / "docs/map-extensions.md").read_text("utf-8")
    example = page.split("```toml\n")[1].split("```")[0]
    before, sets = example.split("[[without]]")
    whole_order = before.replace("order = 0.5", "order = 1").replace("8388608 ", "16777216 ")
    lines = [
        line
        for line in whole_order.splitlines()
        if not line.startswith(("turn_step", "phase_from"))
    ]
    path = tmp_path / "c.toml"
    for text, has_real, has_sets in (
        (before, True, False),
        ("\n".join([*lines, f"[[without]]{sets}"]), False, True),
    ):
        path.write_text(text, encoding="utf-8")
        found = read_coefficient_file(path, EVERYTHING)
        assert found.extension is not None
        assert found.extension.mean is not None
        assert found.extension.mean.weights == (19661, 45875)
        assert found.extension.needs == Capability(2, True, True, has_real, True, has_sets)
    path.write_text(example, encoding="utf-8")
    with pytest.raises(CoefficientFileError, match="a set for a missing head holds no turn steps"):
        read_coefficient_file(path, EVERYTHING)


@pytest.mark.parametrize(
    ("generics", "old", "new", "message"),
    [
        (
            "HEADS = 4, MEAN = true",
            "carrier = 2",
            "carrier = 5",
            "carrier: head 5, expected 1 to 4",
        ),
        ("HEADS = 4, MEAN = true", "weight_word = 14000", "weight_word = 14001", "weight: found"),
        ("HEADS = 4, MEAN = true", "offset_word = 160", "offset_word = 161", "offset_counts: fou"),
        ("HEADS = 4, MEAN = true", "delay_clocks = 255", "delay_clocks = 256", "delay of head 3"),
        ("MODULATORS = true", '"direction"', '"weather"', "modulator 'weather', expected one of"),
        ("MODULATORS = true", "[conditions]", "[condition]", "condition: is not known"),
        ("REAL_ORDERS = true", "order = 0.5", "order = 0.75", "phase_step: found"),
        ("REAL_ORDERS = true", "turn_step = 140737488355328", "turn_step = 1", "turn_step: found"),
        ("REAL_ORDERS = true", '"heads"', '"stars"', "expected one of heads, probe"),
        ("REAL_ORDERS = true", '"probe"', '"heads"', "expected none with 'heads'"),
        ("REAL_ORDERS = true", "probe_side = -1", "probe_side = 99999", "probe_side: 99999"),
        ("LOCAL_TABLE = true", "width_turn = 0.015625", "width_turn = 0.3", "1/2, to 1/64"),
        ("LOCAL_TABLE = true", "[4194304, 0]", "[0, 1, 2]", "expected 1, 2 or 4, found 3"),
        ("LOCAL_TABLE = true", "131071", "131072", "points"),
        ("HEADS = 4, MEAN = true, FAILOVER = true", "head = 3", "head = 1", "weight of head 1"),
        ("HEADS = 4, MEAN = true, FAILOVER = true", "head = 3", "head = 5", "is not in [mean]"),
        (
            "HEADS = 4, MEAN = true, FAILOVER = true",
            "[40000, 30000, 0, -4464]",
            "[40000, 30000, 0, -4463]",
            "expected a sum of 65536 (1.0), found 65537",
        ),
    ],
)
def test_what_is_wrong_is_named(
    tmp_path: Path, generics: str, old: str, new: str, message: str
) -> None:
    text = coefficient_file_text(with_part(generics))
    assert old in text
    path = tmp_path / "c.toml"
    path.write_text(text.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(CoefficientFileError, match=r"c\.toml: ") as found:
        read_coefficient_file(path, EVERYTHING)
    assert message in str(found.value)


def test_weights_that_leave_the_format_are_refused() -> None:
    with pytest.raises(ValueError, match=r"weight of head 1: -2\.45, the gateware holds -2"):
        MeanSet((round(-2.45 * 65536), round(3.45 * 65536)), (0, 0))


@pytest.mark.parametrize("of_set", [False, True])
def test_prepared_sets_exclude_lanes_of_real_orders(of_set: bool) -> None:
    """Prepared sets are refused together with lanes of real orders: a prepared set contains no turn
    steps, so its lanes would keep the turn steps of the previous lanes."""
    steps = ((3, 1 << 47),)
    extension = Extension(THREE, turn_steps=steps if of_set else ())
    entry = dataclasses.replace(HALF_ORDER, extension=extension)
    with pytest.raises(ValueError, match="without: a set for a missing head holds no turn steps"):
        Extension(FOUR, turn_steps=() if of_set else steps, without=(entry,))


def test_a_file_with_slopes_and_modulators_loads_as_written(tmp_path: Path) -> None:
    """The lines that load the file into the device equal those that load the written
    coefficients."""
    written = dataclasses.replace(
        PLAIN,
        offset=0,
        thermal=ThermalLanes.from_slopes({1: np.array([1.0, 2.0, 0.0, 0.0])}, 20.0),
        extension=PARTS["MODULATORS = true"],
    )
    path = tmp_path / "c.toml"
    path.write_text(coefficient_file_text(written), encoding="utf-8")
    assert load_frames(read_coefficient_file(path, EVERYTHING)) == load_frames(written)
