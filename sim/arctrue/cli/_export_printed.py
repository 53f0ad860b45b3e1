"""Prints the effects that an export to the gateware corrects, and the error that remains."""

from __future__ import annotations

from arctrue.base.figures import figure
from arctrue.base.units import arcsec_per_count
from arctrue.cli._loaded_set import console
from arctrue.cli._tables import number, table, words
from arctrue.workbench.model.export import Export
from arctrue.workbench.model.taken_away import Outcome


def print_export(result: Export, became: Outcome, lanes: int) -> None:
    """Print how many of the gateware's ``lanes`` are in use, which part corrects each effect of the
    model, and which errors are not corrected."""
    in_use = table(
        f"Lanes, {len(result.orders)} of {lanes} in use",
        number("order"),
        number("amplitude ″"),
        number("slope ″/K"),
    )
    thermal = result.coefficients.thermal
    count = arcsec_per_count(result.coefficients.counts_per_rev)
    for order, amplitude in zip(result.orders, result.amplitudes_arcsec, strict=True):
        slope = ""
        if thermal is not None and order in thermal.orders:
            one = thermal.change_counts(order, thermal.reference_c + 1.0)
            slope = figure(abs(one) * count, 4)
        in_use.add_row(str(order), figure(amplitude, 4), slope)
    console.print(in_use)
    if thermal is not None:
        console.print(
            f"amplitudes at {thermal.reference_c:g} °C; orders with a slope follow the device's "
            f"thermometer from {thermal.least_c:g} to {thermal.most_c:g} °C, whose lag is taken as "
            f"{thermal.time_constant_s:g} s",
            soft_wrap=True,
        )
    for text in result.followed:
        console.print(f"follows its condition: {text}")
    for text in result.local:
        console.print(f"in the local table: {text}")
    for text in result.real:
        console.print(
            f"lane of an order that is not an integer, phase in turn 0 of the set: {text}"
        )
    _print_outcome(became)
    for text in result.left_out:
        console.print(f"not corrected: {text}")
    for item in became.of_the_reference:
        console.print(
            f"not evaluated: {item.effect}, {figure(item.part_arcsec, 3)}″ RMS of the reference "
            f"run: {item.note}",
            soft_wrap=True,
        )


def _print_outcome(became: Outcome) -> None:
    """Print which part corrects each effect of the model, and the remaining error."""
    effects_table = table(
        "What corrects each effect of the model, RMS at head 1",
        words("effect"),
        number("size ″"),
        words("corrected by"),
        number("left ″"),
    )
    for item in became.effects:
        of_table = item.by != "reference"
        effects_table.add_row(
            item.effect,
            figure(item.part_arcsec, 3) if item.by != "not in the output" else "",
            item.by if of_table else "(error of the reference)",
            figure(item.left_arcsec, 3) if of_table and item.part_arcsec else "",
        )
    console.print(effects_table)
    means = [item.effect for item in became.effects if item.by == "the mean"]
    if means:
        console.print(
            f"{', '.join(means)}: the coefficients of arctrue calibrate --angle mean remove this "
            "error; the exported coefficients correct head 1 alone",
            soft_wrap=True,
        )
    console.print(
        f"all effects that are not corrected: {figure(became.left_arcsec, 3)}″ RMS of the error "
        "of head 1",
        soft_wrap=True,
    )
