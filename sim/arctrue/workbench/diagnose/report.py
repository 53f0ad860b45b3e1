"""Writes a diagnosis as sentences."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.base.figures import with_uncertainty
from arctrue.workbench.diagnose.aliases import folded_frequencies, folded_periods_s, in_capture
from arctrue.workbench.diagnose.candidate import RUNS_ARE_THE_SAMPLE, Candidate, is_line
from arctrue.workbench.diagnose.coverage import Coverage
from arctrue.workbench.diagnose.detections import Detections
from arctrue.workbench.diagnose.diagnosis import Diagnosis
from arctrue.workbench.diagnose.lack_of_fit import LEAST_EXCESS
from arctrue.workbench.diagnose.probable import probable
from arctrue.workbench.diagnose.report_json import with_aliases
from arctrue.workbench.diagnose.shared_curve import shared_curve
from arctrue.workbench.effects.parameter import kind_of
from arctrue.workbench.effects.part_conditions import MOST_RUNS, too_many_runs
from arctrue.workbench.inference.detectable import Detectable


def sentences(result: Diagnosis) -> list[str]:
    """Return the verdict and the next steps in words."""
    if result.verdict == "bad_data":
        return ["The data themselves are faulty:", *result.decision.faults]
    if result.verdict == "cannot_tell":
        return [
            f"This set cannot decide: {result.decision.cannot_tell}.",
            *_index(result),
            *result.detections.sentences(),
            *_not_searched(result),
            *shared_curve(result.base),
            *_noise_of_heads(result),
            *probable(result),
            *_measurement(result),
            *_negligible(result),
        ]
    if result.verdict == "adequate":
        said = [
            "The model is adequate: no known effect, and no product of parts, adds anything.",
            *_covered(result.covers),
            *_index(result),
        ]
    elif result.verdict == "named" and result.named is not None:
        said = [f"Missing: {result.named.name}. {_physics(result)}"]
        effect = result.named.effect
        of_data = effect.describe_data(result.named.nonlinear, result.observations)
        of_values = effect.describe_values(result.named.parameters())
        of_values = of_values or size_sentence(result.named)
        said += [words for words in (of_data, of_values, *_aliased(result)) if words]
        said += _folded(result.named, result)
        if len(result.effect_class) > 1:
            larger = ", ".join(result.effect_class[1:])
            said.append(f"Effects with more parameters would explain this error too: {larger}.")
        smaller = _smaller_part(result)
        said += smaller
        if result.second is not None and not (smaller and result.second.bare):
            said.append(result.second.sentence)
        said.append(_compensation(result.named))
        more = _explains_more(result)
        if more is not None:
            name = result.named.name
            which, added = ("A second ", "the first") if more == name else ("", name)
            said.append(f"{which}{more} explains a further part. Add {added} and diagnose again.")
        said += _further_size(result)
    elif result.verdict == "ambiguous":
        said = [*_undecided(result), *_aliased(result), *_further_line(result)]
    elif result.decision.a_part and result.decision.resembles is not None:
        part = result.decision.resembles
        size = part.effect.describe_values(part.parameters()) or size_sentence(part)
        said = [
            f"No known effect explains the whole error: {part.name} explains a part of it.",
            *([size] if size else []),
            f"With {part.name} in the model, an unknown error of about its size remains: "
            f"{result.description}.",
        ]
    elif result.decision.resembles is not None:
        said = [
            "None of the known effects fits. The error resembles "
            f"{result.decision.resembles.name}, but: "
            f"{result.decision.unlike}."
        ]
        if result.description is not None:
            said.append(f"Description of the error: {result.description}.")
    elif result.decision.seen is not None:
        said = [f"None of the known effects fits: {result.decision.seen}."]
        said += _folded_in_each_run(result)
    elif result.description is None and (
        result.detections.cycles is not None
        or result.detections.places is not None
        or result.slopes
    ):
        said = ["None of the known effects fits.", *_index(result)]
    elif result.description is None:
        said = [
            "The model does not fit, and neither an effect nor a product of parts describes the "
            "remaining error: see the maps of arctrue compare."
        ]
    else:
        said = [
            f"None of the known effects fits. Best description: {result.description}.",
            *_equal(result),
            *(_further_with_description(result) if result.lag is None else [result.lag.words()]),
        ]
    found = [
        item.sentence
        for item in _detections_to_state(result).statements()
        # The first sentence states the detection already.
        if item.words is None or item.words != result.decision.seen
    ]
    if result.verdict == "unknown" and result.decision.look_alikes:
        lacking = "; ".join(
            sorted({i for all_ in result.decision.look_alikes.values() for i in all_})
        )
        names = ", ".join(result.decision.look_alikes)
        found.append(f"{names} would look the same and cannot be tested: the set lacks {lacking}.")
    # No single effect has the shape of a jump together with a reversal error. If an unknown error
    # has both, the sentences on these two come first.
    detections = result.detections
    first = (
        result.verdict == "unknown" and detections.reversal is not None and bool(detections.steps)
    )
    said = [*found, *said] if first else [*said, *found]
    said += _not_searched(result)
    said += shared_curve(result.base)
    said += _noise_of_heads(result)
    said += probable(result)
    said += _measurement(result)
    return said + _negligible(result)


def _detections_to_state(result: Diagnosis) -> Detections:
    """Return the detections without the oscillation that the verdict states, which other rows may
    show with slightly different values."""
    found, seen = result.detections, result.decision.oscillation
    if seen is None or found.oscillation is None or not seen.is_same(found.oscillation):
        return found
    return replace(found, oscillation=None)


def _negligible(result: Diagnosis) -> list[str]:
    names = ", ".join(item.name for item in result.negligible)
    return [f"Significant but too small to matter: {names}."] if names else []


def _noise_of_heads(result: Diagnosis) -> list[str]:
    rows = result.observations.capture
    noise = None if rows is None else rows.head_noise
    return [noise.sentence()] if noise is not None and noise.differ else []


def _not_searched(result: Diagnosis) -> list[str]:
    """Return a sentence if the reference has too many runs to search for changes between them."""
    runs = too_many_runs(result.observations)
    if runs is None:
        return []
    return [
        "The diagnosis did not search for an order that changes between two runs: the reference "
        f"has {runs} runs, more than {MOST_RUNS}."
    ]


def _equal(result: Diagnosis) -> list[str]:
    """Return a sentence on each other condition that describes the error equally well."""
    return [
        "Another condition, with a fitted zero, describes the error equally well: "
        f"{item.effect.describe(item.parameters())}."
        for item in result.equals
    ]


def _further_with_description(result: Diagnosis) -> list[str]:
    """Return a sentence on the effect, or on the class of effects, that the diagnosis finds with
    the description in the model."""
    further = result.decision.further
    if further is None or further.first is None:
        return []
    item = further.first
    size = max(item.size_arcsec.values(), default=0.0)
    words = item.effect.describe_data(item.nonlinear, result.observations)
    names = " or ".join(further.effect_class)
    said = f"With this description in the model, {names} explains a further {size:.2g}″ RMS."
    return [" ".join([said, words] if words else [said])]


def _further_line(result: Diagnosis) -> list[str]:
    """With the first effect of a class in the model, the diagnosis may name a line: return a
    sentence on this line if the detections do not list it."""
    first, further = result.decision.first, result.decision.further
    item = None if further is None or further.verdict != "named" else further.first
    if first is None or item is None or not is_line(item) or item.regular is not None:
        return []
    words = item.effect.describe_data(item.nonlinear, result.observations)
    said = f"With {first.name} in the model, {item.name} explains a further part."
    return [" ".join([said, words] if words else [said])]


MOST_OF_EXCESS = 0.5
"""Share of the error's mean square above the noise. If the named effect leaves more than this
share, a sentence says that most of the error remains."""


def _smaller_part(result: Diagnosis) -> list[str]:
    """Return one sentence if most of the error remains with the named effect in the model.

    There is no sentence for an effect that only the offsets of the runs show, because the RMS of
    the rows does not contain the runs' offsets.
    """
    item, before = result.named, result.before
    after = None if item is None else result.left.get(item.name)
    if item is None or before is None or after is None:
        return []
    if item.evidence is not None and item.evidence.index_share >= RUNS_ARE_THE_SAMPLE:
        return []
    channel = max(item.size_arcsec, key=lambda name: item.size_arcsec[name], default=None)
    if channel is None or channel not in before.rms_arcsec or channel not in after.rms_arcsec:
        return []
    noise = min(before.noise_arcsec[channel], after.noise_arcsec[channel])
    excess = before.rms_arcsec[channel] ** 2 - noise**2
    rest = after.rms_arcsec[channel] ** 2 - noise**2
    if excess <= (LEAST_EXCESS * noise) ** 2 or rest <= MOST_OF_EXCESS * excess:
        return []
    return [
        f"{item.name} explains the smaller part of the error: {after.rms_arcsec[channel]:.3g}″ RMS "
        f"of the {channel} remain with this effect in the model, {before.rms_arcsec[channel]:.3g}″ "
        f"without it (noise {noise:.2g}″)."
    ]


def _explains_more(result: Diagnosis) -> str | None:
    """Return the name of the effect that would be named next. If there is none, return the name of
    the largest regular cause that remains with the named effect in the model."""
    if result.further:
        return result.further[0].name
    named = None if result.named is None else result.named.regular
    left = result.detections.without(named).causes
    return left[0].effect.name if left else None


def _further_size(result: Diagnosis) -> list[str]:
    """Return a sentence on the size of the effect that would be named next, for a line also on its
    order or frequency. There is no sentence for lines that the detections list."""
    item = result.further[0] if result.further else None
    listed = {cause.effect.name for cause in result.detections.causes}
    if item is None or (is_line(item) and item.name in listed):
        return []
    words = size_sentence(item)
    return [f"{item.name}: {words[0].lower()}{words[1:]}"] if words else []


MOST_SIZES = 6
"""Largest number of fitted values in a sentence; the JSON contains all values."""


def size_sentence(item: Candidate) -> str:
    """Return the fitted values of an effect with their standard uncertainties in a sentence; empty
    if none has an uncertainty.

    An effect with more than MOST_SIZES values has its RMS in place of them. Phases, and values that
    follow from others, are in the JSON only.
    """
    every = item.parameters()
    left_out = item.effect.derived(every, item.nonlinear, item.solution.observations)
    known = [
        (name, value)
        for name, value in every.items()
        if name not in left_out
        and kind_of(name, value) != "phase"
        and np.isfinite(value.sigma)
        and value.sigma > 0.0
    ]
    if not known:
        return ""
    if len(known) > MOST_SIZES and "rms" in dict(known):
        # The change of the prediction also contains the change of the other coefficients.
        rms = every["rms"]
        return f"Fitted size: {with_uncertainty(rms.value, rms.sigma, rms.unit)} RMS."
    if len(known) > MOST_SIZES:
        sizes = ", ".join(f"{size:.3g}″ RMS of the {name}" for name, size in _sizes(item))
        return f"Fitted size: {sizes}." if sizes else ""
    words = ", ".join(
        f"{name.replace('_', ' ')} {with_uncertainty(value.value, value.sigma, value.unit)}"
        for name, value in known
    )
    return f"Fitted values, with standard uncertainties: {words}."


def _sizes(item: Candidate) -> list[tuple[str, float]]:
    return [(name, size) for name, size in item.size_arcsec.items() if size > 0.0]


def _index(result: Diagnosis) -> list[str]:
    """Return sentences if the runs' offsets scatter by more than the known repeatability of the
    index explains, or differ between the directions, or if passes over an arc differ by a slope."""
    found = (result.index_scatter, result.directions, result.slopes)
    return [item.sentence() for item in found if item is not None]


def _measurement(result: Diagnosis) -> list[str]:
    """Return the next measurement as a sentence."""
    found = result.next_measurement
    return [] if found is None else [f"Next measurement: {found}."]


def _covered(covers: Coverage) -> list[str]:
    """State in sentences the effects that the verdict "adequate" excludes, each with the smallest
    excluded size."""
    said = []
    if covers.smallest:
        sizes = ", ".join(
            f"{name} {_smallest(item)}" for name, item in sorted(covers.smallest.items())
        )
        said.append(f"In 95 % of such sets the diagnosis would find these sizes: {sizes}.")
    few = sorted(name for name, item in covers.smallest.items() if item.noise_hardly_known)
    if few:
        said.append(
            f"The slow noise is known so poorly for {', '.join(few)} that these sizes are at least "
            "2.8 times those with known noise; a smaller effect may still be found."
        )
    if covers.blind_orders:
        first = ", ".join(f"{order}" for order in covers.blind_orders[:MOST_ORDERS])
        more = " and so on" if len(covers.blind_orders) > MOST_ORDERS else ""
        said.append(f"Orders that the heads cannot see at this separation: {first}{more}.")
    return said


def _aliased(result: Diagnosis) -> list[str]:
    """Return a sentence with the orders that the samples or the stations cannot exclude."""
    item, found = with_aliases(result)
    if item is None:
        return []
    orders = ", ".join(f"{order:.6g}" for order in found)
    if in_capture(item, result.observations):
        return [
            f"Order {item.nonlinear['order']:.6g} or its alias {orders}: the samples of the "
            "capture cannot separate them. A run with another number of samples a turn, or from "
            "another angle, would separate them."
        ]
    return [
        f"Its order has fewer than two stations a period: orders {orders} and others look the same "
        "at these stations. Stations that are closer, or uneven, would separate them."
    ]


def _folded(item: Candidate, result: Diagnosis) -> list[str]:
    """Return a sentence on the faster lines that look like a line at even steps of time."""
    step_s, periods_s = folded_periods_s(item, result.observations)
    if not periods_s:
        return []
    words = " or ".join(f"{period_s:.4g} s" for period_s in periods_s)
    return [
        f"The rows come every {step_s:.4g} s: a line with a period of {words} would look the same. "
        "Uneven or shorter steps would separate them."
    ]


def _folded_in_each_run(result: Diagnosis) -> list[str]:
    """Return a sentence on the faster lines that look like a line with a phase for each run.

    Such a line is stated with any number of rows a period: the alias of a faster line gets another
    phase where the instants of the rows start anew.
    """
    found, rows = result.decision.oscillation, result.observations.reference
    if found is None or found.in_each_run is None or rows is None:
        return []
    step_s, periods_s = folded_frequencies(rows, found.hz)
    if not periods_s:
        return []
    words = " or ".join(f"{period_s:.4g} s" for period_s in periods_s)
    return [
        f"The rows come every {step_s:.4g} s: a line with a period of {words} would look the same. "
        "It would change its phase from run to run if the rows of each run start at another "
        "instant. Uneven or shorter steps would separate them."
    ]


MOST_ORDERS = 5
"""Largest number of blind orders in a sentence; the JSON contains all orders."""


def _smallest(item: Detectable) -> str:
    size = item.size
    if size is not None:
        return f"{size.value:.2g} {size.unit}".replace(" arcsec", "″").removesuffix(" 1")
    return f"{max(item.rms_arcsec.values()):.2g}″ RMS"


def _undecided(result: Diagnosis) -> list[str]:
    first, why = result.effect_class[0], result.decision.unconfirmed
    if len(result.effect_class) > 1:
        said = [f"This data cannot distinguish between: {', '.join(result.effect_class)}."]
        if result.decision.look_alikes and why is not None:
            said.append(f"This data is not enough to name {first}: {why}.")
    elif why is not None:
        said = [f"{first} fits best, but this data is not enough to name it: {why}."]
    else:
        said = [f"{first} fits best, but this data is not enough to name it."]
    # The size of the first effect is known, although its cause is not.
    item = result.decision.first
    size = ""
    if item is not None:
        size = item.effect.describe_values(item.parameters()) or size_sentence(item)
    if size:
        said.append(f"If the effect is {first}: {size[0].lower()}{size[1:]}")
    if result.description is not None:
        said.append(
            f"A description that is not in the catalogue fits equally well: {result.description}."
        )
        said += _equal(result)
    return said


COMPENSATION_WORDS = {
    "lanes": "The gateware can compensate it with lanes",
    "offset": "The gateware can compensate it with a constant offset",
    "modulators": "A bitstream with MODULATORS can compensate it",
    "local_table": "A bitstream with LOCAL_TABLE can compensate it",
    "none": "The gateware cannot compensate it",
    "reference": "There is nothing to compensate",
}

IN_TIME = (
    "A part of the machine or of its surroundings repeats its error in time: a fan, a pump, the "
    "mains, a building that sways. The data show the period and the size of the error, not the "
    "part."
)
"""Causes of a line that is fixed to time; gears, slots and steps are fixed to the angle."""


def _in_time(item: Candidate) -> bool:
    """Tell whether the candidate is a line of unknown cause that is fixed to time."""
    return item.effect.unspecific and bool(item.nonlinear.get("in_time", 0.0))


def _physics(result: Diagnosis) -> str:
    """Return the causes of the named effect in words."""
    item = result.named
    assert item is not None
    if result.signal_period is not None:
        return " ".join(result.signal_period.sentences())
    return IN_TIME if _in_time(item) else item.effect.physics


def _compensation(item: Candidate) -> str:
    if _in_time(item):
        return f"{COMPENSATION_WORDS['none']}: a line fixed to time has no order of the angle."
    words = COMPENSATION_WORDS[item.effect.compensation]
    note = item.effect.compensation_note
    return f"{words}: {note}." if note else f"{words}."
