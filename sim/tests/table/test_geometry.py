"""Tests of the directions from the disc's centre to the heads against triangles, a series
expansion, and the sign convention."""

import numpy as np
import pytest

from arctrue.table import (
    DISC_RADIUS_M,
    HEAD_SEPARATION_RAD,
    Cause,
    DiscEccentricity,
    GraduationHarmonics,
    Head,
    RotaryTable,
    TableState,
    two_heads,
)
from arctrue.table.causes.graduation_bump import GraduationBump

ANGLES = np.linspace(-7.0, 11.0, 5003)
STATE = TableState.at_rest(ANGLES)
ARCSEC = np.deg2rad(1 / 3600)


def eccentric(offset_m: float, direction_rad: float = 0.7) -> RotaryTable:
    return RotaryTable(two_heads(), (DiscEccentricity(offset_m, direction_rad),))


@pytest.mark.parametrize("offset_m", [1e-6, 40e-6, 5e-3])
def test_eccentric_reading_follows_the_law_of_sines(offset_m: float) -> None:
    # The triangle of axis, disc centre and head has two known sides and a known angle at the axis,
    # which give the angle at the head. The directions from the disc centre and from the axis differ
    # by this angle.
    table = eccentric(offset_m)
    for head, stator in ((0, 0.0), (1, -HEAD_SEPARATION_RAD)):
        at_axis = ANGLES + 0.7 - stator
        to_centre = np.sqrt(
            offset_m**2 + DISC_RADIUS_M**2 - 2 * offset_m * DISC_RADIUS_M * np.cos(at_axis)
        )
        expected = ANGLES - stator + np.arcsin(offset_m * np.sin(at_axis) / to_centre)
        np.testing.assert_allclose(table.reading_rad(head, STATE), expected, rtol=0, atol=1e-12)


@pytest.mark.parametrize("offset_m", [4e-6, 40e-6, 400e-6])
def test_small_angle_formula_holds_to_its_own_order(offset_m: float) -> None:
    ratio = offset_m / DISC_RADIUS_M
    error = eccentric(offset_m).reading_rad(0, STATE) - ANGLES
    missing = np.abs(error - ratio * np.sin(ANGLES + 0.7)).max()
    # The next term of the series is (e/R)²/2·sin 2x. The error of the formula must contain this
    # term and nothing larger.
    assert missing == pytest.approx(ratio**2 / 2, rel=2 * ratio + 1e-4)


def test_a_line_of_the_disc_passes_head_2_first_while_the_readings_rise() -> None:
    """Head 2 reads a place of the disc that is α ahead, as docs/architecture.md, "Head geometry",
    states; the mean separation also shows this order."""
    theta = np.linspace(-1.0, 1.0, 20_001)
    table = RotaryTable(two_heads(), (GraduationBump(50 * ARCSEC, 0.2, 0.01),))
    plain = RotaryTable(two_heads())
    state = TableState.at_rest(theta)
    seen = [
        theta[np.argmax(table.reading_rad(head, state) - plain.reading_rad(head, state))]
        for head in (0, 1)
    ]
    assert seen[0] == pytest.approx(0.2, abs=1e-3)
    assert seen[1] == pytest.approx(0.2 - HEAD_SEPARATION_RAD, abs=1e-3)
    apart = plain.reading_rad(1, state) - plain.reading_rad(0, state)
    np.testing.assert_allclose(apart, HEAD_SEPARATION_RAD, rtol=0, atol=1e-12)


def test_second_order_is_the_known_one() -> None:
    # For 30 µm the second-order term a²/2 with a = e/R, see "(8)" in docs/errata.md, is 0.032″.
    ratio = 30e-6 / DISC_RADIUS_M
    turn = np.arange(4096) * (2 * np.pi / 4096)
    table = eccentric(30e-6, 0.0)
    error = table.reading_rad(0, TableState.at_rest(turn)) - turn
    second = 2 * np.mean(error * np.sin(2 * turn)) / ARCSEC
    assert second == pytest.approx(ratio**2 / 2 / ARCSEC, rel=1e-4)


def test_both_heads_see_one_error_function_alpha_apart() -> None:
    # From R₁ = θ + ε(θ) and R₂ = θ + α + ε(θ + α) follows R₂(θ) = R₁(θ + α).
    table = RotaryTable(
        two_heads(),
        (
            DiscEccentricity(40e-6, 2.0),
            GraduationHarmonics((2, 5, 11), (4 * ARCSEC, ARCSEC, ARCSEC), (0.1, 2.0, 4.0)),
            GraduationBump(3 * ARCSEC, 1.0, 0.01),
        ),
    )
    ahead = TableState.at_rest(ANGLES + HEAD_SEPARATION_RAD)
    np.testing.assert_allclose(
        table.reading_rad(1, STATE), table.reading_rad(0, ahead), rtol=0, atol=1e-11
    )
    assert np.ptp(table.reading_rad(0, STATE) - ANGLES) > 300 * ARCSEC


def test_head_separation_is_the_mean_over_true_angle_not_over_reading() -> None:
    # A mean over uniform readings, instead of uniform angles, gives a separation that is wrong by
    # (a²/2)·sin α with a = e/R, which is 0.017″ for 30 µm.
    table = eccentric(30e-6)
    turn = np.arange(3600) * (2 * np.pi / 3600)
    state = TableState.at_rest(turn)
    difference = table.reading_rad(1, state) - table.reading_rad(0, state)
    assert difference.mean() == pytest.approx(HEAD_SEPARATION_RAD, abs=1e-5 * ARCSEC)
    reading = table.reading_rad(0, state)
    weights = (np.roll(reading, -1) - np.roll(reading, 1)) % (2 * np.pi)
    off = np.sum(weights * difference) / np.sum(weights) - HEAD_SEPARATION_RAD
    expected = (30e-6 / DISC_RADIUS_M) ** 2 / 2 * np.sin(HEAD_SEPARATION_RAD)
    assert abs(off) == pytest.approx(expected, rel=0.01)
    assert expected / ARCSEC == pytest.approx(0.017, abs=0.0005)


def test_axis_that_moves_is_seen_by_head_one_across_its_ray_only() -> None:
    class Shift(Cause):
        def __init__(self, shift_m: complex) -> None:
            self.shift_m = shift_m

        def axis_shift_m(self, state: TableState) -> complex:
            return self.shift_m

    def change(shift_m: complex, head: int) -> float:
        table = RotaryTable(two_heads(), (Shift(shift_m),))
        return float(table.reading_rad(head, STATE).mean() - STATE.angle_rad.mean())

    tiny = 1e-9
    assert change(1j * tiny, 0) == pytest.approx(tiny / DISC_RADIUS_M, rel=1e-6)
    assert change(tiny, 0) == pytest.approx(0, abs=1e-14)
    # The difference δ₂₁ of the heads contains x·sin α + y·(cos α − 1).
    alpha = HEAD_SEPARATION_RAD
    both = change(tiny * (1 + 1j), 1) - alpha - change(tiny * (1 + 1j), 0)
    expected = tiny / DISC_RADIUS_M * (np.sin(alpha) + np.cos(alpha) - 1)
    assert both == pytest.approx(expected, rel=1e-5)


def test_index_of_each_head_is_the_mark_on_the_disc() -> None:
    mark = 1.234
    table = RotaryTable(
        two_heads(),
        (DiscEccentricity(40e-6), GraduationHarmonics((3,), (9 * ARCSEC,), (0.0,))),
        counts_per_rev=65536,
        index_mark_rad=mark,
    )
    for head in (0, 1):
        # By definition a head's count is 0 when the mark of the disc is under the head.
        angle = np.array([mark + table.heads[head].angle_rad])
        for _ in range(20):
            angle += mark - table.disc_angle_rad(head, TableState.at_rest(angle))
        assert table.counts(head, TableState.at_rest(angle))[0] == 0
    late = RotaryTable((Head.on_circle(DISC_RADIUS_M, 0.0, 5), table.heads[1]))
    assert late.counts(0, TableState.at_rest(np.array([1e-9])))[0] == -5


def test_counts_round_as_they_are_reported() -> None:
    count = 2 * np.pi / 4096
    state = TableState.at_rest(np.array([-0.75, -0.25, 0.25, 0.75, 1.25]) * count)
    down = RotaryTable(two_heads(), counts_per_rev=4096)
    near = RotaryTable(two_heads(), counts_per_rev=4096, rounding="nearest")
    assert down.counts(0, state).tolist() == [-1, -1, 0, 0, 1]
    assert near.counts(0, state).tolist() == [-1, 0, 0, 1, 1]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"counts_per_rev": 10}, "multiple of 4"),
        ({"noise_rad": -1.0}, "not negative"),
        ({"index_width_counts": 0}, "counts wide"),
    ],
)
def test_impossible_tables_are_refused(arguments: dict[str, float], words: str) -> None:
    with pytest.raises(ValueError, match=words):
        RotaryTable(two_heads(), **arguments)  # type: ignore[arg-type]
