"""Writes the recorded data as the folder of a measurement set, and the truth into a sealed file
next to the folder."""

from __future__ import annotations

import dataclasses
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from arctrue.measurement import (
    Capture,
    MeasurementSet,
    Reference,
    Table,
    write_measurement_set,
)
from arctrue.studies.hidden_effect.rig import CapturedTurn
from arctrue.studies.hidden_effect.settings import HiddenSettings
from arctrue.studies.simulate.truth import write_truth
from arctrue.table import DISC_RADIUS_M, HEAD_SEPARATION_RAD
from arctrue.table.cause import Cause


def write_set(
    folder: Path,
    title: str,
    settings: HiddenSettings,
    runs: Sequence[Sequence[CapturedTurn]],
    references: Sequence[Reference],
    drive_gear_teeth: float | None = None,
) -> None:
    """Write the turns of each run, and the rows of all reference runs in sequence."""
    turns = [(number, turn) for number, run in enumerate(runs) for turn in run]
    capture = Capture(
        run=np.concatenate([np.full(turn.time_s.size, number) for number, turn in turns]),
        time_s=np.concatenate([turn.time_s for _, turn in turns]),
        head1_counts=np.concatenate([turn.head1_counts for _, turn in turns]),
        head2_counts=np.concatenate([turn.head2_counts for _, turn in turns]),
        temperature_c=np.concatenate([turn.temperature_c for _, turn in turns]),
        clock_hz=settings.revolution.clock_hz,
    )
    reference = None
    if references:
        columns = [
            name for name, value in vars(references[0]).items() if isinstance(value, np.ndarray)
        ]
        rows: dict[str, Any] = {
            name: np.concatenate([getattr(item, name) for item in references]) for name in columns
        }
        reference = dataclasses.replace(references[0], **rows)
    facts = Table(
        counts_per_rev=settings.revolution.counts_per_rev,
        grating_lines=settings.revolution.lines,
        disc_diameter_mm=2e3 * DISC_RADIUS_M,
        head_separation_deg=float(np.rad2deg(HEAD_SEPARATION_RAD)),
        drive_gear_teeth=drive_gear_teeth,
    )
    write_measurement_set(folder, MeasurementSet(facts, capture, reference, title))


def seal(folder: Path, effect: str, causes: Sequence[Cause]) -> Path:
    """Write the hidden causes to a file next to the folder; only the program that judges the
    diagnosis reads this file."""
    truth: dict[str, Any] = {
        "schema": 1,
        "hidden": effect,
        "causes": [repr(cause) for cause in causes],
    }
    return write_truth(folder, truth)
