"""Detections of the forward search in a reference: regular causes, steps, oscillations and slow
changes, in words and as JSON."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from arctrue.workbench.diagnose.jumps import Jump, angle_words, list_of_jumps
from arctrue.workbench.effects.base import Effect, Nonlinear
from arctrue.workbench.inference.forward.cycles import CycleChange
from arctrue.workbench.inference.forward.even_drift import EvenDrift
from arctrue.workbench.inference.forward.oscillation import Oscillation
from arctrue.workbench.inference.forward.reversal import Reversal
from arctrue.workbench.inference.forward.search import Line
from arctrue.workbench.inference.forward.slow import SlowChange
from arctrue.workbench.inference.forward.tests_of_a_line import FAMILY_WISE
from arctrue.workbench.inference.repeated_error import RepeatedError

SAME_LINE = 1.5
"""A line over time and a line over the angle count as the same line if their distance is below
this, in units of 1/span. At a nearly constant speed, a line over the angle has this width over
time."""


@dataclass(frozen=True)
class Band:
    """Range of rates of a record in which the search looked for lines."""

    in_time: bool
    highest: float


MOST_FAST = 5
"""Largest number of fast lines in a sentence; the JSON contains all."""


@dataclass(frozen=True)
class FastLineOfRows:
    """A line in single rows, too fast for the averaged rows of the search."""

    rate: float
    amplitude_arcsec: float
    in_time: bool
    turns_s: float | None
    """Turns per second, which convert an order into a frequency; None without times."""

    @property
    def period_s(self) -> float | None:
        """Period; None where it is not known."""
        if self.in_time:
            return 1.0 / self.rate
        return None if self.turns_s is None else 1.0 / (self.rate * self.turns_s)

    def words(self) -> str:
        """Return the amplitude, and the period or the order."""
        size = f"{self.amplitude_arcsec:.3g}″ at"
        if self.period_s is None:
            return f"{size} order {self.rate:.5g}"
        seconds = f"{size} {self.period_s:.4g} s"
        return seconds if self.in_time else f"{seconds}, order {self.rate:.5g}"


@dataclass(frozen=True, eq=False)
class RegularCause:
    """Lines of one cause: one line, or several multiples of an order that the set declares."""

    effect: Effect
    nonlinear: Nonlinear
    lines: tuple[Line, ...]
    """Lines of the cause, the largest first."""
    in_time: bool
    turns_s: float | None
    """Turns per second, which convert an order into a frequency; None if speeds differ."""

    @property
    def taken_arcsec(self) -> float:
        """RMS over all rows of the error that the prediction from other blocks explains."""
        return float(np.sqrt(sum(line.taken_arcsec**2 for line in self.lines)))

    @property
    def trials(self) -> float:
        """Number of independent rates, or of lines, by which the cause's p is corrected."""
        return float(len(self.lines)) if self.lines[0].multiple else self.lines[0].independent

    def period_s(self, line: Line) -> float | None:
        """Return the period of one of the cause's lines; None where it is not known."""
        if self.in_time:
            return 1.0 / line.rate
        return None if self.turns_s is None else 1.0 / (line.rate * self.turns_s)

    def data(self) -> dict[str, Any]:
        """Return the cause as JSON."""
        return {
            "effect": self.effect.name,
            "taken_arcsec": self.taken_arcsec,
            "lines": [
                {
                    "order": None if self.in_time else line.rate,
                    "frequency_hz": line.rate if self.in_time else None,
                    "period_s": self.period_s(line),
                    "multiple": line.multiple,
                    "amplitude_arcsec": line.amplitude_arcsec,
                    "taken_arcsec": line.taken_arcsec,
                    "share_predicted": line.share,
                    "periods": line.periods,
                }
                for line in self.lines
            ],
        }

    def fitted(self, nonlinear: Nonlinear, amplitude_arcsec: float | None) -> RegularCause:
        """Return the cause with the rate and the amplitude of a fit in place of those of the
        search, if it is one line of unknown order; the search fits fewer effects together."""
        if len(self.lines) != 1 or self.lines[0].multiple is not None:
            return self
        rate = nonlinear["frequency" if self.in_time else "order"]
        (line,) = self.lines
        amplitude = line.amplitude_arcsec if amplitude_arcsec is None else amplitude_arcsec
        line = replace(line, rate=rate, amplitude_arcsec=amplitude)
        return replace(self, nonlinear=nonlinear, lines=(line,))

    def words(self) -> str:
        """Return the cause's name, the error that it explains and its lines, the largest first."""
        lines = ", ".join(
            f"{line.amplitude_arcsec:.3g}″ at {self.place_of(line)}" for line in self.lines
        )
        return f"{self.effect.name} {self.taken_arcsec:.3g}″ RMS ({lines})"

    def place_of(self, line: Line) -> str:
        """Return period and order of one of the cause's lines, in words."""
        period_s = self.period_s(line)
        seconds = None if period_s is None else f"{period_s:.4g} s"
        if self.in_time and seconds is not None:
            return seconds
        order = f"order {line.rate:.5g}"
        return order if seconds is None else f"{seconds}, {order}"


@dataclass(frozen=True)
class Statement:
    """A sentence on a detection."""

    sentence: str
    words: str | None = None
    """Description of the detection, as ``Decision.seen`` has it; None if no decision states it in
    these words."""


@dataclass(frozen=True, eq=False)
class Detections:
    """Detections of the forward search in a reference, with one model."""

    causes: tuple[RegularCause, ...] = ()
    """Regular causes, ordered by the error that they explain, the largest first."""
    steps: tuple[Jump, ...] = ()
    """Jumps, which are listed apart because no other block can confirm them."""
    whiteness_p: float | None = None
    """p of Ljung and Box with all lines and steps in the model; None without a search."""
    bands: tuple[Band, ...] = ()
    """Bands of rates that were searched."""
    oscillation: Oscillation | None = None
    """Damped oscillation in the noise of a reference with times and closely spaced rows."""
    slow: SlowChange | None = None
    """Slow change in addition to lines, steps and an even drift, in a reference with times."""
    reversal: Reversal | None = None
    """Reversal error, fitted together with steps in time, in a reference of both directions."""
    noise_level_ratio: float | None = None
    """High level of the noise divided by its low level, if the level changes with time."""
    cycles: CycleChange | None = None
    """Offset of a reference at stations that changes from cycle to cycle."""
    places: RepeatedError | None = None
    """Error that every pass of the reference shows at the same places."""
    fast: tuple[FastLineOfRows, ...] = ()
    """Lines in single rows, too fast for the averaged rows of the search, the largest first."""
    drift: EvenDrift | None = None
    """Even drift of a reference that has lines too, and no slow change of another form."""
    cause: str | None = None
    """The named effect that was in the model during the search for these detections."""
    same: tuple[str, ...] = ()
    """Lines and oscillations that vanish with this effect in the model, because they are its
    aliases; in words."""

    @property
    def empty(self) -> bool:
        """True if there are no detections."""
        lists = bool(self.causes or self.steps or self.fast or self.not_noise)
        others = (self.oscillation, self.slow, self.reversal, self.places)
        return not lists and all(item is None for item in others)

    def further(self, name: str, left: Detections, *, is_line: bool = False) -> Detections:
        """Return ``left``, the detections with the effect ``name`` in the model, with a list of the
        detections that this effect explained.

        If ``name`` is a line, an oscillation that it explains is not listed: the oscillation is the
        line itself, measured with another size.
        """
        kept = [(cause, line) for cause in left.causes for line in cause.lines]
        same = [
            f"{line.amplitude_arcsec:.3g}″ at {cause.place_of(line)}"
            for cause in self.causes
            for line in cause.lines
            if not any(
                other.in_time == cause.in_time and _same_rate(line, found) for other, found in kept
            )
        ]
        if self.oscillation is not None and left.oscillation is None and not is_line:
            near = self.oscillation
            same.append(f"{near.rms_arcsec:.2g}″ RMS near {near.hz:.3g} Hz")
        return replace(left, cause=name, same=tuple(same))

    def without_fast(self, hz: float, passes: Sequence[tuple[float, float]]) -> Detections:
        """Return the detections without the fast lines that are a line of the frequency ``hz`` in
        one of the passes; ``passes``: speed in turns per second and duration in seconds of each."""

        def is_it(line: FastLineOfRows) -> bool:
            speeds = [(1.0, duration_s) for _, duration_s in passes] if line.in_time else passes
            return any(
                abs(line.rate * speed - hz) * duration_s < SAME_LINE for speed, duration_s in speeds
            )

        return replace(self, fast=tuple(line for line in self.fast if not is_it(line)))

    def without(self, one: RegularCause | None) -> Detections:
        """Return the detections without one of the causes, which is in the model."""
        return replace(self, causes=tuple(item for item in self.causes if item is not one))

    def with_other(self, one: RegularCause | None, other: RegularCause | None) -> Detections:
        """Return the detections with ``other`` in place of ``one`` of the causes."""
        if one is None or other is None:
            return self
        return replace(self, causes=tuple(other if item is one else item for item in self.causes))

    def searched(self, nonlinear: Nonlinear) -> bool:
        """Tell whether the search covered this order or frequency, so that a line there would be a
        cause."""
        in_time = bool(nonlinear["in_time"])
        rate = nonlinear["frequency" if in_time else "order"]
        if nonlinear["in_capture"]:
            return False
        return any(band.in_time == in_time and rate <= band.highest for band in self.bands)

    def without_steps(self) -> Detections:
        """Return the detections without steps, for a model with an effect that is itself a step."""
        return replace(self, steps=())

    @property
    def not_noise(self) -> bool:
        """True if there is a step, a change between cycles or runs, or a residual that no noise
        model makes white.

        The search for lines and the search for steps each have the level FAMILY_WISE; the test of
        whiteness has a third of it. No filter makes noise white if the level of one of its parts
        changes with time.
        """
        white = self.whiteness_p is None or self.whiteness_p >= FAMILY_WISE / 3.0
        white = white or self.noise_level_ratio is not None
        return bool(self.steps) or self.cycles is not None or not white

    def data(self) -> dict[str, Any]:
        """Return the detections as JSON."""
        return {
            "regular": [cause.data() for cause in self.causes],
            "fast_lines": [
                {
                    "order": None if line.in_time else line.rate,
                    "period_s": line.period_s,
                    "amplitude_arcsec": line.amplitude_arcsec,
                }
                for line in self.fast
            ],
            "even_drift": None
            if self.drift is None
            else {"size_arcsec": self.drift.size_arcsec, "sigma_arcsec": self.drift.sigma_arcsec},
            "steps": [step.data() for step in self.steps],
            "whiteness_p": self.whiteness_p,
            "noise_level_ratio": self.noise_level_ratio,
            "cycles_arcsec": None if self.cycles is None else self.cycles.rms_arcsec,
            "repeated_at_places": None if self.places is None else self.places.data(),
            "slow_change": None
            if self.slow is None
            else {"size_arcsec": self.slow.size_arcsec, "length_s": self.slow.length},
            "oscillation": None if self.oscillation is None else self.oscillation.data(),
            "reversal": None
            if self.reversal is None
            else {
                "size_arcsec": self.reversal.size_arcsec,
                "sigma_arcsec": self.reversal.sigma_arcsec,
            },
            "same_as_cause": {"cause": self.cause, "seen_as": list(self.same)},
        }

    def sentences(self) -> list[str]:
        """Return the detections in words, one sentence each."""
        return [item.sentence for item in self.statements()]

    def statements(self) -> list[Statement]:
        """Return the sentences on the detections."""
        found = []
        if self.same:
            found.append(
                Statement(
                    f"The reference shows the same error as {self.cause}: {'; '.join(self.same)}."
                )
            )
        found += [item for _, item in sorted(self._by_size(), key=lambda item: -item[0])]
        if self.cycles is not None:
            words = self.cycles.words()
            found.append(Statement(f"{words[0].upper()}{words[1:]}.", words))
        if self.places is not None:
            words = self.places.words()
            found.append(Statement(f"{words[0].upper()}{words[1:]}.", words))
        if self.slow is not None:
            found.append(
                Statement(
                    f"A slow change of unknown form, {angle_words(self.slow.size_arcsec)} over "
                    f"{self.slow.length:.4g} s, is most of the remaining error of the reference."
                )
            )
        if self.drift is not None:
            size = angle_words(self.drift.size_arcsec)
            found.append(
                Statement(
                    "With these lines in the model, the error of the reference changes evenly by "
                    f"{size} (u {angle_words(self.drift.sigma_arcsec)}) over "
                    f"{self.drift.length:.4g} s."
                )
            )
        if self.oscillation is not None:
            where, words = (
                "error" if self.oscillation.is_line else "noise",
                self.oscillation.words(),
            )
            found.append(Statement(f"The {where} contains {words}.", words))
        if self.noise_level_ratio is not None:
            found.append(
                Statement(
                    "The noise level of the reference changes with time: the level of its noisy "
                    f"parts is {self.noise_level_ratio:.2g} times that of its quiet parts."
                )
            )
        return found

    def _by_size(self) -> Iterator[tuple[float, Statement]]:
        """Yield sentences, each with the RMS of its detection in arcseconds."""
        if self.causes:
            words = "; ".join(cause.words() for cause in self.causes)
            yield (
                max(cause.taken_arcsec for cause in self.causes),
                Statement(f"Regular errors in the reference, with the size of each: {words}."),
            )
        if self.fast:
            words = "; ".join(line.words() for line in self.fast[:MOST_FAST])
            more = len(self.fast) - MOST_FAST
            words += f"; and {more} smaller" if more > 0 else ""
            yield (
                self.fast[0].amplitude_arcsec / np.sqrt(2.0),
                Statement(
                    f"Single rows show lines too fast for the averaged rows of the search: {words}."
                ),
            )
        if self.reversal is not None:
            # Half of the error acts upwards and half downwards.
            size, sigma = abs(self.reversal.size_arcsec), self.reversal.sigma_arcsec
            passes = f"{self.reversal.passes} passes"
            if sigma is None:
                words = (
                    f"Up and down differ by {angle_words(size)}: {passes} cannot confirm that this "
                    "is a reversal error, because a change in time looks the same."
                )
            else:
                # A delay at one speed looks the same as a reversal error.
                words = (
                    f"Up and down differ by {angle_words(size)} (u {angle_words(sigma)}) over "
                    f"{passes}."
                )
            yield size / 2.0, Statement(words)
        if self.steps:
            yield (
                max(abs(step.size_arcsec) for step in self.steps) / 2.0,
                Statement(
                    list_of_jumps(self.steps),
                    self.steps[0].words() if len(self.steps) == 1 else None,
                ),
            )


def _same_rate(one: Line, other: Line) -> bool:
    """Tell whether the rates differ by less than the record resolves."""
    return abs(one.rate - other.rate) * one.periods < SAME_LINE * one.rate
