"""Rules for a survey that finds no effect, or a single slip."""

from __future__ import annotations

from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.lack_of_fit import LACK_OF_FIT, LEAST_EXCESS
from arctrue.workbench.diagnose.next_measurement import (
    LOOK_AT_THE_BRACKETS,
    LOOK_AT_THE_DRIVE,
    OF_PARTS,
    TURN_THE_POLYGON,
    TURN_THE_REFERENCE,
    NextMeasurement,
)
from arctrue.workbench.diagnose.of_the_runs import offsets_follow
from arctrue.workbench.inference.asymmetry_in_time import asymmetry_in_time
from arctrue.workbench.inference.repeated_error import RepeatedError
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.significance import SIGNIFICANCE


def left_undescribed(case: Case) -> Decision | None:
    """The model leaves a large and significant error that nothing describes."""
    if case.best is not None:
        return None
    places = case.survey.detections.places
    # As for an effect, the size of an error at single places is its size where it acts.
    at_places = {"reference": 0.0 if places is None else places.largest_arcsec}
    left = {
        channel: item.excess_arcsec
        for channel, item in case.survey.channels.items()
        if item.lack_of_fit_p is not None
        and item.lack_of_fit_p < LACK_OF_FIT
        and max(item.excess_arcsec, at_places.get(channel, 0.0))
        > max(case.survey.matters_arcsec, LEAST_EXCESS * item.noise_arcsec)
    }
    if not left:
        return None
    if places is None or "reference" not in left:
        return Decision("unknown", undescribed_arcsec=left)
    rows = case.survey.base.observations.reference
    of_faces = rows is not None and rows.faces is not None
    return Decision(
        "unknown",
        undescribed_arcsec=left,
        # Errors at a few places do not show that a named effect has another shape.
        seen=places.words() if places.is_located else None,
        look_alikes=_similar_at_places(case, places),
        next=TURN_THE_POLYGON if of_faces else TURN_THE_REFERENCE,
    )


def _similar_at_places(case: Case, places: RepeatedError) -> dict[str, list[str]]:
    """Return the effects that this set cannot test and that look like an error of these places:
    effects at single places of the disc, and effects with a coefficient for each face of the
    polygon."""
    observations = case.survey.base.observations
    found = {}
    for name, lacking in case.survey.untestable.items():
        kind = case.effects[name]
        if kind.fixed_to_polygon and places.stations and observations.faces is not None:
            is_similar = len(kind().column_names(observations)) == observations.faces
        else:
            is_similar = kind.local_on_disc and bool(places.spots)
        if is_similar:
            found[name] = lacking
    return found


def jumped_or_not_white(case: Case) -> Decision | None:
    """No effect is found, but something jumped or the whitened residuals are not white."""
    if case.best is not None:
        return None
    found = set(case.not_white) | ({"reference"} if case.not_noise else set())
    if not found:
        return None
    left = {
        channel: item.excess_arcsec
        for channel, item in case.survey.channels.items()
        if channel in found
    }
    return Decision("unknown", undescribed_arcsec=left)


def sticks_and_slips(case: Case) -> Decision | None:
    """No effect is found, or a single slip of counts, and R₂ − R₁ or a log of the reference jumps
    in one direction again and again and creeps back."""
    best = case.best
    if case.depth > 1 or (best is not None and best.effect.step_at is None):
        return None
    found = asymmetry_in_time(case.survey.residuals if best is None else Residuals(best.solution))
    if (
        found is None
        or found.p_value >= LACK_OF_FIT
        or found.p_in_tails >= SIGNIFICANCE
        or found.rms_arcsec < case.survey.matters_arcsec
    ):
        return None
    where = LOOK_AT_THE_DRIVE if found.of_reference else LOOK_AT_THE_BRACKETS
    return Decision("unknown", seen=found.words(), next=where)


def runs_follow_a_condition(case: Case) -> Decision | None:
    """No effect is found, but the offsets of the runs follow a condition and exceed the index
    scatter."""
    if case.best is not None or case.depth > 1:
        return None
    found = offsets_follow(case.survey.residuals)
    if found is None or found.rms_arcsec < case.survey.matters_arcsec:
        return None
    seen = (
        f"the offsets of the runs follow the condition {found.part}; they scatter by "
        f"{found.rms_arcsec:.2g}″, the index only by {found.index_arcsec:.2g}″"
    )
    kind, words = OF_PARTS.get(found.part, ("again", f"more runs at other values of {found.part}"))
    return Decision("unknown", seen=seen, next=NextMeasurement(words, kind))


def nothing_found(case: Case) -> Decision | None:
    """No effect and no product of parts is significant."""
    return Decision("adequate") if case.best is None else None
