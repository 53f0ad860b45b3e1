"""Tests of the console's ``show heads``, the table of all that the device knows of its heads."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.model_core import Firmware, ModelCore, bit
from sim.tests.firmware.test_head_skew import CLOCK_HZ, LATE_NS, Late
from sim.tests.firmware.test_heads import PLACES
from sim.tests.firmware.test_own_sets import FourHeadsCore, set_places

COLUMNS = [
    *("head", "sense", "index", "place_deg", "u_arcsec", "from"),
    *("at_head", "late_ns", "u_ns", "radius", "u"),
]
RATIOS = (1.0, 1.001, 0.999, 1.0005)
WORLD = Late(noise_arcsec=0.1, late_arcsec=(0.0,) * 4, ratios=RATIOS)


def table(running: Firmware) -> list[list[str]]:
    """Return the cells of the table without its head."""
    head, *rows, end = (line.split() for line in running.send("show heads").splitlines())
    assert (head, end) == (COLUMNS, ["ok"])
    assert all(len(row) == len(COLUMNS) for row in rows)
    return rows


def column(running: Firmware, name: str) -> list[str]:
    return [row[COLUMNS.index(name)] for row in table(running)]


def four_heads() -> Firmware:
    made = Firmware(FourHeadsCore())
    made.library.application_start(made.application)
    made.core.see_index()
    set_places(made, WORLD)
    for head in range(1, 5):
        made.core.set(f"head{head}.flags", bit("head1.flags", "index_seen"))
    made.step()
    return made


def place(running: Firmware, turns: float, cables: Any, sense: Any) -> None:
    """Turn the table to ``turns``; ``cables``: heads (from 0) that the cables lead to."""
    for cable, (head, sign) in enumerate(zip(cables, sense, strict=True), start=1):
        read = sign * round((turns + PLACES[4][head] / 360.0) * COUNTS)
        there, last = ("snapshot.", "_") if cable < 3 else ("", ".")
        running.core.set(f"{there}head{cable}{last}turn_position", read)
        running.core.set(f"{there}head{cable}{last}angle", read % COUNTS)


@pytest.mark.parametrize(
    ("cables", "found"),
    [
        ((0, 1, 2, 3), ["1", "2", "3", "4"]),
        ((0, 1, 3, 2), ["1", "2", "4", "3"]),
        ((2, 0, 3, 1), ["3", "1", "4", "2"]),
    ],
)
def test_the_order_is_found_before_any_turn(cables: tuple[int, ...], found: list[str]) -> None:
    """The planned head at each cable follows from one reading; nothing else is known."""
    running = four_heads()
    place(running, 1.3, cables, (1,) * 4)
    assert column(running, "at_head") == found
    assert column(running, "from") == ["index"] * 4
    assert column(running, "sense") == ["up"] * 4
    expected = (np.array(PLACES[4])[list(cables)] - PLACES[4][cables[0]]) % 360.0
    places = np.array([float(one) for one in column(running, "place_deg")])
    np.testing.assert_allclose(places, expected, atol=1e-4)
    for name in ("u_arcsec", "late_ns", "u_ns", "radius", "u"):
        assert column(running, name) == ["-"] * 4


def test_a_reversed_head_and_a_missing_index_show() -> None:
    """A head counts down while the others count up; before the first turn no sense is known. A head
    without an index has no place, and the order is unknown."""
    running = four_heads()
    place(running, 0.1, range(4), (1,) * 4)
    assert column(running, "sense") == ["-"] * 4
    place(running, 1.3, range(4), (1, 1, -1, 1))
    assert column(running, "sense") == ["up", "up", "down", "up"]
    assert column(running, "at_head") == ["-"] * 4, "a reversed head reads no place"
    place(running, -2.4, range(4), (1,) * 4)
    assert column(running, "sense") == ["down"] * 4
    running.core.set("head4.flags", 0)
    assert column(running, "index") == ["seen"] * 3 + ["unseen"]
    assert column(running, "place_deg")[3] == "-"
    assert column(running, "at_head") == ["-"] * 4


def test_all_is_known_after_a_turn_in_each_direction() -> None:
    """Places, delays and radii are right within 4u, and equal the telemetry of the turn."""
    running = four_heads()
    period = running.application.parameters.sample_period
    world = replace(WORLD, speed=2.0 * np.pi / (WORLD.samples * period / CLOCK_HZ))
    running.turn(world.counts())
    assert column(running, "late_ns") == ["-"] * 4
    telemetry = running.turn(replace(world, speed=-world.speed, seed=2).counts())
    assert column(running, "from") == ["fit"] * 4
    assert column(running, "at_head") == ["1", "2", "3", "4"]
    rows = np.array([[float(row[n]) for n in (3, 4, 7, 8, 9, 10)] for row in table(running)])
    places, u_places, late, u_late, radii, u_radii = rows.T
    # The device prints places to 1e-6 degrees, u to 0.01″ and 0.1 ns.
    assert places == pytest.approx(telemetry["places_deg"], abs=1e-6)
    assert u_places == pytest.approx(telemetry["u_places_arcsec"], abs=0.005)
    assert late == pytest.approx(telemetry["late_ns"], abs=0.051)
    assert radii == pytest.approx(telemetry["radii"], abs=1e-6)
    assert u_late.tolist() == [0.0, *[pytest.approx(telemetry["u_late_ns"], abs=0.051)] * 3]
    mounted = np.degrees(world.true_rad)
    assert np.all(np.abs(places - mounted) * 3600.0 <= 4.0 * u_places + 0.2)
    assert np.all(np.abs(late - LATE_NS) <= 4.0 * u_late + 0.1)
    assert np.all(np.abs(radii - 1.0 / np.array(RATIOS)) <= 4.0 * u_radii + 1e-6)


@pytest.mark.parametrize("command", ["rearm", "forget", "set head_delays 65793"])
def test_no_value_of_a_turn_stays_after_a_command_that_forgets_it(command: str) -> None:
    """The commands discard the fit: the places come from the indices again, without u and radii."""
    running = four_heads()
    running.turn(WORLD.counts())
    assert column(running, "from") == ["fit"] * 4
    assert running.send(command).startswith("ok")
    assert column(running, "from") == ["index"] * 4
    for name in ("u_arcsec", "late_ns", "u_ns", "radius", "u"):
        assert column(running, name) == ["-"] * 4, name


@pytest.mark.parametrize(("unseen", "known"), [(3, (1, 2, 4)), (1, ())])
def test_a_head_without_its_index_has_no_place_of_a_former_turn(
    unseen: int, known: tuple[int, ...]
) -> None:
    """A place needs the index of its head and of head 1, also after a turn has measured it."""
    running = four_heads()
    running.turn(WORLD.counts())
    running.core.set(f"head{unseen}.flags", 0)
    sources = ["fit" if head in known else "-" for head in range(1, 5)]
    assert column(running, "from") == sources
    assert [one == "-" for one in column(running, "place_deg")] == [s == "-" for s in sources]
    assert column(running, "at_head") == ["-"] * 4


@pytest.mark.parametrize("direction", [1, -1])
def test_the_sense_of_the_latest_turn_counts_after_128_turns(direction: int) -> None:
    """With 2²⁴ counts per turn, the turn position of 32 bits has the wrong sign after 128 turns.
    The sense is that of the counts in the latest capture, also if the turn is refused because a
    head counts backwards or stands still."""
    running = four_heads()
    counts = replace(WORLD, speed=direction * WORLD.speed).counts()
    forwards, backwards = ("up", "down") if direction > 0 else ("down", "up")
    running.turn(counts)
    place(running, direction * 130.3, range(4), (1,) * 4)
    assert column(running, "sense") == [forwards] * 4
    counts[2] = -counts[2]
    counts[3] = counts[3, 0]
    running.turn(counts)
    place(running, direction * 130.3, range(4), (1,) * 4)
    assert column(running, "sense") == [forwards, forwards, backwards, "-"]
    running.send("rearm")
    place(running, 0.0, range(4), (1,) * 4)
    assert column(running, "sense") == ["-"] * 4


def test_two_heads_show_the_mean_over_the_turn() -> None:
    """After a turn the place is the mean over the turn, right within 4u; u includes the uncertainty
    of the index's detection. The radii of two heads are not known."""
    running = Firmware(ModelCore())
    running.library.application_start(running.application)
    running.core.see_index()
    running.step()
    world = Late(heads=2, noise_arcsec=0.1, late_arcsec=(0.0, 20.0, 0.0, 0.0))
    running.turn(world.counts())
    one, two = table(running)
    assert one[3:7] == ["0.000000", "0.00", "turn", "1"]
    assert two[5:] == ["turn", "2", "-", "-", "-", "-"]
    u = float(two[4])
    assert u == pytest.approx(running.application.parameters.index_detection_arcsec, rel=0.01)
    assert abs(float(two[3]) - np.degrees(world.true_rad[1])) * 3600.0 <= 4.0 * u


def test_exchanged_heads_of_two_are_named() -> None:
    running = Firmware(ModelCore())
    running.library.application_start(running.application)
    running.core.see_index()
    running.core.set("snapshot.head1_angle", round(33.0 / 360.0 * COUNTS))
    running.core.set("snapshot.head2_angle", 0)
    assert column(running, "at_head") == ["2", "1"]


def test_without_a_core_the_table_is_an_error() -> None:
    assert Firmware(ModelCore()).send("show heads") == "error: no core\r\n"
