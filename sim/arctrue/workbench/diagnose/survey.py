"""Every effect and every product of parts, tried beside one model and judged by the same tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from arctrue.progress import Say
from arctrue.workbench.diagnose.candidate import Candidate, sizes_arcsec
from arctrue.workbench.diagnose.every_pass import on_every_pass
from arctrue.workbench.diagnose.evidence import (
    MUCH_MORE,
    Evidence,
    evidence,
    restricted_likelihood,
)
from arctrue.workbench.diagnose.free_in_runs import at_other_speeds
from arctrue.workbench.diagnose.heldout import (
    HeldOut,
    Improvement,
    held_out_with,
    holds_out,
    improvement,
)
from arctrue.workbench.diagnose.lack_of_fit import capture_lack_of_fit, reference_lack_of_fit
from arctrue.workbench.diagnose.noise import capture_noise_arcsec, reference_noise_arcsec
from arctrue.workbench.diagnose.parts_scan import best_parts
from arctrue.workbench.diagnose.significance import corrected_p_value
from arctrue.workbench.diagnose.taken_by_noise import may_be_taken
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import absent_effects
from arctrue.workbench.inference.canonical_correlation import canonical_correlations
from arctrue.workbench.inference.residuals import Residuals
from arctrue.workbench.inference.search import places_of
from arctrue.workbench.inference.solution import Solution
from arctrue.workbench.observations import Observations

SIGNIFICANCE = 0.01
"""Largest corrected p that names an effect: the aim is a false name on 1 % of adequate sets."""
MOVED_SHARE = 0.02
"""A channel counts when it is moved by more than this share of its noise."""
NEAR_P = 0.3
"""A first p below this is near to a name: the noise is estimated anew beside it."""
MOST_LEFT = 0.5
"""Of the variance of a channel's residual: what leaves less is weighed, however much of it the
noise of the model without it has taken."""
MOST_WEIGHED = 6
"""So many candidates at most are weighed with the noise free on both sides."""
FAR_BEHIND = 60.0
"""BIC by which a candidate that is not weighed yet cannot come before one that is real."""
FAR_TOO_SMALL = 0.5
"""Share of what matters: the noise estimated anew does not double a size."""
SAME_BLOCK = 1e-6
"""Of a gain, and of a canonical correlation: rounding of the same columns."""
OF_A_CONSTANT = 0.1
"""What changes less than this share of its mean over the rows is a constant."""
AS_GOOD = 6.0
"""BIC by which another form or place of an effect must be ahead: odds of 20 to 1."""
RUNS_ARE_THE_SAMPLE = 0.5
"""Share of the index in the variance of an effect's size."""


@dataclass
class Survey:
    """What was tried beside one model, best first, and how well that model fits by itself."""

    residuals: Residuals
    matters_arcsec: float
    """An effect that moves the prediction by less than this is negligible."""
    absent: int
    """Effects of the catalogue that the model lacks: its p pays for so many."""
    looks: int = 1
    """Surveys of this kind that a diagnosis makes: every p pays for so many."""
    candidates: list[Candidate] = field(default_factory=list)
    parts: list[Candidate] = field(default_factory=list)
    untestable: dict[str, list[str]] = field(default_factory=dict)
    noise_arcsec: dict[str, float] = field(default_factory=dict)
    residual_rms_arcsec: dict[str, float] = field(default_factory=dict)
    lack_of_fit: dict[str, float] = field(default_factory=dict)
    held_out_before: HeldOut | None = None

    @property
    def base(self) -> Solution:
        """The model beside which everything was tried."""
        return self.residuals.solution

    def significant(self) -> list[Candidate]:
        """Effects of the catalogue that pass the first test."""
        return [item for item in self.candidates if item.p_corrected < SIGNIFICANCE]

    def matters(self, item: Candidate) -> bool:
        """It moves the prediction by more than what is negligible."""
        return max(item.size_arcsec.values(), default=0.0) >= self.matters_arcsec

    def may_matter(self, item: Candidate) -> bool:
        """Its size, which changes with the noise, is not far below what matters."""
        size = max(item.size_arcsec.values(), default=0.0)
        return size >= FAR_TOO_SMALL * self.matters_arcsec

    def confirmed(self, item: Candidate) -> bool:
        """It matters, held-out rows show it, and so does every pass over its place."""
        return (
            self.matters(item)
            and _holds_out(item)
            and on_every_pass(item, self.base)
            and not self.may_be_a_constant_of_the_model(item)
        )

    def may_be_a_constant_of_the_model(self, item: Candidate) -> bool:
        """It is a constant of R₂ − R₁ that the effects of the model may have by themselves."""
        base = self.base
        most = sum(
            term.effect.constant_between_heads_arcsec(base.coefficients[base.part(index)])
            for index, term in enumerate(base.terms)
        )
        if most == 0.0 or base.observations.capture is None:
            return False
        before, after = (
            solution.capture_prediction_arcsec(False) for solution in (base, item.solution)
        )
        change = after - before
        constant = float(change.mean())
        return abs(constant) <= most and float(np.std(change)) < OF_A_CONSTANT * abs(constant)


def survey(
    residuals: Residuals,
    effects: Mapping[str, type[Effect]],
    matters_arcsec: float,
    progress: Say,
    *,
    negligible: bool = True,
    looks: int = 1,
) -> Survey:
    """Try everything beside the model of ``residuals``.

    Without ``negligible`` what is far too small to matter is not weighed: no verdict rests on it.
    An effect with a search is tried again beside itself: it may be there at another place.
    ``looks``: surveys of this kind that the diagnosis makes.
    """
    base = residuals.solution
    present = {term.effect.name for term in base.terms}
    absent = absent_effects(effects, present)
    repeatable = {
        name: effect for name, effect in effects.items() if name in present and effect.search
    }
    found = Survey(residuals, matters_arcsec, len(absent), looks)
    _judge_fit(found)
    for name, kind in [*absent.items(), *repeatable.items()]:
        effect = kind()
        lacking = effect.missing(base.observations) or _on_an_arc(effect, base.observations)
        if lacking:
            found.untestable[name] = lacking
            continue
        progress(f"trying {name}")
        candidate = _try_effect(effect, residuals, found.absent * looks)
        if candidate is not None:
            found.candidates.append(candidate)
    progress("trying products of parts")
    found.parts = _try_parts(residuals, looks)
    _weigh(found, progress, negligible=negligible)
    found.candidates.sort(key=lambda item: (-item.delta_bic, item.p_corrected))
    return found


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


def _try_effect(effect: Effect, residuals: Residuals, candidates: int) -> Candidate | None:
    observations = residuals.observations
    found = _looked_for(effect, residuals)
    if found is None:
        return None
    form, nonlinear, trials = found
    score = residuals.score(form, nonlinear)
    if score.rank == 0:
        return None
    candidate = _candidate(
        form,
        nonlinear,
        score.gain,
        score.rank,
        trials,
        residuals,
        candidates,
        form.variety(observations),
    )
    candidate.asked = effect
    return candidate


def _looked_for(
    effect: Effect, residuals: Residuals
) -> tuple[Effect, dict[str, float], float] | None:
    """The form and the place in which an effect fits best, and how many were tried."""
    form, trials = effect.narrowed(residuals)
    if not form.search:
        return form, {}, trials
    places = places_of(form, residuals)
    return (form, places[0].nonlinear, places[0].trials) if places else None


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
    rows = _rows_moved(size_arcsec, base)
    return Candidate(
        effect=effect,
        nonlinear=nonlinear,
        gain=gain,
        rank=rank,
        trials=trials,
        solution=solution,
        delta_bic=_delta_bic(gain, rank, trials, rows),
        size_arcsec=size_arcsec,
        p_corrected=corrected_p_value(gain, rank, trials, candidates),
        rows=rows,
        lacking_variety=lacking_variety,
    )


def _delta_bic(gain: float, rank: int, trials: float, rows: int) -> float:
    return float(gain - rank * np.log(rows) - 2.0 * np.log(max(trials, 1.0)))


def _rows_moved(size_arcsec: Mapping[str, float], base: Solution) -> int:
    """Rows of the channels that the effect moves: the others say nothing of it.

    A polygon's faces are known from the 480 reference rows, however long the capture. All rows
    where it moves none.
    """
    channels = (
        ("capture", base.observations.capture, base.capture_sigma_arcsec),
        ("reference", base.observations.reference, base.reference_sigma_arcsec),
    )
    moved = sum(
        rows.run.size
        for name, rows, sigma in channels
        if rows is not None
        and sigma is not None
        and size_arcsec.get(name, 0.0) > MOVED_SHARE * sigma
    )
    return moved or base.observations.rows


def _try_parts(residuals: Residuals, looks: int) -> list[Candidate]:
    found = []
    for item in best_parts(residuals):
        if item.rank == 0:
            continue
        tried = _candidate(item.effect, {}, item.gain, item.rank, item.trials, residuals, 1, [])
        tried.level_trials = item.level_trials
        tried.p_corrected = corrected_p_value(item.gain, item.rank, item.level_trials, looks)
        found.append(tried)
    return sorted(found, key=lambda item: -item.delta_bic)


def _weigh(result: Survey, progress: Say, *, negligible: bool) -> None:
    """Evidence with the noise free on both sides, for whatever may be named.

    That is the catalogue's candidates, best first, until those that follow have no chance to come
    before one that is real, and the product of parts that stands first if it has.
    """
    residuals = result.residuals
    null = restricted_likelihood(residuals)
    waiting = sorted(result.candidates, key=lambda item: -item.delta_bic)
    near = {
        item.name
        for item in waiting
        if item.p_corrected < NEAR_P
        or item.effect.step_at
        or takes_most(item.solution, residuals.solution)
    }
    others = [item for item in waiting if item.name not in near]
    taken = may_be_taken(others, residuals, result.absent * result.looks, SIGNIFICANCE)
    near |= {item.name for item in taken}
    waiting = [item for item in waiting if item.name in near]
    products = result.parts[:1]
    if not negligible:
        waiting = [item for item in waiting if result.may_matter(item)]
        products = [item for item in products if result.may_matter(item)]
    real: Candidate | None = None
    for _ in range(MOST_WEIGHED):
        if real is not None:
            beside = real
            _scored_beside(waiting, real)
            waiting = [item for item in waiting if _may_come_before(item, beside)]
        if not waiting:
            break
        item = waiting.pop(0)
        _judge(item, result, null, result.absent, progress)
        if (
            item.p_corrected < SIGNIFICANCE
            and result.confirmed(item)
            and at_other_speeds(item)
            and (real is None or item.delta_bic > real.delta_bic)
        ):
            real = item
            beside = real
            _scored_beside(waiting, real)
            waiting.sort(key=lambda item: -_bic_beside(item, beside))
    for item in products:
        ahead = real is None or _bic_beside(item, real) > -FAR_BEHIND
        if item.p_corrected >= NEAR_P or not ahead:
            continue
        if real is not None and _same_columns(item, real):
            _judge_like(item, real, result)
        else:
            _judge(item, result, null, 1, progress)
    if real is not None:
        _same_noise(result, real)
    result.held_out_before = next(
        (item.held_out_before for item in waiting if item.held_out_before is not None), None
    )


def takes_most(grown: Solution, base: Solution) -> bool:
    """With the effect in the model, less than half of a channel's residual variance is left.

    A slow effect far above the scatter of the rows is taken for slow noise where it is not in the
    model, whole, so that its gain with that noise says nothing.
    """
    for after, before in (
        (grown.capture_residual_arcsec(), base.capture_residual_arcsec()),
        (grown.reference_residual_arcsec(), base.reference_residual_arcsec()),
    ):
        if after is None or before is None:
            continue
        if float(np.mean(after**2)) < MOST_LEFT * float(np.mean(before**2)):
            return True
    return False


def _scored_beside(items: list[Candidate], real: Candidate) -> None:
    """All of them at once, for :func:`_gain_beside`."""
    assert real.evidence is not None
    real.evidence.base.scores([(item.effect, item.nonlinear) for item in items])


def _gain_beside(item: Candidate, real: Candidate) -> float:
    """Gain with the noise of one that is real, on the scale of that one's likelihoods."""
    assert real.evidence is not None
    scale = real.gain / max(real.evidence.score.gain, 1e-300)
    return real.evidence.base.score(item.effect, item.nonlinear).gain * scale


def _bic_beside(item: Candidate, real: Candidate) -> float:
    """By how much an effect is ahead of one that is real, both with that one's noise."""
    assert real.evidence is not None
    rows = _rows_moved(item.size_arcsec, real.evidence.base.solution)
    gain = _gain_beside(item, real)
    return _delta_bic(gain, item.rank, item.trials, rows) - real.delta_bic


def _may_come_before(item: Candidate, real: Candidate) -> bool:
    """It is not far behind, or takes more: then it may be the larger effect around the other."""
    return _bic_beside(item, real) > -FAR_BEHIND or _gain_beside(item, real) > real.gain


def _same_noise(result: Survey, real: Candidate) -> None:
    """What was not weighed for itself is compared with the noise of the one that is real."""
    assert real.evidence is not None
    base = real.evidence.base
    others = [item for item in (*result.candidates, *result.parts) if item.evidence is None]
    base.scores([(item.effect, item.nonlinear) for item in others])
    for item in others:
        score = base.score(item.effect, item.nonlinear)
        gain = _gain_beside(item, real)
        if gain > item.gain:
            item.gain, item.rank = gain, score.rank
            item.solution = base.solution_with(item.effect, item.nonlinear, score)
            item.rows = _rows_moved(item.size_arcsec, base.solution)
            item.delta_bic = _delta_bic(item.gain, item.rank, item.trials, item.rows)


def _judge(item: Candidate, result: Survey, null: float, candidates: int, progress: Say) -> None:
    """Evidence, and rows that the fit never saw where that is significant and matters."""
    residuals = result.residuals
    progress(f"the noise beside {item.name}")
    found = evidence(residuals, null, item.effect, item.nonlinear)
    if found.score.gain > MUCH_MORE * residuals.score(item.effect, item.nonlinear).gain:
        found = _in_less_noise(item, found, residuals, null)
    _settle(item, found, result, candidates)
    of_rows = found.index_share < RUNS_ARE_THE_SAMPLE
    if item.p_corrected < SIGNIFICANCE and result.matters(item) and of_rows:
        progress(f"held-out rows for {item.name}")
        _hold_out(item, found)


def _in_less_noise(item: Candidate, found: Evidence, residuals: Residuals, null: float) -> Evidence:
    """The evidence of the form and the place that fit best with the noise beside the effect.

    Without it the noise holds the effect itself, and hides what is smaller: the lines beside a
    gear's tooth count, or by how little an order is not whole.
    """
    best = None if item.asked is None else _looked_for(item.asked, found.base)
    if best is None:
        return found
    form, nonlinear, trials = best
    score, base = found.base.score(form, nonlinear), residuals.solution

    def worth(gain: float, rank: int, places: float) -> float:
        return _delta_bic(gain, rank, places, _rows_moved(item.size_arcsec, base))

    before = worth(found.score.gain, found.score.rank, item.trials)
    if worth(score.gain, score.rank, trials) < before + AS_GOOD:
        return found
    anew = evidence(residuals, null, form, nonlinear)
    before = worth(found.gain, found.score.rank, item.trials)
    if worth(anew.gain, anew.score.rank, trials) < before + AS_GOOD:
        return found
    item.effect, item.nonlinear, item.trials = form, nonlinear, trials
    return anew


def _same_columns(item: Candidate, real: Candidate) -> bool:
    """Both are the same block in other words: a warm centre, and order 1 times the temperature."""
    assert real.evidence is not None
    if real.effect.search or item.rank != real.rank:
        return False
    base = real.evidence.base
    gain = base.score(item.effect, item.nonlinear).gain
    if abs(gain - real.evidence.score.gain) > SAME_BLOCK * real.evidence.score.gain:
        return False
    correlations = canonical_correlations(base, item.term, real.term)
    return bool(correlations.size == item.rank and correlations[-1] > 1.0 - SAME_BLOCK)


def _judge_like(item: Candidate, real: Candidate, result: Survey) -> None:
    """By the evidence and the held-out rows of one with the same columns."""
    assert real.evidence is not None
    score = real.evidence.base.score(item.effect, item.nonlinear)
    _settle(item, replace(real.evidence, score=score), result, 1)
    item.held_out, item.held_out_before = real.held_out, real.held_out_before
    item.improvement = real.improvement


def _settle(item: Candidate, found: Evidence, result: Survey, candidates: int) -> None:
    """What its evidence says of a candidate."""
    item.evidence = found
    item.gain, item.rank = found.gain, found.score.rank
    item.solution = found.base.solution_with(item.effect, item.nonlinear, found.score)
    item.size_arcsec = sizes_arcsec(found.base.solution, item.solution)
    trials = item.trials if item.level_trials is None else item.level_trials
    item.p_corrected = corrected_p_value(
        item.gain, item.rank, trials, candidates * result.looks, found.freedom
    )
    item.rows = _rows_moved(item.size_arcsec, result.base)
    item.delta_bic = _delta_bic(item.gain, item.rank, item.trials, item.rows)


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


def _holds_out(item: Candidate) -> bool:
    """The error on held-out rows falls by more than two standard errors.

    What is known from run to run only is free in every run's offset, so that rows of the same run
    cannot show it; there the runs are the sample, and the index's scatter among them decides.
    """
    if item.evidence is not None and item.evidence.index_share >= RUNS_ARE_THE_SAMPLE:
        return True
    return bool(item.improvement) and holds_out(item.improvement.values())


def _judge_fit(result: Survey) -> None:
    residuals, observations = result.residuals, result.base.observations
    for channel, values, noise, lack in (
        ("capture", residuals.capture_arcsec, capture_noise_arcsec, capture_lack_of_fit),
        ("reference", residuals.reference_arcsec, reference_noise_arcsec, reference_lack_of_fit),
    ):
        if values is None:
            continue
        result.noise_arcsec[channel] = noise(observations, values)
        result.residual_rms_arcsec[channel] = float(np.sqrt(np.mean(values**2)))
        p_value = lack(residuals)
        if p_value is not None:
            result.lack_of_fit[channel] = p_value
