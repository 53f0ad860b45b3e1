"""Rules that refuse the best effect because an error of its size or kind remains with it in the
model."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate, happens_once
from arctrue.workbench.diagnose.case import AGAIN, Case
from arctrue.workbench.diagnose.classes import OF_THE_SAME_KIND, is_apart
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.rules.best_effect import (
    is_of_the_runs,
    largest_arcsec,
    only_resembles,
)


def leaves_its_own_kind(case: Case) -> Decision | None:
    """With the best effect in the model, an unknown error of about its size remains.

    An effect with a similar shape removes part of an error that the catalogue does not have: the
    faces of a polygon remove part of a flat track, a slip removes part of the knocks of a loose
    head.
    """
    assert case.best is not None
    if case.shown_by_parts(case.best):
        # The remaining error does not contradict a line that other blocks predict, or a reversal
        # error that other passes show; it is a further detection.
        return None
    left = case.further
    if left is None or not _unknown_within(left, case):
        return None
    if left.described is not None and _grows_with_a_column(case.best, left.described):
        return None
    found = only_resembles(
        case,
        "with it in the model an unknown error of about its size remains",
        left,
    )
    apart = found.described is not None and is_apart(case.best, found.described)
    return replace(found, a_part=apart)


def _unknown_within(left: Decision, case: Case) -> bool:
    """Return True if an unknown error of the size of the first effect remains, also after further
    effects."""
    first = case.best
    assert first is not None
    if left.oscillation is not None:
        # An oscillation driven by noise may accompany any effect; if it is larger than the effect,
        # the effect is probably a part of the same unknown error.
        return left.oscillation.rms_arcsec > largest_arcsec(first)
    if left.seen is not None:
        # A single event is no evidence that the effect has another shape.
        return False
    if left.verdict != "unknown":
        return left.further is not None and _unknown_within(left.further, case)
    found = left.described or left.resembles
    if found is not None:
        # The remaining error must be large compared with the first effect both in units of the
        # noise and in arcseconds. If the repeats have little noise, the first test alone would let
        # a fiftieth of the error prevent the name.
        in_noise = found.gain > OF_THE_SAME_KIND * first.gain
        return (
            in_noise and largest_arcsec(found) ** 2 > OF_THE_SAME_KIND * largest_arcsec(first) ** 2
        )
    if not left.undescribed_arcsec:
        return True
    # The remaining error is compared with the largest of several sizes of the first effect. The
    # fall of the mean square counts, because slow noise may have absorbed the effect before it was
    # added. The change of another channel's prediction counts, because the effect may remove
    # nothing in this channel. An effect that only the offsets of the runs show removes nothing in
    # its own channel.
    of_the_runs = is_of_the_runs(case)
    return any(
        after**2
        > OF_THE_SAME_KIND
        * max(
            case.survey.channels[channel].excess_arcsec ** 2 - after**2,
            _fall_of_square(case, channel),
            0.0,
            *(
                moved**2
                for name, moved in first.moved_arcsec.items()
                if name != channel or of_the_runs
            ),
        )
        for channel, after in left.undescribed_arcsec.items()
    )


def _fall_of_square(case: Case, channel: str) -> float:
    """Return the mean square that the best effect removes from the residual of a channel,
    arcsec²."""
    if case.with_best is None:
        return 0.0
    before, after = case.survey.channels[channel], case.with_best.survey.channels[channel]
    return before.residual_rms_arcsec**2 - after.residual_rms_arcsec**2


def _grows_with_a_column(best: Candidate, product: Candidate) -> bool:
    """Tell whether the product is the best effect times a further column: the effect then has no
    other shape."""
    column = product.effect.settings.get("column")
    own = set(best.effect.in_parts)
    return bool(own and column) and set(product.effect.parts) == own | {column}


def leaves_a_larger_slow_change(case: Case) -> Decision | None:
    """The best effect is a drift, and with it in the model a larger slow change of unknown form
    remains."""
    best, left = case.best, case.with_best
    assert best is not None
    if left is None or left.survey.detections.slow is None:
        return None
    if best.effect.step_at is not None or not happens_once(best):
        return None
    # The ends of a straight line with the RMS 1 are √12 apart.
    if left.survey.detections.slow.size_arcsec <= np.sqrt(12.0) * largest_arcsec(best):
        return None
    return only_resembles(case, "with it in the model a larger slow change remains")


def comes_again_and_again(case: Case) -> Decision | None:
    """The best effect is an event, and two more events of its kind and size exist.

    One slip is an accident; a head that steps again and again is loose, sticks, or is disturbed.
    """
    best = case.best
    assert best is not None
    if best.effect.step_at is None:
        return None
    left: Case | None = case
    event: Candidate | None = best
    for _ in range(AGAIN - 1):
        left = left.with_it(event) if left is not None else None
        event = None if left is None else left.once_more(best)
        if event is None:
            return None
    return only_resembles(case, f"it occurs {AGAIN} times or more")
