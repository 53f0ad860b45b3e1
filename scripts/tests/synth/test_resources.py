"""Tests the counts of cells and the budgets, with a handwritten netlist."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from scripts.resources import Design, Resources
from scripts.synth import (
    BUDGETS,
    BUDGETS_OF_EVERYTHING,
    SAVED_BY_A_TABLE,
    Budget,
    budgets_of,
    exceeded,
    fold_table,
    lane_of,
    main,
    wasted_folds,
)

BOXES = ("LUT2", "LUT3")


def write_design(path: Path, modules: dict[str, list[str]]) -> Path:
    """Write a netlist in the layout of Yosys: one name or type per line."""
    text = {
        "creator": "Yosys",
        "modules": {
            name: {
                "attributes": {"blackbox": "1"} if name in BOXES else {},
                "cells": {
                    f"cell{i}": {"hide_name": 1, "type": kind, "parameters": {}}
                    for i, kind in enumerate(kinds)
                },
            }
            for name, kinds in modules.items()
        },
    }
    path.write_text(json.dumps(text, indent=2), encoding="utf-8")
    return path


def test_cells_of_all_kinds_are_counted(tmp_path: Path) -> None:
    kinds = ["LUT2", "LUT6", "INV", "RAM32M", "SRL16E", "FDRE", "FDSE_1", "DSP48E1", "CARRY4"]
    kinds += ["RAMB36E1", "RAMB18E1", "LDCE", "MUXF7", "BUFG"]
    design = Design.read(write_design(tmp_path / "a.json", {"top": kinds}))
    expected = Resources(lut=1 + 1 + 1 + 4 + 1, ff=2, dsp=1, ramb36=1.5, carry4=1, latches=1)
    assert design.total("top") == expected


def test_units_are_summed_over_their_instances(tmp_path: Path) -> None:
    modules = {
        "LUT2": [],
        "LUT3": ["LUT6", "FDRE"],  # the cells in the model of a LUT3 do not count
        "phase_lane": ["DSP48E1"] * 3 + ["LUT2"],
        "harmonic_lane_18": ["DSP48E1", "FDRE"],
        "harmonic_lane_20": ["DSP48E1", "LUT3", "LUT3"],
        "top": ["phase_lane", "phase_lane", "harmonic_lane_18", "harmonic_lane_20", "LUT2"],
    }
    design = Design.read(write_design(tmp_path / "a.json", modules))
    assert design.total("top") == Resources(lut=2 + 2 + 1, ff=1, dsp=8)
    assert lane_of(design) == Resources(lut=3, dsp=4)
    rows = {name: (depth, count) for name, depth, count, _ in design.units("top")}
    assert rows["top"] == (0, 1)
    assert rows["phase_lane"] == (1, 2)
    assert not rows.keys() & set(BOXES)


def test_an_empty_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match="no module"):
        Design.read(write_design(tmp_path / "a.json", {}))


def test_every_budget_is_kept_at_its_limit_and_exceeded_one_above() -> None:
    kept = Resources(lut=38_000, ff=40_000, dsp=170, ramb36=60.0)
    lane = Resources(lut=1_050)
    assert exceeded(kept, lane, BUDGETS) == []
    for over, kind in (
        (kept + Resources(lut=1), "38001 LUT"),
        (kept + Resources(ff=1), "40001 FF"),
        (kept + Resources(dsp=1), "171 DSP"),
        (kept + Resources(ramb36=0.5), "60.5 RAMB36"),
        (kept + Resources(latches=1), "1 LATCHES"),
    ):
        (fault,) = exceeded(over, lane, BUDGETS)
        assert kind in fault
    (fault,) = exceeded(kept, lane + Resources(lut=1), BUDGETS)
    assert "the lane takes 1051 LUT, 1 above its budget of 1050" in fault
    assert exceeded(kept, None, (Budget("lane", "lut", 0),)) == []


def test_a_fold_that_saves_nothing_is_reported() -> None:
    cores = {1: Resources(lut=30, dsp=12), 4: Resources(lut=12, dsp=3), 2: Resources(lut=20, dsp=6)}
    assert wasted_folds(cores) == []
    assert "| 2 | 2 clocks | 20 | 0 | 6 | 0 | 0 |" in fold_table(cores, {"ROTATION": "table"})
    cores[8] = Resources(lut=13, dsp=3)
    assert wasted_folds(cores) == [
        "FOLD = 8 takes 13 LUT, FOLD = 4 only 12",
        "FOLD = 8 takes 3 DSP, FOLD = 4 only 3",
    ]


def test_a_table_has_to_make_room() -> None:
    """With ROTATION = table, a smaller budget applies to the LUTs of the core."""
    changed = [
        (one.part, one.kind, one.limit - other.limit)
        for one, other in zip(BUDGETS, budgets_of({"ROTATION": "table"}), strict=True)
        if one != other
    ]
    assert changed == [("core", "lut", SAVED_BY_A_TABLE)]
    assert budgets_of({"ROTATION": "cordic"}) == budgets_of({}) == BUDGETS


def test_everything_has_a_budget_for_each_rotation_and_takes_no_generics(
    capsys: pytest.CaptureFixture[str],
) -> None:
    limits = {
        rotation: {budget.kind: budget.limit for budget in budgets}
        for rotation, budgets in BUDGETS_OF_EVERYTHING.items()
    }
    assert limits["cordic"] == {"lut": 41_000, "dsp": 180, "ramb36": 112, "latches": 0}
    assert limits["table"] == {**limits["cordic"], "lut": 30_000}
    with pytest.raises(SystemExit):
        main(["--everything", "-g", "HEADS=3"])
    assert "omit --generic and --folds" in capsys.readouterr().err
