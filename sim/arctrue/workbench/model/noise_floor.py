"""Selects one noise estimate per set, which all steps of a history with this set then share."""

from __future__ import annotations

from collections.abc import Sequence

from msgspec import structs

from arctrue.workbench.model.model import Channels, HistoryStep


def with_one_floor(history: Sequence[HistoryStep]) -> list[HistoryStep]:
    """Return the steps; all steps with the same set get the same noise.

    Each step has its own estimate of the set's noise. The smallest of them is used, because it
    contains the smallest part of the model's error.
    """
    return [
        structs.replace(step, noise_arcsec=_least([o for o in history if _same_set(o, step)]))
        for step in history
    ]


def floor_of(history: Sequence[HistoryStep]) -> Channels:
    """Return the noise of the set of the history's last step, by channel."""
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
