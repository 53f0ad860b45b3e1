"""Which physical effect is missing, or that the data cannot tell, or that none of these fits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from arctrue.workbench.diagnose.candidate import Candidate, sizes_arcsec
from arctrue.workbench.diagnose.classes import adds, alike, stands_in, without_unspecific
from arctrue.workbench.diagnose.coverage import Coverage, blindness, coverage
from arctrue.workbench.diagnose.data_faults import data_faults
from arctrue.workbench.diagnose.every_pass import on_every_pass
from arctrue.workbench.diagnose.evidence import Evidence, evidence, restricted_likelihood
from arctrue.workbench.diagnose.excluded import look_alikes
from arctrue.workbench.diagnose.free_in_runs import at_other_speeds
from arctrue.workbench.diagnose.heldout import (
    HeldOut,
    Improvement,
    held_out_with,
    holds_out,
    improvement,
)
from arctrue.workbench.diagnose.lack_of_fit import capture_lack_of_fit, reference_lack_of_fit
from arctrue.workbench.diagnose.next_measurement import (
    AT_ONE_SPEED,
    NextMeasurement,
    measurement_for_parts,
    measurement_for_variety,
    next_measurement,
)
from arctrue.workbench.diagnose.noise import capture_noise_arcsec, reference_noise_arcsec
from arctrue.workbench.diagnose.parts import ProductOfParts
from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.diagnose.posterior import posterior
from arctrue.workbench.diagnose.significance import corrected_p_value
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.every_row import on_every_row
from arctrue.workbench.inference.normal_equations import Term
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search_parameters import refined
from arctrue.workbench.inference.solution import Solution, fit
from arctrue.workbench.observations import Observations

Verdict = Literal["adequate", "named", "ambiguous", "unknown", "cannot_tell", "bad_data"]
Progress = Callable[[str], None]

SIGNIFICANCE = 0.01
"""Largest corrected p that names an effect: the aim is a false name on 1 % of adequate sets."""
MATTERS_COUNTS = 0.5
"""An effect that moves the prediction by less than this many counts RMS is negligible."""
PARTS_ADVANTAGE = 10.0
"""BIC by which a product of parts must beat the whole catalogue: odds of about 150 to 1."""
NEAR_TIE = 6.0
"""BIC by which an effect must be ahead of a product of parts that could stand in for it: odds of
20 to 1."""
SAME_GAIN = 0.01
MOVED_SHARE = 0.02
"""A channel counts when it is moved by more than this share of its noise."""
LACK_OF_FIT = 1e-4
LEAST_EXCESS = 0.25
"""A model with a lack of fit this sure, and an excess over the repeats larger than this share of
their noise, is not adequate even where nothing describes what is left."""
MORE_READINGS_THAN_COEFFICIENTS = (
    "the same stations once more: this set has no more readings than coefficients, so "
    "that nothing tells the noise (or state standard_uncertainty_arcsec)"
)
NEAR_P = 0.3
"""A first p below this is near to a name: the noise is estimated anew beside it."""
MOST_WEIGHED = 6
"""So many candidates at most are weighed with the noise free on both sides."""
FAR_BEHIND = 60.0
"""BIC by which a candidate that is not weighed yet cannot come before one that is real."""
RUNS_ARE_THE_SAMPLE = 0.5
"""Share of the index in the variance of an effect's size."""


@dataclass
class Diagnosis:
    """The verdict and what it rests on."""

    observations: Observations
    base: Solution | None
    verdict: Verdict
    named: Candidate | None = None
    effect_class: list[str] = field(default_factory=list)
    class_correlation: dict[str, float] = field(default_factory=dict)
    """Largest canonical correlation of each with the first of the class, beside the model."""
    candidates: list[Candidate] = field(default_factory=list)
    parts: list[Candidate] = field(default_factory=list)
    described: Candidate | None = None
    """The product of parts that explains what no known effect does."""
    description: str | None = None
    next_measurement: str | None = None
    next_measurement_kind: str | None = None
    """Its short name, for programs: one of ``arctrue simulate --further``."""
    noise_arcsec: dict[str, float] = field(default_factory=dict)
    residual_rms_arcsec: dict[str, float] = field(default_factory=dict)
    lack_of_fit: dict[str, float] = field(default_factory=dict)
    held_out_before: HeldOut | None = None
    untestable: dict[str, list[str]] = field(default_factory=dict)
    negligible: list[Candidate] = field(default_factory=list)
    beside: list[Candidate] = field(default_factory=list)
    """Effects that still add something that matters once what was found is in the model."""
    unconfirmed: str | None = None
    """Why an effect that fits, and has no rival, is not named."""
    faults: list[str] = field(default_factory=list)
    covers: Coverage = field(default_factory=Coverage)
    probability: dict[str, float] = field(default_factory=dict)
    """Of every effect that was tested, ``none`` and ``unknown``; the sum is 1."""
    cannot_tell: str | None = None
    """Why, where the verdict is ``cannot_tell``."""
    excluded: frozenset[str] = frozenset()
    """Effects that fit, and that held-out rows, passes or speeds speak against."""
    look_alikes: dict[str, list[str]] = field(default_factory=dict)
    """Effects that this set cannot test but that would look like the first, with what it lacks."""


def diagnose(
    observations: Observations,
    terms: Sequence[Term],
    effects: Mapping[str, type[Effect]],
    *,
    matters_counts: float = MATTERS_COUNTS,
    progress: Progress = lambda text: None,
) -> Diagnosis:
    """Judge every effect that ``terms`` lacks; nothing is drawn: same inputs, same result."""
    faults = data_faults(observations)
    if faults:
        return Diagnosis(
            observations,
            None,
            "bad_data",
            faults=faults,
            next_measurement="record the faulty runs again",
            probability=_probability_of_nothing(),
        )
    progress("fitting the model")
    base = fit(terms, observations)
    residuals = Residuals(base)
    if _noise_is_unknown(base):
        return Diagnosis(
            observations,
            base,
            "cannot_tell",
            next_measurement=MORE_READINGS_THAN_COEFFICIENTS,
            cannot_tell="its rows are too few beside the coefficients to show noise",
            probability=_probability_of_nothing(),
        )
    result = Diagnosis(observations, base, "adequate")
    _judge_fit(result, residuals)
    present = {term.effect.name for term in terms}
    absent = {name: effect for name, effect in effects.items() if name not in present}
    repeatable = {
        name: effect for name, effect in effects.items() if name in present and effect.search
    }
    for name, kind in [*absent.items(), *repeatable.items()]:
        effect = kind()
        lacking = effect.missing(observations) or _on_an_arc(effect, observations)
        if lacking:
            result.untestable[name] = lacking
            continue
        progress(f"trying {name}")
        candidate = _try_effect(effect, base, residuals, len(absent))
        if candidate is not None:
            result.candidates.append(candidate)
    progress("trying products of parts")
    result.parts = _try_parts(base, residuals)
    count = observations.count_arcsec
    matters = 0.0 if count is None else matters_counts * count
    _weigh(result, residuals, len(absent), matters, progress)
    _rank(result)
    result.covers = coverage(residuals, result.candidates, result.untestable, len(absent))
    _decide(result, residuals, matters, effects)
    if result.verdict == "adequate":
        _unless_blind(result, residuals, matters)
    result.probability = _probability(result)
    _look_beside(result, len(absent), matters)
    progress("fitting every row")
    _sharpen(result)
    return result


def _unless_blind(result: Diagnosis, residuals: Residuals, matters_arcsec: float) -> None:
    """Nothing was found; where little could be, that says nothing."""
    found = blindness(residuals, result.covers, result.residual_rms_arcsec, matters_arcsec)
    if found is not None:
        result.verdict = "cannot_tell"
        result.cannot_tell = found.reason
        result.next_measurement = found.next_measurement
        result.next_measurement_kind = found.next_measurement_kind


def _probability_of_nothing() -> dict[str, float]:
    """Beforehand: nothing was tested."""
    return posterior(
        "cannot_tell",
        [],
        1,
        effect_class=[],
        look_alikes=[],
        product=None,
        excluded=frozenset(),
        lack_of_fit_p=1.0,
        rows=1,
        near_tie=NEAR_TIE,
        advantage=PARTS_ADVANTAGE,
    )


def _probability(result: Diagnosis) -> dict[str, float]:
    product = result.described
    if product is None and not result.effect_class:
        product = next(iter(result.parts), None)
    return posterior(
        result.verdict,
        result.candidates,
        len(result.untestable),
        effect_class=result.effect_class,
        look_alikes=list(result.look_alikes),
        product=product,
        excluded=result.excluded,
        lack_of_fit_p=min(result.lack_of_fit.values(), default=1.0),
        rows=result.observations.rows,
        near_tie=NEAR_TIE,
        advantage=PARTS_ADVANTAGE,
    )


def _noise_is_unknown(base: Solution) -> bool:
    """No channel has readings beyond what its coefficients take, nor a stated uncertainty."""
    observations = base.observations
    there = {
        name
        for name, rows in (("capture", observations.capture), ("reference", observations.reference))
        if rows is not None
    }
    return there <= base.unknown_noise


def _sharpen(result: Diagnosis) -> None:
    """What the verdict rests on: search parameters refined, and fitted to every row."""
    chosen = [] if result.described is None else [result.described]
    if result.effect_class:
        chosen.append(result.candidates[0])
    for item in chosen:
        item.solution = on_every_row(refined(item.solution))
        item.nonlinear = item.solution.terms[-1].nonlinear


def _on_an_arc(effect: Effect, observations: Observations) -> list[str]:
    """What lacks to orders of which not one goes through a period on the arc of the reference.

    They are then a slow curve, as a drift is, and say nothing of the disc.
    """
    rows = observations.reference
    if observations.capture is not None or rows is None or effect.search:
        return []
    orders = effect.disc_orders({})
    arc_rad = float(np.ptp(rows.target_rad))
    if not orders or max(orders) * arc_rad >= 2.0 * np.pi:
        return []
    return ["stations over one period of its orders"]


def _judge_fit(result: Diagnosis, residuals: Residuals) -> None:
    for channel, values, noise, lack in (
        ("capture", residuals.capture_arcsec, capture_noise_arcsec, capture_lack_of_fit),
        ("reference", residuals.reference_arcsec, reference_noise_arcsec, reference_lack_of_fit),
    ):
        if values is None:
            continue
        result.noise_arcsec[channel] = noise(result.observations, values)
        result.residual_rms_arcsec[channel] = float(np.sqrt(np.mean(values**2)))
        p_value = lack(residuals)
        if p_value is not None:
            result.lack_of_fit[channel] = p_value


def _try_effect(
    effect: Effect, base: Solution, residuals: Residuals, candidates: int
) -> Candidate | None:
    observations = base.observations
    nonlinear: dict[str, float] = {}
    effect, trials = effect.narrowed(residuals)
    if effect.search:
        places = effect.scan(residuals)
        if not places:
            return None
        nonlinear, trials = places[0].nonlinear, places[0].trials
    score = residuals.score(effect, nonlinear)
    if score.rank == 0:
        return None
    return _candidate(
        effect,
        nonlinear,
        score.gain,
        score.rank,
        trials,
        residuals,
        candidates,
        effect.variety(observations),
    )


def _candidate(
    effect: Effect,
    nonlinear: dict[str, float],
    gain: float,
    rank: int,
    trials: float,
    residuals: Residuals,
    candidates: int,
    lacking_variety: list[str],
) -> Candidate:
    base = residuals.solution
    score = residuals.score(effect, nonlinear)
    solution = residuals.solution_with(effect, nonlinear, score)
    size_arcsec = sizes_arcsec(base, solution)
    return Candidate(
        effect=effect,
        nonlinear=nonlinear,
        gain=gain,
        rank=rank,
        trials=trials,
        solution=solution,
        delta_bic=_delta_bic(gain, rank, trials, size_arcsec, base),
        size_arcsec=size_arcsec,
        p_corrected=corrected_p_value(gain, rank, trials, candidates),
        lacking_variety=lacking_variety,
    )


def _delta_bic(
    gain: float, rank: int, trials: float, size_arcsec: Mapping[str, float], base: Solution
) -> float:
    rows = _rows_moved(size_arcsec, base) or base.observations.rows
    return float(gain - rank * np.log(rows) - 2.0 * np.log(max(trials, 1.0)))


def _rows_moved(size_arcsec: Mapping[str, float], base: Solution) -> int:
    """Rows of the channels that the effect moves: the others say nothing of it.

    A polygon's faces are known from the 480 reference rows, however long the capture.
    """
    channels = (
        ("capture", base.observations.capture, base.capture_sigma_arcsec),
        ("reference", base.observations.reference, base.reference_sigma_arcsec),
    )
    return sum(
        rows.run.size
        for name, rows, sigma in channels
        if rows is not None
        and sigma is not None
        and size_arcsec.get(name, 0.0) > MOVED_SHARE * sigma
    )


def _try_parts(base: Solution, residuals: Residuals) -> list[Candidate]:
    found = []
    for item in best_parts(residuals):
        if item.rank == 0:
            continue
        tried = _candidate(item.effect, {}, item.gain, item.rank, item.trials, residuals, 1, [])
        tried.level_trials = item.level_trials
        tried.p_corrected = corrected_p_value(item.gain, item.rank, item.level_trials, 1)
        found.append(tried)
    return sorted(found, key=lambda item: -item.delta_bic)


def _weigh(
    result: Diagnosis,
    residuals: Residuals,
    candidates: int,
    matters_arcsec: float,
    progress: Progress,
) -> None:
    """Evidence with the noise free on both sides, for whatever may be named.

    That is the catalogue's candidates, best first, until those that follow have no chance to come
    before one that is real, and the product of parts that stands first if it has.
    """
    null = restricted_likelihood(residuals)
    base = residuals.solution
    waiting = sorted(result.candidates, key=lambda item: -item.delta_bic)
    waiting = [item for item in waiting if item.p_corrected < NEAR_P or item.effect.step_at]
    real: Candidate | None = None
    for _ in range(MOST_WEIGHED):
        if real is not None:
            beside = real
            waiting = [item for item in waiting if _may_come_before(item, beside)]
        if not waiting:
            break
        item = waiting.pop(0)
        _judge(item, residuals, null, candidates, progress)
        if (
            item.p_corrected < SIGNIFICANCE
            and _matters(item, matters_arcsec)
            and _holds_out(item)
            and at_other_speeds(item)
            and on_every_pass(item, base)
            and (real is None or item.delta_bic > real.delta_bic)
        ):
            real = item
            beside = real
            waiting.sort(key=lambda item: -_bic_beside(item, beside))
    for item in result.parts[:1]:
        ahead = real is None or _bic_beside(item, real) > -FAR_BEHIND
        if item.p_corrected < NEAR_P and ahead:
            _judge(item, residuals, null, 1, progress)
    if real is not None:
        _same_noise(result, real)
    result.held_out_before = next(
        (item.held_out_before for item in waiting if item.held_out_before is not None), None
    )


def _gain_beside(item: Candidate, real: Candidate) -> float:
    """Gain with the noise of one that is real, on the scale of that one's likelihoods."""
    assert real.evidence is not None
    scale = real.gain / max(real.evidence.score.gain, 1e-300)
    return real.evidence.base.score(item.effect, item.nonlinear).gain * scale


def _bic_beside(item: Candidate, real: Candidate) -> float:
    """By how much an effect is ahead of one that is real, both with that one's noise."""
    assert real.evidence is not None
    base = real.evidence.base.solution
    gain = _gain_beside(item, real)
    return _delta_bic(gain, item.rank, item.trials, item.size_arcsec, base) - real.delta_bic


def _may_come_before(item: Candidate, real: Candidate) -> bool:
    """It is not far behind, or takes more: then it may be the larger effect around the other."""
    return _bic_beside(item, real) > -FAR_BEHIND or _gain_beside(item, real) > real.gain


def _same_noise(result: Diagnosis, real: Candidate) -> None:
    """What was not weighed for itself is compared with the noise of the one that is real."""
    assert real.evidence is not None
    base = real.evidence.base
    for item in (*result.candidates, *result.parts):
        if item.evidence is not None:
            continue
        score = base.score(item.effect, item.nonlinear)
        gain = _gain_beside(item, real)
        if gain > item.gain:
            item.gain, item.rank = gain, score.rank
            item.solution = base.solution_with(item.effect, item.nonlinear, score)
            item.delta_bic = _delta_bic(
                item.gain, item.rank, item.trials, item.size_arcsec, base.solution
            )


def _judge(
    item: Candidate, residuals: Residuals, null: float, candidates: int, progress: Progress
) -> None:
    """Evidence, and rows that the fit never saw where that is significant."""
    progress(f"the noise beside {item.name}")
    found = item.evidence = evidence(residuals, null, item.effect, item.nonlinear)
    item.gain, item.rank = found.gain, found.score.rank
    item.solution = found.base.solution_with(item.effect, item.nonlinear, found.score)
    item.size_arcsec = sizes_arcsec(found.base.solution, item.solution)
    trials = item.trials if item.level_trials is None else item.level_trials
    item.p_corrected = corrected_p_value(item.gain, item.rank, trials, candidates, found.freedom)
    item.delta_bic = _delta_bic(
        item.gain, item.rank, item.trials, item.size_arcsec, residuals.solution
    )
    if item.p_corrected < SIGNIFICANCE and found.index_share < RUNS_ARE_THE_SAMPLE:
        progress(f"held-out rows for {item.name}")
        _hold_out(item, found)


def _hold_out(item: Candidate, found: Evidence) -> None:
    base = found.base.solution
    before, after = held_out_with(
        base.terms, item.term, base.observations, base.context, base.noise
    )
    item.held_out, item.held_out_before = after, before
    item.improvement = _falls(before, after, base)


def _falls(before: HeldOut, after: HeldOut, base: Solution) -> dict[str, Improvement]:
    """By channel."""
    found = {}
    for channel, of_rows in (("capture", base.noise.capture), ("reference", base.noise.reference)):
        if of_rows is None:
            continue
        fall = improvement(
            getattr(before, f"{channel}_arcsec"), getattr(after, f"{channel}_arcsec"), of_rows.scale
        )
        if fall is not None:
            found[channel] = fall
    return found


def _matters(item: Candidate, matters_arcsec: float) -> bool:
    return max(item.size_arcsec.values(), default=0.0) >= matters_arcsec


def _rank(result: Diagnosis) -> None:
    result.candidates.sort(key=lambda item: (-item.delta_bic, item.p_corrected))


def _decide(
    result: Diagnosis,
    residuals: Residuals,
    matters: float,
    effects: Mapping[str, type[Effect]],
) -> None:
    base = residuals.solution
    significant = [item for item in result.candidates if item.p_corrected < SIGNIFICANCE]
    result.negligible = [
        item for item in significant if not _matters(item, matters) and on_every_pass(item, base)
    ]
    seen = [
        item
        for item in significant
        if _matters(item, matters) and _holds_out(item) and on_every_pass(item, base)
    ]
    real = without_unspecific([item for item in seen if at_other_speeds(item)])
    kept = {item.name for item in (*real, *result.negligible)}
    result.excluded = frozenset(item.name for item in significant if item.name not in kept)
    # Only the first was checked. Its p has paid for all places: no ΔBIC above 0 is asked for as
    # well, which would charge for them twice.
    parts = [
        item
        for item in result.parts[:1]
        if item.p_corrected < SIGNIFICANCE and _matters(item, matters) and _holds_out(item)
    ]
    best = _large_enough(real)
    chosen = parts[0] if parts else None
    if chosen is not None and best is not None and _contains(best, chosen):
        # More than the product, and all of it: a polygon's faces beside one of their orders.
        chosen = None
    ahead = np.inf if chosen is None or best is None else chosen.delta_bic - best.delta_bic
    if chosen is not None and ahead > PARTS_ADVANTAGE:
        result.verdict = "unknown"
        _describe(result, chosen)
        product: ProductOfParts = chosen.effect  # type: ignore[assignment]
        known = result.observations.has_temperature
        _suggest(result, measurement_for_parts(product, temperature_known=known))
        return
    if best is None and seen:
        result.verdict = "ambiguous"
        result.unconfirmed = "it shows at one of several speeds only, and would show at all"
        result.effect_class = [seen[0].name]
        result.candidates.remove(seen[0])
        result.candidates.insert(0, seen[0])
        _suggest(result, AT_ONE_SPEED)
        return
    if best is None:
        if _leaves_too_much(result, matters):
            result.verdict = "unknown"
        return
    # The named one stands first, whatever negligible ones fit as well.
    result.candidates.remove(best)
    result.candidates.insert(0, best)
    by_name = {item.name: item for item in result.candidates}
    similar = alike(best, result.candidates[1:])
    result.effect_class = [best.name, *similar.all_names]
    result.class_correlation = {
        name: float(
            np.max(canonical_correlations(residuals, best.term, by_name[name].term), initial=0.0)
        )
        for name in similar.all_names
    }
    stranger = chosen if chosen is not None and stands_in(best, chosen) else None
    if stranger is not None and any(_same(by_name[name], stranger) for name in result.effect_class):
        stranger = None
    near_tie = stranger is not None and ahead > -NEAR_TIE
    if best.lacking_variety or similar.equals or near_tie:
        result.verdict = "ambiguous"
        if stranger is not None:
            _describe(result, stranger)
        rivals = [by_name[name] for name in similar.equals]
        if stranger is not None and (near_tie or not rivals):
            rivals.append(stranger)
        found = next_measurement(best, rivals or [by_name[name] for name in similar.larger])
        if found.kind is None and best.lacking_variety:
            found = measurement_for_variety(best)
        if best.lacking_variety:
            result.unconfirmed = f"it needs {'; '.join(best.lacking_variety)}"
        _suggest(result, found)
        return
    if not best.effect.unspecific:
        result.look_alikes = look_alikes(best, residuals, result.untestable, effects)
    if result.look_alikes:
        result.verdict = "ambiguous"
        result.effect_class += list(result.look_alikes)
        lacking = sorted({what for items in result.look_alikes.values() for what in items})
        names = ", ".join(result.look_alikes)
        result.unconfirmed = (
            f"{names} would look the same on the rows there are, and cannot be tested: the set "
            f"lacks {'; '.join(lacking)}"
        )
        _suggest(result, NextMeasurement(f"a set that has {'; '.join(lacking)}", None))
        return
    result.verdict = "named"
    result.named = best
    if similar.larger:
        _suggest(result, next_measurement(best, [by_name[name] for name in similar.larger]))


def _look_beside(result: Diagnosis, candidates: int, matters_arcsec: float) -> None:
    """What is left once the effect that was found is in the model, at the level of a name.

    Candidates that only took a part of it add nothing then, and are not spoken of.
    """
    found = result.described
    if result.effect_class:
        found = result.candidates[0]
    if found is None:
        return
    # A line beside its place would leave a rest for others.
    found.solution = refined(found.solution)
    left = Residuals(found.solution)
    null = restricted_likelihood(left)

    def adds_more(item: Candidate) -> bool:
        score = left.score(item.effect, item.nonlinear)
        p_value = corrected_p_value(score.gain, score.rank, item.trials, candidates)
        if item is found or p_value > NEAR_P:
            return False
        further = evidence(left, null, item.effect, item.nonlinear)
        p_value = corrected_p_value(
            further.gain, further.score.rank, item.trials, candidates, further.freedom
        )
        return p_value < SIGNIFICANCE

    result.negligible = [item for item in result.negligible if adds_more(item)]
    if result.verdict != "named":
        return
    result.beside = [
        item
        for item in result.candidates
        if _matters(item, matters_arcsec) and adds_more(item) and _confirmed_beside(item, left)
    ]


def _confirmed_beside(item: Candidate, left: Residuals) -> bool:
    """Rows that were left out show it too, beside what was found."""
    base = left.solution
    before, after = held_out_with(
        base.terms, item.term, base.observations, base.context, base.noise
    )
    return holds_out(_falls(before, after, base).values())


def _same(best: Candidate, product: Candidate) -> bool:
    """The product is the effect itself in other words, and not only on this poor set."""
    if best.effect.unspecific and product.effect.parts[0].startswith("order:"):  # type: ignore[attr-defined]
        return True
    alike_here = product.rank == best.rank and abs(product.gain / best.gain - 1.0) < SAME_GAIN
    return alike_here and not best.lacking_variety


def _contains(best: Candidate, product: Candidate) -> bool:
    return stands_in(product, best) and adds(best, product)


def _large_enough(real: Sequence[Candidate]) -> Candidate | None:
    """The first of ``real``, or a larger one around it that adds what is more than chance."""
    if not real:
        return None
    best, rest = real[0], list(real[1:])
    while rest:
        larger = [item for item in rest if item.rank > best.rank and stands_in(best, item)]
        found = next((item for item in larger if adds(item, best)), None)
        if found is None:
            break
        best = found
        rest.remove(found)
    return best


def _describe(result: Diagnosis, product: Candidate) -> None:
    result.described = product
    result.description = product.effect.describe(product.parameters())  # type: ignore[attr-defined]


def _suggest(result: Diagnosis, found: NextMeasurement) -> None:
    result.next_measurement, result.next_measurement_kind = found.words, found.kind


def _leaves_too_much(result: Diagnosis, matters_arcsec: float) -> bool:
    """A lack of fit that matters, and nothing that describes it."""
    for channel, p_value in result.lack_of_fit.items():
        noise, left = result.noise_arcsec[channel], result.residual_rms_arcsec[channel]
        excess = float(np.sqrt(max(left**2 - noise**2, 0.0)))
        if p_value < LACK_OF_FIT and excess > max(matters_arcsec, LEAST_EXCESS * noise):
            return True
    return False


def _holds_out(item: Candidate) -> bool:
    """The error on held-out rows falls by more than two standard errors.

    What is known from run to run only is free in every run's offset, so that rows of the same run
    cannot show it; there the runs are the sample, and the index's scatter among them decides.
    """
    if item.evidence is not None and item.evidence.index_share >= RUNS_ARE_THE_SAMPLE:
        return True
    return bool(item.improvement) and holds_out(item.improvement.values())
