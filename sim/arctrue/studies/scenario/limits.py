"""Compares the result of a scenario with its limits."""

from __future__ import annotations

from arctrue.studies.scenario.result import ScenarioResult, ScenarioTurn


def broken_limits(result: ScenarioResult) -> tuple[str, ...]:
    """Return one sentence for each limit that the run does not keep."""
    limits = result.scenario.limits
    found = []
    last = limits.to_turn or len(result.turns)
    for turn in result.turns:
        if limits.from_turn <= turn.number <= last:
            found += _errors_of(turn, result)
        found += _worse(turn, limits.worse_by_arcsec)
    for what, number, least, most in (
        ("applied", result.applied, limits.applied_turns_least, None),
        ("refused", result.refused, limits.refused_turns_least, limits.refused_turns_most),
    ):
        if least is not None and number < least:
            found.append(f"the firmware {what} {number} captures, {least} or more are expected")
        if most is not None and number > most:
            found.append(f"the firmware {what} {number} captures, {most} at most are expected")
    reasons = {reply["reason"] for turn in result.turns for reply in turn.telemetry}
    found += [
        f"no capture was refused for: {reason.replace('_', ' ')}"
        for reason in limits.reasons_wanted
        if reason not in reasons
    ]
    raised = {flag for turn in result.turns for flag in turn.flags}
    found += [
        f"{flag} was expected, but was not raised"
        for flag in limits.flags_wanted
        if flag not in raised
    ]
    if limits.flags_allowed is not None:
        allowed = {*limits.flags_allowed, *limits.flags_wanted}
        found += [f"{flag} was raised" for flag in sorted(raised - allowed)]
    return tuple(found)


def _errors_of(turn: ScenarioTurn, result: ScenarioResult) -> list[str]:
    limits = result.scenario.limits
    if turn.corrected is None:
        wanted = (limits.corrected_rms_arcsec, limits.corrected_reach_arcsec)
        return [] if wanted == (None, None) else [f"turn {turn.number}: the core gave no edge"]
    found = []
    for name, value, limit in (
        ("RMS", turn.corrected.rms_arcsec, limits.corrected_rms_arcsec),
        ("largest error", turn.corrected.reach_arcsec, limits.corrected_reach_arcsec),
    ):
        if limit is not None and not value <= limit:
            found.append(
                f"turn {turn.number}: corrected {name} {value:.3f}″, the limit is {limit:g}″"
            )
    return found


def _worse(turn: ScenarioTurn, by_arcsec: float | None) -> list[str]:
    if by_arcsec is None or turn.corrected is None or turn.uncorrected is None:
        return []
    worse = turn.corrected.rms_arcsec - turn.uncorrected.rms_arcsec
    if worse <= by_arcsec:
        return []
    return [
        f"turn {turn.number}: corrected RMS is {worse:.3f}″ above the uncorrected one, "
        f"the limit is {by_arcsec:g}″"
    ]
