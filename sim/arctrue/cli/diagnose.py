"""arctrue diagnose: finds which physical effect a model lacks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import click

from arctrue.base.figures import figure, probability
from arctrue.cli._guide import commands, steps
from arctrue.cli._loaded_set import (
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._numbers import Finite
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.measurement import MeasurementSet
from arctrue.measurement.asked import KINDS
from arctrue.workbench.diagnose.adopted import adopt as write_adopted
from arctrue.workbench.diagnose.candidate import Candidate
from arctrue.workbench.diagnose.diagnosis import MATTERS_COUNTS, Diagnosis
from arctrue.workbench.diagnose.diagnosis import diagnose as diagnose_model
from arctrue.workbench.diagnose.report import sentences
from arctrue.workbench.diagnose.report_json import diagnosis_data
from arctrue.workbench.effects.product_of_parts import ProductOfParts
from arctrue.workbench.inference.left import Left
from arctrue.workbench.model.growth import settle

SHOWN = 8
FURTHER_STEPS = 8
"""Number of progress steps in addition to one per effect: fits, parts, noise, held-out rows."""
SHOWN_AT_LEAST = 3
"""Number of candidates that are always shown; further candidates, up to SHOWN in all, are shown
only if they improve the BIC."""


@click.command("diagnose", short_help="Name the effect that a model lacks.")
@set_argument
@common_options
@click.option(
    "--matters",
    type=Finite(min=0.0),
    default=MATTERS_COUNTS,
    show_default=True,
    help="RMS in counts below which an effect is negligible.",
)
@click.option(
    "--adopt",
    metavar="NAME",
    help="Write the found product of parts as an effect with this name.",
)
@click.option(
    "--folder",
    type=click.Path(path_type=Path),
    default=Path("effects"),
    show_default=True,
    help="Folder for the effect that --adopt writes.",
)
@for_people
def diagnose(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    matters: float,
    adopt: str | None,
    folder: Path,
) -> None:
    """Name the physical effect that the model lacks, if the data can identify it.

    Otherwise the command states that the model is adequate, that the effect is ambiguous or
    unknown, or that the data cannot decide or are faulty.
    """
    loaded = load(measurement_set, model_file, folders)
    with Progress("diagnosing", steps=len(loaded.effects) + FURTHER_STEPS) as progress:
        terms = settle(loaded.model, loaded.observations, loaded.effects)
        result = diagnose_model(
            loaded.observations,
            terms,
            loaded.effects,
            matters_counts=matters,
            report_step=progress.now,
        )
    _print(result)
    guide = _guide(result, loaded.measurement_set, measurement_set, model_file)
    for line in guide:
        console.print(line, soft_wrap=True)
    data = diagnosis_data(result, loaded.model.names())
    write_json(json_file, {**data, "next_measurement_guide": guide})
    if adopt is not None:
        console.print(f"wrote {_adopted(result, adopt, folder)}")
        console.print(f"use it: arctrue add {adopt} {measurement_set} --effects {folder}")
    if out is not None and result.base is not None:
        from arctrue.report.charts.candidates import candidates_chart
        from arctrue.report.charts.matplotlib_chart import save_chart

        console.print(f"wrote {save_chart(candidates_chart(result), out / 'candidates.png')}")


def _guide(
    result: Diagnosis, measurement: MeasurementSet, folder: Path, model_file: Path | None
) -> list[str]:
    """Return the instructions for the next measurement, one per line.

    The steps at the table come before the commands.
    """
    kind = result.next_measurement_kind
    if kind not in KINDS:
        return []
    try:
        at_the_table = steps(kind, measurement)
    except ValueError:
        # For a set without a capture there are no steps at the table; the text of the diagnosis
        # names the measurement.
        return []
    typed = commands(kind, folder, model=model_file)
    return ["At the table:", *(f"  {line}" for line in at_the_table), "Then:"] + [
        f"  {line}" for line in typed
    ]


def _adopted(result: Diagnosis, name: str, folder: Path) -> Path:
    """Write an effect from the product of parts that the diagnosis found; return its file.

    Raises ValueError if the diagnosis found no product.
    """
    found = None if result.described is None else result.described.effect
    if not isinstance(found, ProductOfParts):
        raise ValueError(
            f"nothing to adopt: the diagnosis (verdict {result.verdict}) found no product of parts"
        )
    return write_adopted(found, name, result.description or "", folder)


def _rows(item: Candidate, after: Left | None) -> list[tuple[str, ...]]:
    """Return one row per channel, or one row without a channel if the remaining error was not
    computed. The first row also has name and evidence; a dash marks a value that was not computed.
    """
    first = (item.name, probability(item.p_corrected), figure(item.delta_bic, 0))
    if after is None:
        return [(*first, "", "–", "–")]
    return [
        (
            *(first if place == 0 else ("", "", "")),
            channel,
            figure(value, 4),
            figure(after.heldout_rms_arcsec.get(channel), 4),
        )
        for place, (channel, value) in enumerate(after.rms_arcsec.items())
    ]


def _by_what_lacks(untestable: Mapping[str, Sequence[str]]) -> dict[str, list[str]]:
    """Return the names of the effects, grouped by the data that the set lacks for them."""
    found: dict[str, list[str]] = {}
    for name, lacking in untestable.items():
        found.setdefault("; ".join(lacking), []).append(name)
    return found


def _print(result: Diagnosis) -> None:
    if result.candidates:
        candidates = table(
            "Candidates, best first",
            words("effect"),
            number("p"),
            number("ΔBIC"),
            words("channel"),
            number("left with\nit, RMS ″"),
            number("held\nout ″"),
        )
        gaining = sum(item.delta_bic > 0.0 for item in result.candidates)
        shown = result.candidates[: min(SHOWN, max(gaining, SHOWN_AT_LEAST))]
        for item in shown:
            for row in _rows(item, result.left.get(item.name)):
                candidates.add_row(*row)
        console.print(candidates)
        if any(item.name not in result.left for item in shown):
            console.print(
                "–: not calculated. The remaining error is calculated for the effect of the "
                "verdict, and for the effects that this data cannot distinguish from that effect."
            )
        if len(result.candidates) > len(shown):
            more = len(result.candidates) - len(shown)
            console.print(f"{more} more candidates are not shown; --json has all of them.")
    before = result.before
    for channel, value in {} if before is None else before.rms_arcsec.items():
        assert before is not None
        lack = result.channels[channel].lack_of_fit_p
        console.print(
            f"{channel}: left {figure(value, 4)}″ RMS, held out "
            f"{figure(before.heldout_rms_arcsec.get(channel), 4)}″, noise of the repeats "
            f"{figure(before.noise_arcsec[channel], 4)}″, lack of fit p "
            f"{probability(float('nan') if lack is None else lack)}"
        )
    for lacking, names in _by_what_lacks(result.untestable).items():
        console.print(f"Not tested: {', '.join(names)}. The set lacks {lacking}.")
    console.print(f"Verdict: {result.verdict}", style="bold")
    for sentence in sentences(result):
        console.print(sentence)
