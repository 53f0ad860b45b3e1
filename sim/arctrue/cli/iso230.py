"""arctrue iso230: computes accuracy and repeatability of positioning according to ISO 230-2."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import click
import numpy as np
from numpy.typing import NDArray

from arctrue.base.figures import figure
from arctrue.cli._loaded_set import (
    LoadedSet,
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._numbers import Finite
from arctrue.cli._options import refuse_given, temperature_option
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import say, tell_warning
from arctrue.measurement.digest import set_digest
from arctrue.metrology.correction import Correction, reading_rad
from arctrue.metrology.iso230 import Contributions, Positioning, of_reference
from arctrue.workbench.model.growth import fitted

SHOWN_TARGETS = 40
"""Largest number of targets listed on the terminal; --json and --out contain all targets."""
SIGN = (
    "positioning deviations: actual minus target position of a servo that follows head 1; the "
    "error of indication in reference.csv has the other sign"
)


@click.command("iso230", short_help="Print the figures of ISO 230-2 for the reference run.")
@set_argument
@common_options
@click.option(
    "--drift",
    "drift_arcsec",
    type=Finite(min=0.0),
    help="Environmental variation: range of the readings at rest over the duration of a test, ″.",
)
@temperature_option
@for_people
def iso230(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    drift_arcsec: float | None,
    temperature: float | None,
) -> None:
    """Print the parameters of ISO 230-2 for the reference run of SET, per target and over the turn.

    With --model the command also prints the parameters after a correction by this model. Masked
    rows are not used. With --out the command writes iso230.md, iso230.html and iso230.pdf into that
    folder.
    """
    if model_file is None:
        refuse_given(("temperature",), "is the temperature of a correction; give its --model")
    loaded = load(measurement_set, model_file, folders)
    reference = loaded.measurement_set.reference
    if reference is None:
        raise ValueError(f"{measurement_set}: the figures of ISO 230-2 need a reference run")
    before = of_reference(reference)
    after = None
    notes: list[str] = []
    if model_file is not None:
        correction = _correction(loaded, temperature)
        readings = reading_rad(reference, loaded.observations.counts_per_rev)
        after = of_reference(reference, correction.error_arcsec(readings, reference.direction))
        notes += [f"not corrected: {text}" for text in correction.left_out]
        if any(
            step.measurement_sha256 == set_digest(measurement_set) for step in loaded.model.history
        ):
            notes.append("the model was fitted to this run: no independent test of the correction")
        for warning in correction.warnings:
            tell_warning(warning)
    contributions = Contributions.from_drift(reference.standard_uncertainty_arcsec, drift_arcsec)
    uncertainty = contributions.expanded(before.approaches)
    notes += _lacking(contributions)
    _print(before, after, uncertainty, notes)
    data = _data(before, after, uncertainty, notes, contributions)
    data["set"] = {"title": loaded.measurement, "sha256": set_digest(measurement_set)}
    data["model"] = None if model_file is None else model_file.name
    data["program"] = f"arctrue {version('arctrue')}"
    write_json(json_file, data)
    if out is not None:
        # matplotlib is imported here, because its import takes longer than the computation of the
        # figures.
        from arctrue.report.iso230_report import write_iso230_report

        for path in write_iso230_report(data, before, after, out):
            console.print(f"wrote {path}", soft_wrap=True)


def _correction(loaded: LoadedSet, temperature: float | None) -> Correction:
    model = loaded.model
    if not all(entry.coefficients for entry in model.effects):
        with Progress("fitting"):
            model, _ = fitted(model, loaded.observations, loaded.effects)
    return Correction.of_model(
        model, loaded.observations, loaded.effects, temperature_c=temperature
    )


def _lacking(contributions: Contributions) -> list[str]:
    found = []
    if contributions.device_arcsec is None:
        found.append(
            "no uncertainty of A, E and M: reference.standard_uncertainty_arcsec is not stated in "
            "measurement.toml"
        )
    if contributions.environment_arcsec is None:
        found.append("no uncertainty of the environmental variation: state its range by --drift")
    return found


def _print(
    before: Positioning,
    after: Positioning | None,
    uncertainty: dict[str, float],
    notes: list[str],
) -> None:
    if before.objections:
        say(f"Not according to ISO 230-2: {'; '.join(before.objections)}.")
    else:
        say("According to ISO 230-2.")
    say(f"Signs: {SIGN}.\n")
    headings = ("measured", *(("corrected",) if after else ()), "U (k = 2)")
    turn = table("Over the turn, ″", words("figure"), *map(number, headings))
    corrected = after.figures() if after else {}
    for name, value in before.figures().items():
        cells = [figure(value, 3), *([figure(corrected[name], 3)] if after else [])]
        turn.add_row(name, *cells, figure(uncertainty[name], 3))
    console.print(turn)
    for title, which in (("measured", before), ("corrected", after)):
        if which is not None:
            _print_targets(which, title)
    for note in notes:
        console.print(note, soft_wrap=True)


def _print_targets(which: Positioning, title: str) -> None:
    headings = ("target °", "x̄↑", "x̄↓", "x̄", "B", "R↑", "R↓", "R")
    targets = table(f"Per target, {title}, ″", *map(number, headings))
    columns = target_columns(which)
    for row in range(min(which.target_deg.size, SHOWN_TARGETS)):
        targets.add_row(
            figure(which.target_deg[row], 4),
            *(figure(float(values[row]), 3) for values in columns.values()),
        )
    console.print(targets)
    if which.target_deg.size > SHOWN_TARGETS:
        say(f"and {which.target_deg.size - SHOWN_TARGETS} more targets; --json has all of them")


def target_columns(which: Positioning) -> dict[str, NDArray[np.float64]]:
    """Return the figures of all targets, arrays (targets,), by their symbols in ISO 230-2."""
    return {
        "x̄↑": which.up.mean_arcsec,
        "x̄↓": which.down.mean_arcsec,
        "x̄": which.mean_arcsec,
        "B": which.reversal_arcsec,
        "R↑": which.up.repeatability_arcsec,
        "R↓": which.down.repeatability_arcsec,
        "R": which.repeatability_arcsec,
    }


def _data(
    before: Positioning,
    after: Positioning | None,
    uncertainty: dict[str, float],
    notes: list[str],
    contributions: Contributions,
) -> dict[str, Any]:
    def part(which: Positioning) -> dict[str, Any]:
        return {
            "over_the_turn_arcsec": which.figures(),
            "targets": {
                "target_deg": which.target_deg,
                "approaches_up": which.up.approaches,
                "approaches_down": which.down.approaches,
                "s_up_arcsec": which.up.s_arcsec,
                "s_down_arcsec": which.down.s_arcsec,
                **{f"{name}_arcsec": values for name, values in target_columns(which).items()},
            },
        }

    return {
        "schema": 1,
        "by_the_standard": not before.objections,
        "not_by_the_standard": list(before.objections),
        "sign": SIGN,
        "measured": part(before),
        "corrected": None if after is None else part(after),
        "expanded_uncertainty_arcsec": uncertainty,
        "u_device_arcsec": contributions.device_arcsec,
        "u_environment_arcsec": contributions.environment_arcsec,
        "notes": notes,
    }
