"""Tests which verdict follows if the values of the best effect contradict its own physics."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from arctrue.workbench.diagnose.case import Case
from arctrue.workbench.diagnose.decision import Decision
from arctrue.workbench.diagnose.rules.contradictions import contradicts_itself

WHY = "a wave of order 9 has 99 % of the variance of the face errors"


def _faces(delta_bic: float) -> SimpleNamespace:
    """Return errors of a polygon's faces that follow a wave."""
    effect = SimpleNamespace(
        contradiction=lambda *values: WHY, search=(), reversal_of_the_table=None
    )
    solution = SimpleNamespace(
        terms=[None],
        part=lambda index: slice(0, 1),
        coefficients=np.zeros(1),
        covariance=np.eye(1),
        observations=None,
    )
    at_maximum = SimpleNamespace(terms=[SimpleNamespace(nonlinear={})])
    return SimpleNamespace(
        name="polygon_face_error",
        delta_bic=delta_bic,
        effect=effect,
        solution=solution,
        at_maximum=at_maximum,
    )


@pytest.mark.parametrize(
    ("verdict", "gain", "is_stated", "named"),
    [
        ("named", 1244.0, True, True),
        ("named", 1000.0, True, False),
        ("named", 1244.0, False, False),
        ("unknown", 1244.0, True, False),
    ],
)
def test_a_cause_of_a_stated_order_that_gains_more_is_named(
    verdict: str, gain: float, is_stated: bool, named: bool
) -> None:
    """Faces that follow a wave are no cause; a gear with a stated number of teeth that explains
    more of the rows is one."""
    effect = SimpleNamespace(order_is_stated=is_stated)
    gear = SimpleNamespace(name="drive_gear_error", delta_bic=gain, effect=effect)

    def decide(case: Case) -> Decision:
        assert case.set_aside == {"polygon_face_error"}
        return Decision(verdict, first=gear if verdict == "named" else None)  # type: ignore[arg-type]

    case = Case(SimpleNamespace(), {}, lambda item: item, decide)  # type: ignore[arg-type, return-value]
    case.__dict__.update(best=_faces(1100.0), product=None)
    found = contradicts_itself(case)
    assert found is not None
    if named:
        assert found.first is gear
    else:
        assert found.verdict == "unknown"
        assert found.resembles is not None
        assert found.resembles.name == "polygon_face_error"
        assert found.unlike == WHY
