"""Tests that a log of several turns, whose error may repeat in each turn or only at the same angle
of travel, has a p for the choice between the two."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.inference.visits_of_places import visits_of
from arctrue.workbench.noise.fit import white_noise
from arctrue.workbench.observations.build import observations_of

STATIONS, TURNS, DRAWS = 24, 3, 150


def test_p_of_the_better_of_two_cases_is_that_of_chance() -> None:
    """In white noise, p < 0.3 occurs in 30 % of the draws, with a standard deviation of 3.7 %; the
    bound is three of them above 30 %. The smaller of two independent p is below 0.3 in 51 %."""
    random = np.random.default_rng(51)
    up = np.arange(STATIONS * TURNS) * (360.0 / STATIONS)
    target = np.concatenate([up, up[::-1]])
    reference = Reference(
        target_deg=target,
        error_arcsec=random.normal(size=target.size),
        time_s=10.0 * np.arange(target.size),
        run=np.zeros(target.size, dtype=np.int64),
        direction=np.repeat([1, -1], up.size),
    )
    observations = observations_of(MeasurementSet(Table(), None, reference))
    base = [Term(built_in()["graduation_harmonics"](orders=[1, 2]), {})]
    solution = fit(base, observations, noise=white_noise(observations, (0.0, 1.0)))
    rows = observations.reference
    assert rows is not None
    p_values = []
    for _ in range(DRAWS):
        # The test removes the model's columns from each pass, so that no fit is needed.
        drawn = replace(rows, error_arcsec=random.normal(size=target.size))
        visits = visits_of(replace(solution, observations=replace(observations, reference=drawn)))
        assert visits is not None
        p_values.append(visits.by_place.p)
    assert np.mean(np.array(p_values) < 0.3) <= 0.3 + 3.0 * 0.037
