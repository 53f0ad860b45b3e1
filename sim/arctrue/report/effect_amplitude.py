"""Computes the measured and the predicted amplitude of an effect in each bin of a condition.

Let c be the sum of the effect's columns times their coefficients, and r the residual of the whole
model. The data of the effect are c + r (component plus residual). For a condition x and a phase φ,
the product a(x)·w(φ) that is nearest to c defines the wave w(φ). At x, the projection of c + r on w
is the measured amplitude, and that of c the predicted amplitude. An effect that is a function of a
phase alone is drawn over that phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from arctrue.report.analysis import OWN_PHASE, Analysis, Condition
from arctrue.report.charts.angle_window import AngleWindow
from arctrue.report.charts.bins import turn_group
from arctrue.workbench.inference.design_matrix import channel_columns
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.solution import Solution

Float = NDArray[np.float64]
Integer = NDArray[np.int64]

_STEPS = 16
_ROUNDS = 20
"""Number of alternating least-squares steps; their rate of convergence depends on the ratio of the
two largest singular values."""
_PHASE_BINS = 72
PHYSICAL = ("temperature", "speed", "direction", "time")
"""Conditions that can be causes of an effect; they rank before conditions that only correlate with
it."""
_NEARLY = 0.8
_OF_A_PHASE = 0.5
"""Smallest share of an effect that a phase must explain for the effect to be drawn over this
phase."""


@dataclass(frozen=True)
class AmplitudeCurve:
    """An effect over one condition in one channel, in arrays (steps,), arcseconds."""

    channel: str
    condition: str
    """Key of the condition over which the effect is drawn."""
    name: str
    unit: str
    amplitude: bool
    """True: the values are amplitudes of the effect's wave; False: they are the effect itself."""
    share: float
    """Share of the effect's sum of squares that the drawn line explains."""
    variation: float
    """Part of ``share`` that a constant amplitude would not explain."""
    x: Float
    measured: Float
    standard_error: Float
    effect: Float

    def data(self) -> dict[str, Any]:
        """Return the curve as values for JSON."""
        return {
            key: value.tolist() if isinstance(value, np.ndarray) else value
            for key, value in vars(self).items()
        }

    @classmethod
    def of_data(cls, data: Mapping[str, Any]) -> AmplitudeCurve:
        """Read the curve from JSON values."""
        arrays = ("x", "measured", "standard_error", "effect")
        values: dict[str, Any] = {
            key: np.array(value) if key in arrays else value for key, value in data.items()
        }
        return cls(**values)


@dataclass(frozen=True)
class EffectAmplitude:
    """An effect over every condition of the set, with the condition that shows the effect best."""

    effect: str
    shown: list[AmplitudeCurve]
    best: str
    """Key of the condition that shows the effect best; empty if no curve can be drawn."""

    def over(self, condition: str) -> list[AmplitudeCurve]:
        """Return the curves of both channels over the condition with this key."""
        return [item for item in self.shown if item.condition == condition]


def effect_amplitude(analysis: Analysis, solution: Solution) -> EffectAmplitude:
    """Compute the amplitude of the last effect of the fit ``solution`` over every condition of the
    set of ``analysis``."""
    term = solution.terms[-1]
    coefficients = solution.coefficients[solution.part(len(solution.terms) - 1)]
    residuals = Residuals(solution)
    shown: list[AmplitudeCurve] = []
    for channel in analysis.observations.channels:
        left = residuals.capture_arcsec if channel == "capture" else residuals.reference_arcsec
        assert left is not None
        columns = channel_columns(
            (term,), solution.observations, solution.context, capture=channel == "capture"
        )
        own = columns @ coefficients
        if not float(own @ own) > 0.0:
            continue
        conditions = [*analysis.conditions.values(), *_own_phases(analysis, term.nonlinear)]
        phases = [
            values
            for condition in conditions
            if condition.goes_round and (values := condition.values.get(channel)) is not None
        ]
        for condition in conditions:
            values = condition.values.get(channel)
            if values is not None:
                item = _shown(channel, condition, values, phases, own, left)
                shown += [item] if item.x.size else []
    return EffectAmplitude(term.effect.name, shown, _best(shown))


def _own_phases(analysis: Analysis, nonlinear: Mapping[str, float]) -> list[Condition]:
    """Return the phase within a period of the order or frequency that the effect's search found."""
    order, hertz = nonlinear.get("order", 0.0), nonlinear.get("frequency", 0.0)
    found = []
    if order > 0.0:
        values = {name: order * analysis.angle_rad(name) for name in analysis.observations.channels}
        found.append(Condition(OWN_PHASE, f"phase of order {order:.6g}", "deg", values))
    elif hertz > 0.0:
        times = {name: analysis.rows(name).time_s for name in analysis.observations.channels}
        values = {
            name: 2.0 * np.pi * hertz * time_s
            for name, time_s in times.items()
            if time_s is not None
        }
        found.append(Condition(OWN_PHASE, f"phase of {hertz:.6g} Hz", "deg", values))
    return found


def _best(shown: list[AmplitudeCurve]) -> str:
    """Return the key of the condition that shows the effect best.

    This condition is a phase if a phase explains most of the effect; otherwise it is the condition
    over which the amplitude varies most. Conditions that change together show similar variation;
    then the first of :data:`PHYSICAL` is chosen.
    """
    phases = [item for item in shown if not item.amplitude and item.share >= _OF_A_PHASE]
    if phases:
        # The effect's own phase comes first, because bins of the turn can alias an effect with many
        # periods per turn.
        return max(phases, key=lambda item: (item.condition == OWN_PHASE, item.share)).condition
    held = {item.condition: item.variation for item in shown if item.amplitude}
    most = max(held.values(), default=0.0)
    for name in PHYSICAL:
        if held.get(name, 0.0) >= _NEARLY * most and name in held:
            return name
    return max(held, key=lambda name: held[name], default="")


def _shown(
    channel: str,
    condition: Condition,
    values: Float,
    phases: list[Float],
    own: Float,
    left: Float,
) -> AmplitudeCurve:
    if condition.goes_round:
        window = AngleWindow.over(values)
        seen = window.bins(values, own + left, _PHASE_BINS)
        predicted = window.bins(values, own, _PHASE_BINS)
        share = float(np.sum(predicted.rows * predicted.mean**2)) / float(own @ own)
        lines = (predicted.centre, seen.mean, seen.standard_error, predicted.mean)
        return AmplitudeCurve(
            channel, condition.key, condition.name, "deg", False, share, share, *lines
        )
    group = _steps(values)
    best = max(
        (_along(own, left, values, group, phase) for phase in [None, *phases]),
        key=lambda item: item[0],
    )
    share, variation, *found = best
    return AmplitudeCurve(
        channel,
        condition.key,
        condition.name,
        condition.unit,
        True,
        share,
        variation,
        *found,
    )


def _steps(values: Float) -> Integer:
    """Return the number of the step of each row: one step per value if there are few values,
    otherwise steps of equal width."""
    names, group = np.unique(values, return_inverse=True)
    if names.size <= _STEPS:
        return group.astype(np.int64)
    low, high = float(values.min()), float(values.max())
    width = (high - low) / _STEPS
    return np.minimum(((values - low) / width).astype(np.int64), _STEPS - 1)


def _wave(sums: Float, rows: Float) -> Float:
    """Return the factor w, with RMS 1, of the product a(x)·w(φ) that is nearest to the cell means,
    weighted by their rows.

    ``sums``, ``rows``: sum of the values and number of rows in each cell, shape (steps, bins).
    Alternating least squares starts from the leading singular vector, which is not the solution
    because a step may cover a part of the turn only.
    """
    _, _, right = np.linalg.svd(sums / np.sqrt(np.maximum(rows, 1)), full_matrices=False)
    wave = right[0]
    for _ in range(_ROUNDS):
        amplitude = sums @ wave / np.maximum(rows @ wave**2, 1e-300)
        wave = amplitude @ sums / np.maximum(amplitude**2 @ rows, 1e-300)
    wave = wave * np.sqrt(wave.size / max(float(wave @ wave), 1e-300))
    return np.asarray(wave if float(np.sum(sums @ wave)) >= 0.0 else -wave)


def _along(
    own: Float, left: Float, values: Float, group: Integer, phase: Float | None
) -> tuple[float, float, Float, Float, Float, Float]:
    """Return share and variation of the curve; then, for each step with rows, place, measured
    amplitude, standard error and effect."""
    bins = 1 if phase is None else _PHASE_BINS
    place = np.zeros(own.size, dtype=np.int64) if phase is None else turn_group(phase, bins)
    steps = int(group.max()) + 1
    cell, size = group * bins + place, steps * bins
    rows = np.bincount(cell, minlength=size).reshape(-1, bins).astype(np.float64)
    sums: Float = np.asarray(np.bincount(cell, own, size).reshape(-1, bins), dtype=np.float64)
    pattern = _wave(sums, rows)[place]
    square = np.bincount(group, pattern**2, steps)
    there = square > 0.0
    if not there.any():  # no product of an amplitude and a wave fits the effect
        nothing = np.zeros(0)
        return 0.0, 0.0, nothing, nothing, nothing, nothing
    safe = np.maximum(square, 1e-300)
    predicted = np.bincount(group, pattern * own, steps) / safe
    seen = np.bincount(group, pattern * (own + left), steps) / safe
    # Each row has the same weight in the mean place of its step as in the amplitude of its step.
    at = np.bincount(group, pattern**2 * values, steps) / safe
    error = float(left.std()) / np.sqrt(safe)
    whole = float(own @ own)
    share = float(np.sum(predicted**2 * square)) / whole
    constant = float(np.sum(predicted * square)) / float(square.sum())
    variation = share - constant**2 * float(square.sum()) / whole
    return share, variation, at[there], seen[there], error[there], predicted[there]
