"""Composes the texts of the page's sections, in the page's order, for a template.

The sections are: set, measurement and model, misfit, finding, missing effects, ladder, device.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.base.percent import percent, probability_percent
from arctrue.base.runs import run_spans
from arctrue.report.analysis import Analysis
from arctrue.report.charts.chart import URAD_PER_ARCSEC
from arctrue.report.display import DisplaySettings, ranked_conditions
from arctrue.report.ranking import Ranking
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import absent_effects
from arctrue.workbench.model.noise_floor import with_one_floor
from arctrue.workbench.model.stations import warnings_of_a_kept_arc
from arctrue.workbench.observations import CaptureRows, ReferenceRows

Float = NDArray[np.float64]

MOST_RUNS = 24
MOST_MASKED = 5
CARDS, LEAST_CARDS = 6, 2
"""Largest and smallest number of candidates that are shown as cards; a table lists the other
candidates."""
LEAST_SHARE = 0.005
"""Smallest probability at which a candidate outside the class is shown as a card; at least
LEAST_CARDS candidates are shown.
"""
_SHOWN_SHARE = 0.005
"""Smallest share that is printed next to the name of a condition; smaller shares round to 0 %."""
NAMED_P = 0.01
"""Limit of the p-value below which an effect is named; the same value as
:data:`arctrue.workbench.inference.significance.SIGNIFICANCE`."""


def words(name: str) -> str:
    """Return the name of an effect with spaces in place of underscores."""
    return name.replace("_", " ")


def angle_text(display: DisplaySettings, value: float | None, digits: int = 3) -> str:
    """Return a small angle as text in the reader's unit; return an en dash for None, NaN and
    infinity."""
    if value is None or not math.isfinite(value):
        return "–"
    if display.unit == "urad":
        return f"{value * URAD_PER_ARCSEC:.{max(digits - 1, 1)}f} µrad".replace("-", "−")
    return f"{value:.{digits}f}″".replace("-", "−")


def set_section(analysis: Analysis, ranking: Ranking | None) -> dict[str, Any]:
    """Return runs, speeds, temperatures, faults, masked rows, and the orders that the set cannot
    show."""
    table = analysis.measurement.table
    facts = [
        ("counts a turn", None if table.counts_per_rev is None else f"{table.counts_per_rev:,}"),
        ("grating lines", None if table.grating_lines is None else f"{table.grating_lines:,}"),
        (
            "angle between the heads",
            None if table.head_separation_deg is None else f"{table.head_separation_deg:g}°",
        ),
        ("teeth of the drive", table.drive_gear_teeth),
        ("faces of the polygon", analysis.observations.faces),
    ]
    diagnosis = None if ranking is None else ranking["diagnosis"]
    masked = analysis.observations.masked
    return {
        "facts": [(name, value) for name, value in facts if value is not None],
        "channels": [_channel(analysis, name) for name in analysis.observations.channels],
        "masked": len(masked),
        "masked_rows": [str(row) for row in masked[:MOST_MASKED]],
        "warnings": [
            *analysis.measurement.warnings,
            *analysis.observations.left_out,
            *warnings_of_a_kept_arc(analysis.model, analysis.observations),
        ],
        "faults": None if diagnosis is None else diagnosis["data_faults"],
        "blind_orders": (
            None
            if diagnosis is None or analysis.observations.capture is None
            else diagnosis["covers"]["blind_orders"]
        ),
    }


def _run_of(rows: CaptureRows | ReferenceRows, run: int) -> int | str:
    """Return the name of a run; it includes the head if the rows of each head form a run of their
    own."""
    if isinstance(rows, ReferenceRows) or rows.channel is None:
        return run
    return rows.run_words(run).removeprefix("run ")


def _channel(analysis: Analysis, channel: str) -> dict[str, Any]:
    rows = analysis.rows(channel)
    spans = run_spans(rows.run)
    runs = []
    for start, end in spans[:MOST_RUNS]:
        part = slice(start, end)
        speed = rows.speed_rad_s
        angle = rows.angle_rad if isinstance(rows, CaptureRows) else rows.target_rad
        runs.append(
            {
                "run": _run_of(rows, int(rows.run[start])),
                "rows": f"{end - start:,}",
                "speed": None if speed is None else _signed(np.degrees(np.median(speed[part])), 1),
                "turns": f"{float(np.ptp(angle[part])) / (2.0 * np.pi):.1f}",
                "temperature": _range(rows.temperature_c, part),
                "seconds": None if rows.time_s is None else f"{np.ptp(rows.time_s[part]):.1f}",
            }
        )
    whole = analysis.observations.capture_rows if channel == "capture" else rows.run.size
    return {"name": channel, "rows": f"{whole:,}", "runs": runs, "more": len(spans) - len(runs)}


def _range(values: Float | None, part: slice) -> str | None:
    if values is None:
        return None
    low, high = float(values[part].min()), float(values[part].max())
    return f"{low:.2f}" if high - low < 0.01 else f"{low:.2f} … {high:.2f}"


def _signed(value: float, digits: int) -> str:
    return f"{value:+.{digits}f}".replace("-", "−")


def model_section(analysis: Analysis, display: DisplaySettings) -> list[dict[str, Any]]:
    """Return the effects of the model with their parameters; the page offers to drop an effect
    unless it is the only one."""
    found = []
    for entry in analysis.model.effects:
        parameters = [
            {
                "name": words(name),
                "value": f"{item.value:.4g}".replace("-", "−"),
                "sigma": f"{item.sigma:.2g}" if math.isfinite(item.sigma) else "–",
                "unit": _unit(item.unit),
            }
            for name, item in entry.parameters.items()
        ]
        found.append(
            {
                "name": entry.name,
                "words": words(entry.name),
                "settings": entry.settings,
                "parameters": parameters,
                "can_be_dropped": len(analysis.model.effects) > 1,
            }
        )
    return found


def _unit(unit: str) -> str:
    return {"1": "", "arcsec": "″", "deg": "°"}.get(unit, unit.replace("arcsec", "″"))


def channels_section(analysis: Analysis, display: DisplaySettings) -> list[dict[str, str]]:
    """Return the residual of each channel for the template."""
    last = with_one_floor(analysis.model.history)[-1]
    return [
        {
            "name": channel,
            "rms": angle_text(display, last.rms_arcsec[channel]),
            "peak": angle_text(display, last.peak_arcsec[channel]),
            "held_out": angle_text(display, last.heldout_rms_arcsec.get(channel)),
            "noise": angle_text(display, last.noise_arcsec.get(channel)),
        }
        for channel in analysis.observations.channels
        if channel in last.rms_arcsec
    ]


def where_section(
    analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> dict[str, Any]:
    """Return the ranked conditions, the condition that the figure shows, and the findings in
    words."""
    conditions = ranked_conditions(analysis, ranking)
    keys = [condition.key for condition, _ in conditions]
    return {
        "conditions": [
            {"key": item.key, "name": item.name, "share": percent(share)}
            for item, share in conditions
        ],
        "against": display.against if display.against in keys else keys[0],
        "beyond_chance": bool(ranking and ranking["regressors"]),
        "judged": ranking is not None and ranking.get("whole", True),
        "some_share": any(share >= _SHOWN_SHARE for _, share in conditions),
        "findings": [] if ranking is None else ranking["findings"],
        "lacking": _lacking(ranking),
    }


def _lacking(ranking: Ranking | None) -> list[str]:
    """Return the names of the channels that the model does not fit, whether or not the residual
    follows a condition."""
    tests = {} if ranking is None else ranking["diagnosis"]["lack_of_fit"]
    return [
        channel
        for channel, item in tests.items()
        if item["p_value"] is not None and item["p_value"] < NAMED_P
    ]


def finding_section(
    analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> dict[str, Any] | None:
    """Return the effect that the figure shows, and the conditions over which it can be drawn."""
    if ranking is None or ranking["finding"] is None or not ranking["finding"]["best"]:
        return None
    found = ranking["finding"]
    keys = list(dict.fromkeys(item["condition"] for item in found["shown"]))
    names = {item["condition"]: item["name"] for item in found["shown"]}
    return {
        "effect": words(found["effect"]),
        "added": found["added"],
        "over": display.finding if display.finding in keys else found["best"],
        "conditions": [{"key": key, "name": names[key]} for key in keys],
    }


def missing_section(
    analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> dict[str, Any] | None:
    """Return verdict, cards, untested effects and reasons; None until the diagnosis is complete."""
    if ranking is None:
        return None
    diagnosis = ranking["diagnosis"]
    probability: Mapping[str, float] = diagnosis["probability"]
    candidates = sorted(
        diagnosis["candidates"],
        key=lambda item: (-probability.get(item["effect"], 0.0), -item["delta_bic"]),
    )
    cards = [_card(item, diagnosis, analysis.effects, display) for item in candidates]
    worth = sum(card["in_class"] or card["share"] >= LEAST_SHARE for card in cards)
    shown = min(max(worth, LEAST_CARDS), CARDS)
    not_tested: dict[str, list[str]] = {}
    for name, lacking in diagnosis["cannot_be_tested"].items():
        not_tested.setdefault("; ".join(lacking), []).append(words(name))
    return {
        "verdict": diagnosis["verdict"],
        "sentences": ranking["sentences"],
        "cards": cards[:shown],
        "others": cards[shown:],
        "none": probability_percent(probability.get("none", 0.0)),
        "unknown": probability_percent(probability.get("unknown", 0.0)),
        "not_tested": [
            {"names": ", ".join(names), "lacks": lacks} for lacks, names in not_tested.items()
        ],
        "next_measurement": diagnosis["next_measurement"],
    }


def _card(
    item: Mapping[str, Any],
    diagnosis: Mapping[str, Any],
    effects: Mapping[str, type[Effect]],
    display: DisplaySettings,
) -> dict[str, Any]:
    name = item["effect"]
    effect = effects.get(name)
    similar = [other for other in diagnosis["class"] if other != name]
    in_class = name in diagnosis["class"]
    look_alikes = [words(other) for other in similar] if in_class else []
    for other, lacking in diagnosis["look_alikes"].items():
        if in_class and other != name:
            look_alikes.append(f"{words(other)} (cannot be tested: {'; '.join(lacking)})")
    after = item["heldout_after_arcsec"]
    before = item["heldout_before_arcsec"]
    return {
        "name": name,
        "words": words(name),
        "physics": "" if effect is None else effect.physics,
        "probability": probability_percent(diagnosis["probability"].get(name, 0.0)),
        "share": diagnosis["probability"].get(name, 0.0),
        "named": name == diagnosis["named"],
        "in_class": in_class,
        "evidence": evidence_in_words(item["p_corrected"], item["delta_bic"]),
        "held_out": [
            {
                "channel": channel,
                "before": angle_text(display, before[channel], 4),
                "after": angle_text(display, after[channel], 4),
                "rises": after[channel] > before[channel],
            }
            for channel in before
            if channel in after
        ],
        "left": [
            {
                "channel": channel,
                "before": angle_text(display, item["rms_before_arcsec"][channel], 4),
                "after": angle_text(display, value, 4),
            }
            for channel, value in item["rms_after_arcsec"].items()
        ],
        "sizes": [
            {"channel": channel, "size": angle_text(display, size)}
            for channel, size in item["size_arcsec"].items()
        ],
        "look_alikes": look_alikes,
        "lacking_variety": item["lacking_variety"],
        "next_measurement": (
            diagnosis["next_measurement"]
            if in_class and diagnosis["next_measurement"]
            else "" if effect is None else effect.next_measurement
        ),
    }  # fmt: skip


def evidence_in_words(p_value: float, delta_bic: float) -> str:
    """Return a sentence that states how often chance alone gives such a gain; the p-value includes
    the look-elsewhere effect."""
    if p_value < 1e-9:
        said = (
            "Chance alone would give such a gain in less than one of a thousand million such sets"
        )
    elif p_value < 1e-6:
        said = "Chance alone would give such a gain in less than one of a million such sets"
    elif p_value < NAMED_P:
        said = f"Chance alone would give such a gain in one of {_round(1.0 / p_value):,} such sets"
    elif p_value < 0.5:
        said = (
            f"Chance alone gives such a gain in one of {max(round(1.0 / p_value), 2)} such sets: "
            "too often to name the effect"
        )
    else:
        said = "Chance alone gives such a gain in most such sets"
    bic = f"{delta_bic:,.0f}".replace("-", "−")
    p_text = f"{p_value:.2g}" if p_value >= 1e-99 else "below 1e−99"
    return f"{said} (p {p_text.replace('e-', 'e−')}, ΔBIC {bic})."


def _round(value: float) -> int:
    digits = max(int(math.log10(max(value, 1.0))) - 1, 0)
    return int(round(value / 10**digits) * 10**digits)


def ladder_section(analysis: Analysis, display: DisplaySettings) -> list[dict[str, Any]]:
    """Return a row per step and channel, like those of ``arctrue history``, with the date of the
    step."""
    rows = []
    for number, step in enumerate(with_one_floor(analysis.model.history), start=1):
        for place, channel in enumerate(step.rms_arcsec):
            rows.append(
                {
                    "step": f"{number} {step.action}" if place == 0 else "",
                    "effect": words(step.effect) if place == 0 else "",
                    "date": step.date[:16].replace("T", " ") if place == 0 else "",
                    "channel": channel,
                    "rms": angle_text(display, step.rms_arcsec[channel], 4),
                    "held_out": angle_text(display, step.heldout_rms_arcsec.get(channel), 4),
                    "peak": angle_text(display, step.peak_arcsec[channel]),
                    "noise": angle_text(display, step.noise_arcsec.get(channel), 4),
                }
            )
    return rows


def device_section(ranking: Ranking | None, display: DisplaySettings) -> dict[str, Any] | None:
    """Return lanes, remaining error and objections, or the reason why there is no coefficient file;
    None until they are computed."""
    device = None if ranking is None else ranking["device"]
    if device is None or "refused" in device:
        return device
    return {
        **device,
        "rows": [
            {"order": order, "amplitude": angle_text(display, amplitude, 4)}
            for order, amplitude in zip(device["orders"], device["amplitudes_arcsec"], strict=True)
        ],
    }


def report_sections(
    analysis: Analysis, ranking: Ranking | None, display: DisplaySettings
) -> dict[str, Any]:
    """Return all sections of the page by their names."""
    return {
        "title": analysis.title,
        "set": set_section(analysis, ranking),
        "model": model_section(analysis, display),
        "channels": channels_section(analysis, display),
        "where": where_section(analysis, ranking, display),
        "finding": finding_section(analysis, ranking, display),
        "missing": missing_section(analysis, ranking, display),
        "ladder": ladder_section(analysis, display),
        "device": device_section(ranking, display),
    }


def addable(analysis: Analysis) -> Sequence[str]:
    """Return the effects that ``add`` accepts: effects that the model lacks, and effects with a
    search for an order or frequency, which a model may contain more than once."""
    absent = absent_effects(analysis.effects, analysis.model.names(), analysis.observations)
    return [name for name, effect in analysis.effects.items() if name in absent or effect.search]
