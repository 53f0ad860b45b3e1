"""Tests of single rules on constructed surveys (the tests of all effects on one set), and of the
evidence for a family of coefficients."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.stats import multivariate_normal

import arctrue.workbench
from arctrue.workbench.diagnose import next_measurement
from arctrue.workbench.diagnose.case import AGAIN, Case
from arctrue.workbench.diagnose.classes import OF_THE_SAME_KIND, family_gain
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.posterior import PARTS_ADVANTAGE
from arctrue.workbench.diagnose.rivals import REFUSED_P
from arctrue.workbench.diagnose.rules.instead_of_an_effect import (
    refused_is_ahead,
    shown_at_one_speed,
)
from arctrue.workbench.diagnose.rules.leaves_more import comes_again_and_again, leaves_its_own_kind
from arctrue.workbench.diagnose.rules.table import rule_table, said_of
from arctrue.workbench.diagnose.survey import FitOfChannel
from arctrue.workbench.effects.registry import catalogue

WORKBENCH = Path(arctrue.workbench.__file__).parent


def _item(name: str, gain: float, *, p: float = 1e-12, real: bool = True, step: bool = False):  # type: ignore[no-untyped-def]
    """Return a candidate with the properties that the rules use; with ``real`` the held-out rows
    and all passes confirm it."""
    effect = SimpleNamespace(
        unspecific=False,
        search_kind=None,
        step_at=("run", "instant") if step else None,
        moves_axis=False,
    )
    return SimpleNamespace(
        name=name, gain=gain, delta_bic=gain, p_corrected=p, rank=1, evidence=object(), real=real,
        regular=None,
        moved_arcsec={"capture": gain**0.5},
        effect=effect, solution=SimpleNamespace(observations=SimpleNamespace(capture=None)),
    )  # fmt: skip


def _case(*items, further: Decision | None = None) -> Case:  # type: ignore[no-untyped-def]
    survey = SimpleNamespace(
        significant=lambda: list(items),
        matters=lambda item: True,
        confirmed=lambda item: item.real,
        is_the_reversal=lambda item: False,
        objection=lambda item: None,
        parts=[],
    )
    case = Case(survey, {}, lambda before, item: survey, said_of)  # type: ignore[arg-type]
    case.__dict__["further"] = further
    return case


def test_no_rule_knows_an_effect_by_its_name() -> None:
    """Rules use only properties that effects declare, never a name; a user's own effect can
    therefore declare them too."""
    names = set(catalogue())
    found = [
        f"{file.name}:{node.lineno} {node.value}"
        for part in ("compare", "diagnose", "inference", "noise", "observations")
        for file in (WORKBENCH / part).rglob("*.py")
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8")))
        if isinstance(node, ast.Constant) and node.value in names
    ]
    assert found == []


@pytest.mark.parametrize(("fixed", "kind"), [(False, "polygon_reindexed"), (True, None)])
def test_an_own_effect_of_the_polygon_is_separated_by_putting_it_on_again(
    monkeypatch: pytest.MonkeyPatch, fixed: bool, kind: str | None
) -> None:
    def item(name: str, fixed: bool):  # type: ignore[no-untyped-def]
        effect = SimpleNamespace(next_measurement="more", fixed_to_polygon=fixed)
        few = SimpleNamespace(observations=SimpleNamespace(rows=10))
        return SimpleNamespace(name=name, effect=effect, solution=few)

    monkeypatch.setattr(next_measurement, "PLANS", ())
    best, rival = item("my_polygon", True), item("my_drift", fixed)
    assert next_measurement.next_measurement(best, [rival]).kind == kind


def test_what_fits_best_and_is_refused_leaves_no_adequate_model() -> None:
    found = refused_is_ahead(_case(_item("count_slip", 150.0, real=False)))
    assert found is not None
    assert found.verdict == "unknown"
    assert found.resembles is not None
    assert found.resembles.name == "count_slip"
    assert found.unlike


@pytest.mark.parametrize(
    "item",
    [
        _item("count_slip", 150.0, real=True),
        _item("count_slip", 150.0, real=False, p=2.0 * REFUSED_P),
        _item("count_slip", PARTS_ADVANTAGE - 1.0, real=False),
    ],
)
def test_what_is_real_or_faint_is_not_spoken_of_as_refused(item) -> None:  # type: ignore[no-untyped-def]
    assert refused_is_ahead(_case(item)) is None


def test_what_is_refused_and_not_ahead_leaves_the_name_to_the_other() -> None:
    real, refused = _item("hysteresis", 145.0), _item("count_slip", 150.0, real=False)
    assert refused_is_ahead(_case(refused, real)) is None


def test_one_speed_is_no_reason_where_something_refused_is_far_ahead() -> None:
    """The rule "one speed" does not apply if a refused effect is far ahead: at one of several
    speeds, a line absorbs a part of the error that a loose head causes in one run."""
    line = _item("vibration", 130.0)
    for gain, said in ((420.0, None), (135.0, "ambiguous")):
        case = _case(_item("count_slip", gain, real=False), line)
        case.__dict__["at_every_speed"] = case.__dict__["real"] = []
        found = shown_at_one_speed(case)
        assert (None if found is None else found.verdict) == said
    case = _case(_item("count_slip", 420.0, real=False), line)
    case.__dict__["at_every_speed"] = case.__dict__["real"] = []
    unknown = refused_is_ahead(case)
    assert unknown is not None
    assert unknown.resembles is not None
    assert unknown.resembles.name == "count_slip"


def _unknown(gain: float) -> Decision:
    return Decision("unknown", resembles=_item("bearing_ball_pass", gain))  # type: ignore[arg-type]


def test_an_unknown_of_about_its_size_takes_the_name() -> None:
    best = _item("polygon_face_error", 100.0)
    large, small = (share * OF_THE_SAME_KIND * 100.0 for share in (1.5, 0.5))
    found = leaves_its_own_kind(_case(best, further=_unknown(large)))
    assert found is not None
    assert found.resembles is best
    assert leaves_its_own_kind(_case(best, further=_unknown(small))) is None
    # The rule also holds if the further answer names a second effect.
    second = Decision("named", first=best, further=_unknown(large))  # type: ignore[arg-type]
    assert leaves_its_own_kind(_case(best, further=second)) is not None
    assert leaves_its_own_kind(_case(best, further=Decision("adequate"))) is None


@pytest.mark.parametrize(("after_arcsec", "taken"), [(0.2, False), (0.4, True)])
def test_what_nothing_describes_takes_the_name_by_its_size(
    after_arcsec: float, taken: bool
) -> None:
    """A remaining error that nothing describes prevents the name if it is large enough. The
    reference had an error of 1″. The remaining 0.2″ are 4 % of the removed variance, and 0.4″ are
    19 %."""
    best = _item("hysteresis", 900.0)
    best.moved_arcsec = {"capture": 0.0, "reference": 1.0}
    # The rows themselves show the effect; the effect is not visible only in the offsets of the
    # runs.
    best.evidence = None
    case = _case(best, further=Decision("unknown", undescribed_arcsec={"reference": after_arcsec}))
    fit = FitOfChannel(float(np.hypot(1.0, 0.1)), 0.1, None)
    case.survey.__dict__["channels"] = {"reference": fit}
    assert (leaves_its_own_kind(case) is not None) is taken


def _again(*events) -> bool:  # type: ignore[no-untyped-def]
    """Tell whether the answer says that the event recurs. When one of ``events`` is in the model,
    the residual still contains the next one."""
    following = iter([*events[1:], None])

    def with_first(before: object, _: object) -> object:
        item = next(following)
        return _case(*([] if item is None else [item])).survey

    case = replace(_case(events[0]), with_first=with_first)  # type: ignore[arg-type]
    return comes_again_and_again(case) is not None


def test_an_event_that_comes_again_and_again_is_no_accident() -> None:
    def slips(*gains: float, **how: bool | float):  # type: ignore[no-untyped-def]
        return (
            [_item("count_slip", gains[0], step=True)]
            + [
                _item("count_slip", gain, **({"step": True} | how))  # type: ignore[arg-type]
                for gain in gains[1:]
            ]
        )

    assert AGAIN == 3
    assert _again(*slips(100.0, 80.0, 60.0))
    assert not _again(*slips(100.0, 80.0))
    # Two small events after a large one do not count as a repetition. Periodic errors are no
    # events: three of them do not count as a repetition.
    assert not _again(*slips(100.0, 5.0, 5.0))
    assert not _again(*(_item("periodic_error", gain) for gain in (100.0, 80.0, 60.0)))
    # Left-out rows may fail to confirm an event if slow noise predicts them from their neighbours.
    assert _again(*slips(100.0, 80.0, 60.0, real=False))
    assert not _again(*slips(100.0, 80.0, 60.0, real=False, p=2.0 * REFUSED_P))


def test_the_page_has_the_rules_of_the_table() -> None:
    """The list in docs/workbench.md equals the list that ``rule_table`` makes from the program's
    rules."""
    page = (Path(__file__).parents[4] / "docs" / "workbench.md").read_text(encoding="utf-8")
    assert "\n".join(rule_table()) in page, "python -m scripts.make_docs writes the table anew"


def test_family_gain_is_the_largest_of_dense_gaussian_evidences() -> None:
    """The gain of a family is the largest ratio of y ~ N(0, 1 + s²·XXᵀ) to y ~ N(0, 1), for s on a
    dense grid."""
    random = np.random.default_rng(4)
    design = random.normal(size=(30, 5))
    measured = design @ random.normal(0.0, 0.6, 5) + random.normal(size=30)
    score = SimpleNamespace(information=design.T @ design, moment=design.T @ measured)
    null = multivariate_normal.logpdf(measured, cov=np.eye(30))
    expected = max(
        multivariate_normal.logpdf(measured, cov=np.eye(30) + square * design @ design.T)
        for square in np.geomspace(1e-3, 1e2, 400)
    )
    assert family_gain(score) == pytest.approx(2.0 * (expected - null), abs=1e-3)  # type: ignore[arg-type]


def test_many_equal_coefficients_are_one_family_and_one_large_one_is_none() -> None:
    """A gain that is spread over 23 columns supports the family; the same gain in one column
    supports the single effect."""
    spread = SimpleNamespace(information=np.eye(23), moment=np.full(23, np.sqrt(6.0)))
    alone = SimpleNamespace(information=np.eye(1), moment=np.array([np.sqrt(0.6 * 138.0)]))
    single = SimpleNamespace(information=np.eye(23), moment=np.r_[np.sqrt(138.0), np.zeros(22)])
    one = SimpleNamespace(information=np.eye(1), moment=np.array([np.sqrt(138.0)]))
    assert family_gain(single) < family_gain(one)  # type: ignore[arg-type]
    # The expected gain is Σ z² − 1 − log z² over 23 directions with z² = 6 each.
    assert family_gain(spread) == pytest.approx(23.0 * (5.0 - np.log(6.0)), rel=1e-3)  # type: ignore[arg-type]
    assert family_gain(alone) == pytest.approx(81.8 - np.log(82.8), rel=1e-2)  # type: ignore[arg-type]
