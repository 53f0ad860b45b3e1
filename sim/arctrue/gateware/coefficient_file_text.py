"""Writes coefficients as the text of a coefficient file."""

from __future__ import annotations

import json
import math
from fractions import Fraction

from arctrue.base.units import ARCSEC_PER_TURN
from arctrue.gateware.coefficient_file_keys import EXTENDED_SCHEMA, SCHEMA, THERMAL_SCHEMA
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.extension import WIDTH_ONE
from arctrue.gateware.lane_words import AMPLITUDE_LSB_COUNTS
from arctrue.gateware.mean_set import OFFSET_ONE, WEIGHT_ONE
from arctrue.gateware.thermal import SLOPE_LSB_COUNTS
from arctrue.generated.number_formats import PHASE_STEP_WIDTH


def coefficient_file_text(coefficients: Coefficients, title: str = "") -> str:
    """Return the text of a coefficient file."""
    schema = SCHEMA if coefficients.thermal is None else THERMAL_SCHEMA
    lines = [
        "# Coefficients of the gateware: offset + sum of amplitude * cos(order * angle + phase).",
        "# Loaded: phase_step (turn a count / 2^48), phase_offset (turn / 2^24), amplitude and",
        "# offset.word (count / 2^11). The other values state the same in other units.",
        f"schema = {schema if coefficients.extension is None else EXTENDED_SCHEMA}",
    ]
    if title:
        lines.append(f"title = {json.dumps(title, ensure_ascii=False)}")
    lines += [
        f"counts_per_rev = {coefficients.counts_per_rev}",
        f"lanes = {coefficients.lanes}",
        "",
        "[offset]",
        f"counts = {coefficients.offset_counts!r}",
        f"word = {coefficients.offset}",
    ]
    thermal = coefficients.thermal
    if thermal is not None:
        lines[1:3] += [
            "# Lanes with a slope follow the temperature T: their cosine and sine change by",
            "# slope[0:2] (T - T0) + slope[2:4] (T - T0)^2, in count / 2^20; T0 is reference_c.",
            "# Below least_c and above most_c they keep the values that they have at this limit.",
        ]
        lines += [
            "",
            "[temperature]",
            f"reference_c = {thermal.reference_c!r}",
            f"sensor_time_constant_s = {thermal.time_constant_s!r}",
            f"least_c = {thermal.least_c!r}",
            f"most_c = {thermal.most_c!r}",
        ]
    lines += _extension_lines(coefficients.extension)
    lines += _lane_lines(coefficients, "lane")
    for entry in coefficients.extension.without if coefficients.extension else ():
        lines += _without_lines(entry)
    return "\n".join(lines) + "\n"


def _lane_lines(coefficients: Coefficients, table: str) -> list[str]:
    """Return the lines of the TOML array of tables ``table``, one table for each lane whose words
    are not all 0."""
    arcsec = ARCSEC_PER_TURN / coefficients.counts_per_rev
    thermal = coefficients.thermal
    extension = coefficients.extension or Extension()
    modulators, turn_steps = dict(extension.modulators), dict(extension.turn_steps)
    sources = dict(extension.phase_sources)
    lines: list[str] = []
    for lane in range(coefficients.lanes):
        amplitude = int(coefficients.amplitudes[lane])
        step = int(coefficients.phase_steps[lane])
        offset = int(coefficients.phase_offsets[lane])
        turn_step = turn_steps.get(lane, 0)
        if amplitude == step == offset == turn_step == 0:
            continue
        order = int(coefficients.orders[lane])
        lines += [
            "",
            f"[[{table}]]",
            f"lane = {lane}",
            f"order = {_real_order(step, turn_step, coefficients.counts_per_rev)!r}"
            if turn_step
            else f"order = {order}",
            f"amplitude_arcsec = {float(f'{amplitude * AMPLITUDE_LSB_COUNTS * arcsec:.9g}')!r}",
            f"phase_deg = {math.degrees(coefficients.phases_rad[lane]):.6f}",
            f"phase_step = {step}",
            f"phase_offset = {offset}",
            f"amplitude = {amplitude}",
        ]
        if turn_step:
            lines.append(f"turn_step = {turn_step}")
        if lane in sources:
            source = sources[lane]
            lines.append(f"phase_from = {json.dumps(source.source)}")
            if source.source == "probe":
                lines.append(f"probe_side = {source.side}")
                lines.append(f"probe_phase = {source.probe_phase}")
        if lane in modulators:
            lines.append(f"modulator = {json.dumps(modulators[lane])}")
        if thermal is not None and order in thermal.orders:
            words = thermal.slopes[thermal.orders.index(order)].tolist()
            said = [float(f"{word * SLOPE_LSB_COUNTS * arcsec:.9g}") for word in words]
            lines += [
                f"slope_arcsec_per_k = {said[:2]}",
                f"slope_arcsec_per_k2 = {said[2:]}",
                f"slope = {words}",
            ]
    return lines


def _real_order(step: int, turn_step: int, counts_per_rev: int) -> float:
    """Return the order that has the fraction of the turn step and is nearest to the order of the
    phase step."""
    turn = 1 << PHASE_STEP_WIDTH
    fraction = Fraction(turn_step, turn)
    return float(round(Fraction(step * counts_per_rev, turn) - fraction) + fraction)


def _extension_lines(extension: Extension | None) -> list[str]:
    """Return the lines of those tables of schema 3 that precede the lanes."""
    lines: list[str] = []
    if extension is None:
        return lines
    if extension.mean:
        mean = extension.mean
        lines += ["", "[mean]", f"carrier = {mean.carrier}"]
        for weight, offset, delay in zip(
            mean.weights, mean.offsets, mean.delays_clocks, strict=True
        ):
            lines += [
                "",
                "[[mean.head]]",
                f"weight = {weight / WEIGHT_ONE!r}",
                f"weight_word = {weight}",
                f"offset_counts = {offset / OFFSET_ONE!r}",
                f"offset_word = {offset}",
                f"delay_clocks = {delay}",
            ]
    if extension.conditions:
        conditions = extension.conditions
        lines += [
            "",
            "[conditions]",
            f"width_counts = {conditions.width / WIDTH_ONE!r}",
            f"dead_zone_counts = {conditions.dead_zone_counts}",
            f"nominal_deg_per_s = {conditions.nominal_deg_per_s!r}",
        ]
    if extension.local_table:
        table = extension.local_table
        lines += [
            "",
            "[local_table]",
            f"width_turn = {2.0**-table.width_exponent!r}",
            f"fraction_bits = {table.fraction_bits}",
            f"starts_counts = {list(table.starts_counts)}",
            f"points = {list(table.points)}",
        ]
    return lines


def _without_lines(entry: Coefficients) -> list[str]:
    """Return the lines of the prepared set for a missing head."""
    mean = entry.extension.mean if entry.extension else None
    assert mean is not None, "checked by Coefficients"
    return [
        "",
        "[[without]]",
        f"head = {mean.missing}",
        f"carrier = {mean.carrier}",
        f"weight_words = {list(mean.weights)}",
        f"offset_words = {list(mean.offsets)}",
        f"offset_word = {entry.offset}",
        *_lane_lines(entry, "without.lane"),
    ]
