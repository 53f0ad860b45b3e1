"""Rules that refuse the best effect because the error with it in the model is larger, or hardly
smaller."""

from __future__ import annotations

from collections.abc import Mapping

from arctrue.workbench.diagnose.case import DEEPEST, Case
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.lack_of_fit import LACK_OF_FIT, LEAST_EXCESS
from arctrue.workbench.diagnose.rules.best_effect import (
    LEAST_TAKEN,
    channels_moved,
    is_of_the_runs,
    only_resembles,
)

RISES = 1e-3
"""Smallest relative rise of the RMS that the printed figures show (three or four digits). The rise
is averaged over the channels: a fall in one channel compensates for a rise in another channel,
which a further cause may explain."""
PREDICTED = 0.9
"""Share of its own fitted error that other blocks must predict, so that an effect exists although
the error rises a little. A benchmark set with a defect of the disc, whose share is 0.9997, sets
this limit and the next one."""
RISES_IF_PREDICTED = 0.02
"""Largest rise of log(RMS) for such an effect: with the effect in the model, the table's orders fit
a larger error, which is not in the model, in another way."""


def makes_it_worse(case: Case) -> Decision | None:
    """The best effect makes the error of its own channels larger when it is added.

    Its own channels are those in which it has columns.

    An effect that differs between runs only is in the offsets of the runs, whose error is not
    counted. An effect of which other blocks predict nearly all may raise the RMS a little. A line
    that other blocks predict exists even if the RMS rises more: with the line in the model, the
    table's orders fit slow noise differently, which can change the RMS by more than the line.
    """
    found = case.before_and_after
    if found is None or is_of_the_runs(case):
        return None
    if case.best is not None and case.shown_by_parts(case.best):
        return None
    before, after = found
    share = case.best.share if case.best is not None else None
    predicted = share is not None and share.share > PREDICTED
    if after.mean_log_ratio(before) <= (RISES_IF_PREDICTED if predicted else RISES):
        return None
    said = " and ".join(
        f"{channel} {value:.4g}″ RMS ({before.rms_arcsec[channel]:.4g}″ before)"
        for channel, value in after.rms_arcsec.items()
    )
    # Least squares weights the rows by the noise, and the noise is estimated anew with the effect.
    why = "the rows, weighted by their noise, agree better with it, but their error rises"
    return only_resembles(case, f"{why}: {said}")


def takes_little(case: Case) -> Decision | None:
    """The best effect removes less than a tenth of a significant error, and no blocks confirm it.

    A line that other blocks of the rows predict exists even if the remaining error is large;
    further surveys search for that error. If a diagnosis then finds the same kind in every survey,
    and all these effects together remove less than a tenth, the error has another shape, and each
    of them is a part of this error. An effect that differs between runs only is in the offsets of
    the runs and removes nothing from the rows.
    """
    if case.best is None or case.shown_by_parts(case.best) or is_of_the_runs(case):
        # Other blocks predict a line of a forward search, and other passes a reversal error.
        return None
    if case.best.share is not None:
        # An earlier test has refused a share of half or less.
        return _one_kind_takes_little(case)
    found, left = case.before_and_after, case.with_best
    if found is None or left is None:
        return None
    before, after = found
    said = _little_taken(
        case,
        left,
        before.rms_arcsec,
        after.rms_arcsec,
        {name: min(value, after.noise_arcsec[name]) for name, value in before.noise_arcsec.items()},
    )
    if said is None:
        return None
    why = f"of the error above the noise it removes only {said}"
    return only_resembles(case, why, case.further)


def _one_kind_takes_little(case: Case) -> Decision | None:
    """Each effect that is found is of the kind of the first, and together they remove little."""
    assert case.best is not None
    deepest = case
    for _ in range(DEEPEST - 1):
        further = deepest.with_best
        if further is None or further.best is None or further.best.name != case.best.name:
            return None
        deepest = further
    before, after = case.survey.channels, deepest.survey.channels
    said = _little_taken(
        case,
        deepest,
        {name: item.residual_rms_arcsec for name, item in before.items()},
        {name: item.residual_rms_arcsec for name, item in after.items()},
        {name: min(item.noise_arcsec, after[name].noise_arcsec) for name, item in before.items()},
    )
    if said is None:
        return None
    why = (
        f"it is found {DEEPEST} times, and of the error above the noise the first {DEEPEST - 1} "
        f"together remove only {said}"
    )
    return only_resembles(case, why)


def _little_taken(
    case: Case,
    left: Case,
    before: Mapping[str, float],
    after: Mapping[str, float],
    noise: Mapping[str, float],
) -> str | None:
    """Return the removed shares of a significant error, in words; None if one of them is a tenth or
    more."""
    taken = {}
    for channel, rms in before.items():
        rest = left.survey.channels[channel].lack_of_fit_p
        excess = rms**2 - noise[channel] ** 2
        if excess <= (LEAST_EXCESS * noise[channel]) ** 2:
            continue
        share = (rms**2 - after[channel] ** 2) / excess
        if share >= LEAST_TAKEN:
            return None
        # Otherwise the remaining error may be slow noise, which no effect removes.
        if rest is not None and rest < LACK_OF_FIT:
            taken[channel] = max(share, 0.0)
    if case.best is None or not set(taken) & set(channels_moved(case.best, case.survey)):
        return None
    return " and ".join(f"{100.0 * share:.2g} % in the {name}" for name, share in taken.items())
