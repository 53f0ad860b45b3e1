"""Tests the readings of the heads of a table with three or four heads, and simulated sets with
these heads."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.calibration import whole_turns
from arctrue.calibration.heads_data import HeadsSettings
from arctrue.calibration.heads_least_squares import heads_least_squares
from arctrue.studies.simulate.experiment import EXPERIMENTS, full
from arctrue.studies.simulate.simulated_set import Wanted, simulate_set
from arctrue.table import DISC_RADIUS_M, HEAD_PLACES_DEG, RotaryTable, TableState, heads_at
from arctrue.table.causes.lost_counts import LostCounts
from arctrue.table.causes.radial_motion import RadialMotion
from arctrue.table.declaration import Occasion
from arctrue.table.registry import REGISTRY

PLACES = np.deg2rad(HEAD_PLACES_DEG[4])
SECOND_ORDER = 2.0
"""Factor on the bound for the terms (shift/R)², which the formula for a small shift neglects."""


def test_every_head_sees_the_axis_by_its_own_place_and_radius() -> None:
    radii = DISC_RADIUS_M + np.array([0.0, 1e-4, -1e-4, 0.5e-4])
    shift = 3e-6 - 2e-6j
    angle = np.linspace(0.0, 6.0, 40)
    table = RotaryTable(
        heads_at(PLACES.tolist(), radii.tolist()), (RadialMotion(2, shift, 0.5 * shift),)
    )
    moved = shift * np.exp(2j * angle) + 0.5 * shift * np.exp(-2j * angle)
    for head, (place, radius) in enumerate(zip(PLACES, radii, strict=True)):
        seen = table.reading_rad(head, TableState.at_rest(angle)) - angle
        # A head at the place p counts from its own index mark. Its reading is therefore larger by
        # p, plus or minus whole turns.
        seen -= 2.0 * np.pi * np.round((seen - place) / (2.0 * np.pi)) + place
        expected = np.imag(moved * np.exp(1j * place)) / radius
        assert np.max(np.abs(seen - expected)) < SECOND_ORDER * (abs(1.5 * shift) / radius) ** 2


def test_a_cause_on_a_head_that_is_not_there_is_refused() -> None:
    lost = LostCounts(2, 0, 1.0, 4)
    RotaryTable(heads_at(PLACES.tolist()), (lost,))
    with pytest.raises(ValueError, match="acts on head 3, the table has 2"):
        RotaryTable(heads_at(PLACES[:2].tolist()), (lost,))


@pytest.mark.parametrize("heads", [3, 4])
def test_a_simulated_set_is_calibrated_to_the_table_it_came_from(heads: int) -> None:
    made = simulate_set([], EXPERIMENTS["lean"](), 5, heads=heads)
    capture, table = made.measurement.capture, made.measurement.table
    assert capture is not None
    assert table.places_deg == HEAD_PLACES_DEG[heads]
    turns = whole_turns(capture, 1 << 24, most_order=12)
    found = heads_least_squares(
        turns,
        1 << 24,
        np.deg2rad(table.places_deg).tolist(),
        HeadsSettings(np.arange(1, 13), u_index_arcsec=1e-3, u_radius=0.0),
    )
    angle = np.linspace(0.0, 6.28, 500)
    reading = made.table.reading_rad(0, TableState.at_rest(angle))
    left = (reading - angle) * 206265.0 - found.on_disc().under_head(0, reading)
    # The fit of 24 coefficients, with gains below 1.3 and 0.1″ of noise, has an uncertainty of
    # 0.005″ with the 18,000 samples of one head alone. The test allows four times this.
    assert np.std(left) < 4 * 1.3 * 0.1 * np.sqrt(24 / 18_000)


OF_ONE_HEAD = (
    "head_angle_error",
    "subdivision_error",
    "vibration",
    "timing_skew",
    "thermal_head_drift",
    "count_slip",
    "settling_bracket",
    "sticking_bracket",
    "loosening_head",
    "leaning_bracket",
)


@pytest.mark.parametrize("name", OF_ONE_HEAD)
def test_a_fault_of_one_head_is_drawn_at_each_of_four_heads(name: str) -> None:
    heads = heads_at([0.0, 0.6, 2.7, 5.2])
    occasion = replace(full().occasion, heads=heads)
    found = set()
    for seed in range(40):
        (cause,) = REGISTRY[name].draw(1.0, np.random.default_rng(seed), occasion)
        head = cause.head  # type: ignore[attr-defined]
        assert getattr(cause, "at", heads[head]) == heads[head]
        found.add(head)
    assert found == {0, 1, 2, 3}


def test_a_radial_motion_of_order_1_is_drawn_for_more_than_two_heads() -> None:
    two, four = full().occasion, replace(full().occasion, heads=heads_at(PLACES.tolist()))

    def orders(occasion: Occasion) -> set[int]:
        draws = [
            REGISTRY["radial_error_motion"].draw(1.0, np.random.default_rng(seed), occasion)
            for seed in range(100)
        ]
        return {cause.order for (cause,) in draws if isinstance(cause, RadialMotion)}

    assert orders(two) == set(range(2, 9))
    assert orders(four) == set(range(1, 9))


def test_exact_signal_of_four_heads_is_that_of_their_readings() -> None:
    places = (0.0, 30.0, 158.25, 305.5)
    made = simulate_set(
        [Wanted("radial_error_motion", 1.0)],
        full().smaller(300, 2),
        4,
        noise_arcsec=0.0,
        index_scatter_counts=0,
        head_places_deg=places,
    )
    capture = made.measurement.capture
    assert capture is not None
    assert made.measurement.table.head_places_deg == places
    off = np.stack(capture.heads) * (1_296_000 / (1 << 24))
    off -= np.array(places)[:, None] * 3600
    # The three combinations of docs/workbench-heads.md.
    seen = np.concatenate(
        [
            off[1] - off[0],
            np.sqrt(4 / 3) * (off[2] - (off[0] + off[1]) / 2),
            np.sqrt(3 / 2) * (off[3] - (off[0] + off[1] + off[2]) / 3),
        ]
    )
    # Rounding down changes each reading by 0 to 1 count, and a contrast by at most √2 counts.
    bound = np.sqrt(2.0) * 1_296_000 / (1 << 24)
    assert np.max(np.abs(seen - made.exact_arcsec["capture"])) < bound


def test_two_heads_are_drawn_as_they_were() -> None:
    two = simulate_set([Wanted("count_slip", 8.0)], EXPERIMENTS["lean"](), 3)
    assert two.measurement.capture is not None
    assert len(two.measurement.capture.heads) == 2
    assert two.measurement.table.head_places_deg is None
    assert "heads" not in two.truth
    # The program computed the expected counts, with this seed, before it had tables with further
    # heads.
    assert two.measurement.capture.head2_counts[[0, 9_000, -1]].tolist() == [
        2472221, 27635524, 52801067
    ]  # fmt: skip
