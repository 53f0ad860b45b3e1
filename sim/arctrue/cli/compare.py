"""arctrue compare: shows where a model does not fit a set."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any

import click

from arctrue.base.figures import figure, probability
from arctrue.cli._loaded_set import (
    common_options,
    console,
    for_people,
    load,
    set_argument,
    write_json,
)
from arctrue.cli._orbit import orbit_data, orbit_of, print_orbit
from arctrue.cli._progress import Progress
from arctrue.cli._tables import number, table, words
from arctrue.workbench.compare.comparison import ModelComparison
from arctrue.workbench.compare.comparison import compare as compare_model
from arctrue.workbench.compare.findings import SIGNIFICANCE
from arctrue.workbench.compare.maps import ResidualMap
from arctrue.workbench.effects.registry import absent_effects
from arctrue.workbench.inference.identifiability import Identifiability, identifiability
from arctrue.workbench.model.growth import as_stored, fitted

SHOWN_PAIRS = 3
CHANNELS = ("capture", "reference")
TESTS = {
    "autocorrelation_p": "auto-\ncorrelation p",
    "successive_differences_p": "von\nNeumann p",
    "normality_p": "normality\np",
}
WHITE_P = SIGNIFICANCE / (len(TESTS) * len(CHANNELS))
"""Significance level of a single test; by chance, at most one set in a hundred fails a test."""


@click.command("compare", short_help="Show where a model does not fit a set.")
@set_argument
@common_options
@click.option(
    "--no-fit",
    is_flag=True,
    help="Use the stored coefficients of the model; fit only run offsets and a₀.",
)
@for_people
def compare(
    measurement_set: Path,
    model_file: Path | None,
    folders: tuple[Path, ...],
    json_file: Path | None,
    out: Path | None,
    seed: int,
    no_fit: bool,
) -> None:
    """Show how far a model differs from a set, and on which conditions the residual depends.

    For a capture of three or four heads the command also shows the orbit of the axis.
    """
    loaded = load(measurement_set, model_file, folders)
    with Progress("comparing"):
        if no_fit:
            solution = as_stored(loaded.model, loaded.observations, loaded.effects)
        else:
            _, solution = fitted(loaded.model, loaded.observations, loaded.effects)
        result = compare_model(solution, seed)
        absent = absent_effects(loaded.effects, loaded.model.names(), loaded.observations)
        found = identifiability(solution, absent)
    _print(result, loaded.model.names(), fitted_here=not no_fit)
    _print_noise(result.noise)
    _print_identifiability(found)
    orbit = orbit_of(loaded.measurement_set)
    if orbit is not None:
        print_orbit(console, orbit)
    write_json(
        json_file,
        {
            "schema": 1,
            "model": loaded.model.names(),
            "fitted": not no_fit,
            "channels": {
                name: {**asdict(item), "excess_arcsec": item.excess_arcsec}
                for name, item in result.channels.items()
            },
            "findings": [asdict(item) for item in result.findings],
            "noise": result.noise,
            "masked": [row.data() for row in loaded.observations.masked],
            "maps": [_map_data(item) for item in result.maps],
            "identifiability": _identifiability_data(found),
            **({} if orbit is None else {"axis_orbit": orbit_data(orbit)}),
        },
    )
    if out is not None:
        from arctrue.report.charts.comparison_charts import comparison_charts
        from arctrue.report.charts.matplotlib_chart import save_charts

        charts = dict(comparison_charts(solution, result))
        if orbit is not None:
            from arctrue.report.charts.axis_orbit import axis_orbit_chart

            charts["axis_orbit"] = axis_orbit_chart(orbit)
        for path in save_charts(charts, out):
            console.print(f"wrote {path}")


def _identifiability_data(found: Identifiability) -> dict[str, Any]:
    data = asdict(found)
    data["coefficients"] = len(found.coefficients)
    return data


def _map_data(item: ResidualMap) -> dict[str, Any]:
    """Return a map as JSON values, without drawing settings and without each row's bin number."""
    return {
        key: value
        for key, value in vars(item).items()
        if key not in ("group", "bins", "goes_round")
    }


def _print(result: ModelComparison, names: list[str], *, fitted_here: bool) -> None:
    how = "fitted to this set" if fitted_here else "as stored"
    console.print(f"Model: {', '.join(names)}, {how}")
    left = table(
        "Residual of the model",
        words("channel"),
        *map(number, ("rows", "RMS ″", "peak ″", "noise of\nrepeats ″", "lack of\nfit p")),
    )
    for name, item in result.channels.items():
        left.add_row(
            name,
            f"{item.rows:,}",
            figure(item.rms_arcsec, 4),
            figure(item.peak_arcsec, 3),
            figure(item.noise_arcsec, 4),
            probability(item.lack_of_fit_p),
        )
    console.print(left)
    lacking = [name for name, item in result.channels.items() if item.lack_of_fit_p < SIGNIFICANCE]
    if not result.findings and lacking:
        console.print(
            f"The model does not fit the {' and the '.join(lacking)}, yet the residual follows "
            "none of the conditions drawn here: run arctrue diagnose."
        )
    elif not result.findings:
        console.print("The residual follows none of the conditions beyond chance.")
    if result.findings:
        console.print("Excess: the residual's RMS beyond the noise of the repeats.")
    for finding in result.findings:
        console.print(f"{'  ·' if finding.shadow_of else '•'} {finding.text}")


def _print_noise(noise: dict[str, Any]) -> None:
    """Print the tests of the whitened residual; σ and p are valid only if the residual is white and
    normal."""
    tested = {name: item["tests"] for name, item in noise.items() if name in CHANNELS}
    tested = {name: tests for name, tests in tested.items() if tests is not None}
    if not tested:
        return
    shown = table(
        "Tests of the whitened residual: white and normal?",
        words("channel"),
        *map(number, ("white ″", "coloured ″", *TESTS.values())),
    )
    for name, tests in tested.items():
        parts = (figure(noise[name][key], 4) for key in ("white_arcsec", "coloured_arcsec"))
        shown.add_row(name, *parts, *(probability(tests[key]) for key in TESTS))
    console.print(shown)
    failed = [name for name, tests in tested.items() if min(tests.values()) < WHITE_P]
    if failed:
        console.print(
            f"The whitened residual of the {' and of the '.join(failed)} fails a test: "
            "an effect is missing in the model, or σ and p are too small.",
            soft_wrap=True,
        )


def short_coefficient_names(names: Sequence[str]) -> list[str]:
    """Return the names of coefficients (``effect: cos 3``) in a short form: for each effect, orders
    whose cosine and sine are both listed become ranges."""
    parts: dict[str, set[str]] = {}
    for name in names:
        effect, _, part = name.partition(": ")
        parts.setdefault(effect, set()).add(part)
    found = []
    for effect, own in parts.items():
        orders = sorted(
            int(part[4:])
            for part in own
            if part.startswith("cos ") and part[4:].isdigit() and f"sin {part[4:]}" in own
        )
        left = own - {f"{wave} {order}" for wave in ("cos", "sin") for order in orders}
        shown = [part for name in names if (part := name.partition(": ")[2]) in left]
        if orders:
            shown.insert(0, f"{'order' if len(orders) == 1 else 'orders'} {_ranges(orders)}")
        found.append(f"{effect}: {', '.join(shown)}" if any(shown) else effect)
    return found


def _ranges(numbers: Sequence[int]) -> str:
    """Return increasing integers as text, with ranges for consecutive ones: ``1-3, 7``."""
    found: list[list[int]] = []
    for value in numbers:
        if found and value == found[-1][-1] + 1:
            found[-1].append(value)
        else:
            found.append([value])
    return ", ".join(f"{one[0]}" if len(one) == 1 else f"{one[0]}-{one[-1]}" for one in found)


def _print_identifiability(found: Identifiability) -> None:
    if found.undetermined:
        named = "; ".join(short_coefficient_names(found.undetermined))
        console.print(f"The set does not determine: {named}.", soft_wrap=True)
    for pair in found.correlated[:SHOWN_PAIRS]:
        console.print(
            f"Hardly separable: {pair.first} and {pair.second}, "
            f"correlation {figure(pair.correlation, 3, signed=True)}."
        )
