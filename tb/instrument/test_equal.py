"""Tests that compiled netlist and VHDL give equal outputs for equal inputs in every clock."""

from __future__ import annotations

import json
import zlib
from pathlib import Path

import numpy as np
import pytest

from tb.instrument.comparison import compare, differences
from tb.instrument.random_registers import with_random_registers
from tb.instrument.replay import Replay, compiled
from tb.instrument.stimuli import CASES, Case
from tb.support.simulation import simulate

# CORE_SETTLED: clock from which the pipeline and the answers of the bus have no unknown bits after
# the first reset.
CORE_SETTLED = 80
# CORE_FORGOTTEN: first clock at which values from before the second reset have no effect. The
# second reset of the bench ends at clock 3,080; some 300 clocks later the output is switched on
# again, and 100 clocks after that new coefficients are swapped in. Until then, outputs may depend
# on older values, because a reset keeps the coefficients and the levels of A and B on purpose.
CORE_FORGOTTEN = 3500
POWER_UPS = range(1, 9)
"""Seeds for the random values that the registers have before the first reset."""

SHORTEST = ("table_conditions-WINDOW7-LONGEST11", "sampler-DEPTH8-HEADS4")
"""Units that are compared without ``large``; a core with folded lanes, which contains most of the
others, is compared as well."""
ERROR_COMPENSATION = next(case for case in CASES if case.entity == "error_compensation")


def wish_for_outputs(replay: Replay, folder: Path) -> None:
    """Write the names of the netlist's outputs, which the bench records, to a file."""
    outputs = [port.name for port in replay.ports if not port.is_input]
    (folder / "outputs.json").write_text(json.dumps(outputs), encoding="utf-8")


def simulated(case: Case, replay: Replay, folder: Path) -> None:
    """Simulate the case in GHDL and write the recorded outputs into ``folder``."""
    random = np.random.default_rng(zlib.crc32(case.entity.encode()))
    stimulus = case.stimulus(random)
    (folder / "inputs.json").write_text(json.dumps(stimulus), encoding="utf-8")
    wish_for_outputs(replay, folder)
    simulate(
        case.entity,
        "tb.instrument.record_bench",
        generics=case.generics,
        environment={"ARCTRUE_EQUAL_FOLDER": str(folder)},
    )


@pytest.mark.parametrize(
    "case",
    [
        pytest.param(case, marks=pytest.mark.large if str(case) not in SHORTEST else ())
        for case in CASES
    ],
    ids=str,
)
def test_unit(case: Case, tmp_path: Path) -> None:
    replay = compiled(case.entity, case.generics)
    simulated(case, replay, tmp_path)
    assert not compare(replay, tmp_path, case.settled)


@pytest.mark.parametrize(
    "generics",
    [
        pytest.param({"LANES": 2, "CAPTURE_DEPTH": 16}, id="parallel", marks=pytest.mark.large),
        pytest.param(
            {"LANES": 4, "CAPTURE_DEPTH": 16, "FOLD": 2, "ROTATION": "table"}, id="folded_table"
        ),
        pytest.param(
            {"LANES": 2, "CAPTURE_DEPTH": 16, "HEADS": 4}, id="four_heads", marks=pytest.mark.large
        ),
    ],
)
def test_core(generics: dict[str, int | str], tmp_path: Path) -> None:
    replay = compiled("arctrue_core", generics)
    wish_for_outputs(replay, tmp_path)
    simulate(
        "arctrue_core",
        "tb.instrument.core_bench",
        generics=generics,
        environment={
            "ARCTRUE_EQUAL_FOLDER": str(tmp_path),
            "ARCTRUE_LANES": str(generics["LANES"]),
            "ARCTRUE_HEADS": str(generics.get("HEADS", 2)),
        },
    )
    # Read data may be unknown, because the accesses also read registers that, by the register map,
    # are undefined before their first event.
    assert not compare(replay, tmp_path, CORE_SETTLED, undefined={"s_axil_rdata"})
    noted = json.loads((tmp_path / "noted.json").read_text(encoding="utf-8"))
    unknown = [word for word in noted["s_axil_rdata"][CORE_SETTLED:] if set(word) - {"0", "1"}]
    assert len(unknown) < len(noted["s_axil_rdata"]) / 10
    # Check that the run includes answers OKAY and SLVERR, interrupts, a moving output, pulses of
    # trigger and compare, and an alarm.
    assert {"00", "10"} <= set(noted["s_axil_rresp"]) & set(noted["s_axil_bresp"])
    assert {"0", "1"} <= set(noted["interrupt"]) & set(noted["out_a"]) & set(noted["out_z"])
    assert {"0", "1"} <= set(noted["trigger_out"]) & set(noted["compare_out"])
    assert {"0", "1"} <= set(noted["alarm"])
    if generics.get("FOLD", 1) == 1:
        does_the_same_from_random_registers(noted, replay, tmp_path, generics)


def does_the_same_from_random_registers(
    noted: dict[str, list[str]], replay: Replay, folder: Path, generics: dict[str, int | str]
) -> None:
    """Check that, after reset and set-up, the outputs do not depend on the registers' values at
    power-up."""
    inputs = json.loads((folder / "inputs.json").read_text(encoding="utf-8"))
    usual = replay.outputs(inputs, folder)
    at_random = compiled("arctrue_core", generics, with_random_registers)
    # Collect the outputs until the core settles, to show that the seeds give different values; in
    # the first clock alone two draws may be equal.
    begun = {tuple(tuple(values[:CORE_SETTLED]) for values in usual.values())}
    for seed in POWER_UPS:
        other = at_random.outputs(inputs, folder, seed)
        begun.add(tuple(tuple(values[:CORE_SETTLED]) for values in other.values()))
        for name in usual:
            # The bus's handshakes are defined from CORE_SETTLED on, all other outputs later. With
            # more than two heads even the handshakes may differ for longer: the weights and offsets
            # of the mean, which survive a reset, determine when a capture is ready, and so when the
            # master reads the capture.
            is_handshake = name.startswith("s_axil") and name.endswith(("ready", "valid"))
            is_known = is_handshake and generics.get("HEADS", 2) == 2
            begin = CORE_SETTLED if is_known else CORE_FORGOTTEN
            cut = {name: noted[name][begin:]}
            reported = {name: other[name][begin:]}
            assert not differences(cut, reported, 0, undefined={"s_axil_rdata"}), f"seed {seed}"
    assert len(begun) == len(POWER_UPS) + 1, "two power-ups gave the same outputs"


def test_a_broken_netlist_is_noticed(tmp_path: Path) -> None:
    case = ERROR_COMPENSATION

    def one_minus(text: str) -> str:
        # Replace the last addition in the netlist by a subtraction.
        head, plus, tail = text.rpartition(" + ")
        return head + " - " + tail if plus else text

    replay = compiled(case.entity, case.generics, one_minus)
    simulated(case, replay, tmp_path)
    assert compare(replay, tmp_path, case.settled)
