"""The noise of a history's set: one figure at all of its steps."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import structs

from arctrue.workbench.model.model import Channels, HistoryStep


def with_one_floor(history: Sequence[HistoryStep]) -> list[HistoryStep]:
    """Return the steps with the noise of the set of their fit, the same at all its steps.

    Every step has an estimate; the smallest estimate contains the smallest part of the remaining
    error.
    """
    return [
        structs.replace(step, noise_arcsec=_least([o for o in history if _same_set(o, step)]))
        for step in history
    ]


def floor_of(history: Sequence[HistoryStep]) -> Channels:
    """Return the noise of the set of the last step, by channel."""
    return with_one_floor(history)[-1].noise_arcsec


def _same_set(one: HistoryStep, other: HistoryStep) -> bool:
    digests = {one.measurement_sha256, other.measurement_sha256} - {""}
    return one.measurement == other.measurement and len(digests) < 2


def _least(steps: Sequence[HistoryStep]) -> Channels:
    found: Channels = {}
    for step in steps:
        for channel, value in step.noise_arcsec.items():
            found[channel] = min(value, found.get(channel, value))
    return found
