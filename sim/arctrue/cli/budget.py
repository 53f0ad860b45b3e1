"""arctrue budget: computes the uncertainty budget of a set's calibration."""

from __future__ import annotations

from importlib.metadata import version
from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure, true_minus
from arctrue.calibration.calibration import calibrate
from arctrue.calibration.capture_check import CaptureRefusedError
from arctrue.cli._loaded_set import (
    LoadedSet,
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._options import refuse_given, temperature_option
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.cli._terminal import say
from arctrue.measurement.digest import set_digest
from arctrue.metrology.budget import (
    BY_ANGLE_DEG,
    COVERAGE,
    Budget,
    reference_budget,
    two_heads_budget,
)
from arctrue.metrology.correction import Correction
from arctrue.workbench.model.growth import fitted
from arctrue.workbench.model.stations import model_of_stations


@click.command("budget", short_help="Print the uncertainty budget of a set's calibration.")
@set_argument
@common_options
@temperature_option
@for_people
def budget(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    temperature: float | None,
) -> None:
    """Print the uncertainty budget of the angle after calibration, one row per contribution.

    If SET has a capture, the calibration is that of `arctrue calibrate`. If it has only a reference
    run, the calibration is the model of --model or, without it, the harmonics that the targets
    determine. With --out the command writes budget.md, budget.html and budget.pdf into that folder.
    """
    loaded = load(measurement_set, model_file, folders)
    made = _budget(loaded, model_file, temperature)
    digest = set_digest(measurement_set)
    facts = [
        ("measurement set", loaded.measurement),
        ("SHA-256 of the set", digest),
        ("model", "none" if model_file is None else model_file.name),
        ("program", f"arctrue {version('arctrue')}"),
    ]
    _print(made)
    write_json(
        json_file,
        {
            "schema": 1,
            "set": {"title": loaded.measurement, "sha256": digest},
            "model": None if model_file is None else model_file.name,
            "program": f"arctrue {version('arctrue')}",
            "calibration": made.method,
            "contributions": [one.record() for one in made.contributions],
            "u_arcsec": made.u_arcsec,
            "effective_degrees_of_freedom": made.degrees_of_freedom,
            "expanded_arcsec": made.expanded_arcsec,
            "k": 2,
            "k_for_95_percent": made.coverage_factor,
            "by_angle": _by_angle(made),
            "not_stated": list(made.missing),
            "not_evaluated": list(made.not_evaluated),
            "checks": list(made.checks),
        },
    )
    if out is not None:
        from arctrue.report.budget_report import write_budget_report

        for path in write_budget_report(made, facts, out):
            console.print(f"wrote {path}", soft_wrap=True)


def _budget(loaded: LoadedSet, model_file: Path | None, temperature: float | None) -> Budget:
    measurement, observations = loaded.measurement_set, loaded.observations
    if measurement.capture is not None:
        if model_file is not None:
            raise ValueError(
                "--model is for a set with a reference run alone; this set has a capture, and its "
                "budget is that of arctrue calibrate: leave --model out"
            )
        refuse_given(
            ("temperature",),
            "is for a set with a reference run alone; the budget of a set with a capture holds at "
            "the capture's temperature",
        )
        try:
            return two_heads_budget(measurement, calibrate(measurement))
        except CaptureRefusedError as refusal:
            raise ValueError(f"the capture cannot be used ({refusal.reason}): {refusal}") from None
    model = loaded.model
    stations = observations.every_reference_row
    if model_file is None and stations is not None:
        model = model_of_stations(stations)
    with Progress("fitting"):
        model, _ = fitted(model, observations, loaded.effects)
    correction = Correction.of_model(model, observations, loaded.effects, temperature_c=temperature)
    return reference_budget(measurement, correction)


def _by_angle(made: Budget) -> dict[str, Any] | None:
    """Return the expanded uncertainty U (k = 2) at the readings; None if the budget applies only to
    the turn as a whole."""
    if made.u_by_angle_arcsec is None:
        return None
    return {
        "reading_deg": BY_ANGLE_DEG.tolist(),
        "expanded_arcsec": (COVERAGE * made.u_by_angle_arcsec).tolist(),
    }


def _print(made: Budget) -> None:
    from arctrue.report.budget_text import freedom, outcome

    say(f"Calibration: {made.method}\n")
    contributions = table(
        "Error of indication after correction, ″",
        words("quantity"),
        words("distribution"),
        *map(number, ("size", "cᵢ", "uᵢ", "νᵢ")),
    )
    for one in made.contributions:
        contributions.add_row(
            f"{one.quantity} ({one.evaluation})",
            one.distribution,
            figure(one.size_arcsec, 4),
            true_minus(f"{one.sensitivity:.3g}"),
            figure(one.u_arcsec, 4),
            freedom(one.degrees_of_freedom),
        )
    console.print(contributions)
    console.print(outcome(made), soft_wrap=True)
    if (at_angle := made.u_by_angle_arcsec) is not None:
        console.print(
            f"at readings every 5° (full covariance): U from {COVERAGE * at_angle.min():.4f}″ at "
            f"{BY_ANGLE_DEG[at_angle.argmin()]:g}° to {COVERAGE * at_angle.max():.4f}″ at "
            f"{BY_ANGLE_DEG[at_angle.argmax()]:g}°"
        )
    for heading, texts in (
        ("not stated", made.missing),
        ("not evaluated", made.not_evaluated),
        ("check", made.checks),
    ):
        for text in texts:
            console.print(f"{heading}: {text}", soft_wrap=True)
