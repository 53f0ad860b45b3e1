"""Tests that an effect declares which of its parameters are amplitudes and phases."""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.workbench.effects.parameter import (
    Kind,
    Parameter,
    amplitude_and_phase,
    kind_of,
    phases_among,
)


def test_amplitude_and_phase_declare_their_kinds() -> None:
    found = amplitude_and_phase(1.0, 2.0, np.eye(2), "order_2_")
    assert {name: item.kind for name, item in found.items()} == {
        "order_2_amplitude": "amplitude",
        "order_2_phase": "phase",
    }
    assert phases_among(found) == {"order_2_phase"}


@pytest.mark.parametrize(
    ("name", "unit", "kind"),
    [
        ("belt_amplitude", "arcsec", "amplitude"),
        ("belt_phase", "deg", "phase"),
        ("belt_phase", "1", "value"),
        ("size", "arcsec", "value"),
    ],
)
def test_the_name_states_the_kind_that_an_own_effect_does_not_declare(
    name: str, unit: str, kind: Kind
) -> None:
    assert kind_of(name, Parameter(1.0, 0.1, unit)) == kind


def test_a_declared_kind_goes_before_the_name() -> None:
    assert kind_of("amplitude", Parameter(-1.5, 0.1, "arcsec", "value")) == "value"
