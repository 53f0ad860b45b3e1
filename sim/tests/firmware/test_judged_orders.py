"""Tests that the firmware judges a file order by order, and each loaded order again in every later
turn.

A turn has 2^20 counts; the disc has orders 1, 2 and 5 of 200, 50 and 10 counts. The test is
independent of the C code: the readings come from geometry (``synthetic.Disc``), the remaining error
is computed from the coefficients in the core's active bank.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from sim.tests.calibration.synthetic import Disc
from sim.tests.firmware.model_core import Firmware, ModelCore
from sim.tests.firmware.test_application import SAMPLES, active_coefficients, controls
from sim.tests.firmware.test_estimates import counts_of
from sim.tests.firmware.test_load import send, state
from sim.tests.firmware.test_save import Board

from arctrue.device.load import load_frames
from arctrue.gateware.coefficients import Coefficients

COUNTS = 1 << 20
ARCSEC = 1_296_000 / COUNTS
SIZES = {1: 200.0, 2: 50.0, 5: 10.0}
PHASES = {1: 0.4, 2: 1.2, 5: 2.9}
NOISE_ARCSEC = 0.1
QUIET_RMS_ARCSEC = 0.5
"""Largest RMS of a good correction. Rounding to whole counts gives each head an error of 0.36″ RMS;
the calculation of 32 orders from the difference of the heads magnifies it."""


def disc(**counts: float) -> Disc:
    """Return the disc with changed orders; for example ``o5=-10`` sets order 5 to -10 counts."""
    sizes = SIZES | {int(name[1:]): size for name, size in counts.items()}
    orders = {n: (size * ARCSEC, PHASES.get(n, 0.7)) for n, size in sizes.items()}
    return Disc(orders, counts_per_rev=COUNTS)


def turn(seed: int, of: Disc | None = None, samples: int = SAMPLES) -> NDArray[np.int64]:
    """Return a turn that starts at an angle given by the seed, so that turns differ in their
    rounding."""
    start = 0.3 + 0.01 * seed
    counts: NDArray[np.int64] = counts_of(
        of or disc(), NOISE_ARCSEC, seed, samples=samples, start=start
    )
    return counts


def started(lanes: int = 32) -> Firmware:
    made = Firmware(ModelCore(lanes=lanes))
    made.library.application_start(made.application)
    made.send(f"set counts_per_rev {COUNTS}")
    made.core.see_index()
    made.step()
    return made


def file_of(force: bool = False, **counts: float) -> list[str]:
    """Return the frames of a file that contains these orders, in counts."""
    sizes = {int(name[1:]): size for name, size in counts.items()}
    phases = [PHASES.get(n, 0.7) for n in sizes]
    made = Coefficients.from_harmonics(list(sizes), list(sizes.values()), phases, COUNTS, 32)
    return load_frames(made, force=force)


def exact_file_of(of: Disc, orders: list[int]) -> list[str]:
    """Return the frames of a file with the exact coefficients of these orders of the disc, computed
    from its geometry as functions of the reading."""
    reading = np.arange(4096) * (2.0 * np.pi / 4096)
    error = np.rad2deg(reading - of.true_angle(reading)) * 3600.0 / ARCSEC
    lines = np.fft.rfft(error)[orders] * (2.0 / reading.size)
    made = Coefficients.from_harmonics(orders, np.abs(lines), np.angle(lines), COUNTS, 32)
    return load_frames(made)


def load(made: Firmware, frames: list[str]) -> None:
    assert set(send(made, frames)) == {"ok"}


def left_rms_arcsec(made: Firmware, of: Disc) -> float:
    """Return the RMS error of the corrected reading about its mean."""
    reading = np.arange(0, COUNTS, 251)
    angle = reading * (2.0 * np.pi / COUNTS)
    wrong = np.rad2deg(angle - of.true_angle(angle)) * 3600.0
    if controls(made.core)["compensate"]:
        wrong -= active_coefficients(made.core, COUNTS).error_counts(reading) * ARCSEC
    return float(wrong.std())


@pytest.mark.parametrize(
    "wrong",
    [
        {"o5": -10.0},
        {"o9": 20.0},
        {"o1": 200.0, "o2": 50.0, "o9": 1.0},
        # Order 9 is smaller than half the noise of a reading, so that the error shows only if the
        # firmware judges this order alone.
        {"o9": 0.1},
        {"o300": 3.0},
    ],
    ids=["sign of order 5", "20 counts", "a count", "a tenth of a count", "above the fit"],
)
@pytest.mark.parametrize("turns_before", [0, 2])
def test_a_file_with_one_wrong_order_is_refused(wrong: dict[str, float], turns_before: int) -> None:
    """The firmware refuses a file with one wrong order. It does so also before any calibration,
    when the uncorrected order 1 is larger than the wrong order."""
    made = started()
    for seed in range(turns_before):
        made.turn(turn(100 + seed))
    load(made, file_of(**wrong))
    for seed in range(7):
        made.turn(turn(seed))
    assert state(made) == "load refused worse_prediction"
    assert f"refused_order {list(wrong)[-1][1:]}\r\n" in made.send("load status")
    assert left_rms_arcsec(made, disc()) < QUIET_RMS_ARCSEC, "the firmware continued to calibrate"


@pytest.mark.parametrize("turns_before", [0, 2])
def test_a_true_file_is_active_with_the_first_turn(turns_before: int) -> None:
    made = started()
    for seed in range(turns_before):
        made.turn(turn(100 + seed))
    load(made, file_of(o1=200.0, o2=50.0, o5=10.0))
    telemetry = made.turn(turn(1))
    assert (telemetry["result"], state(made)) == ("applied", "load active")
    assert left_rms_arcsec(made, disc()) < QUIET_RMS_ARCSEC


def test_a_loaded_order_that_drifts_is_reported() -> None:
    """Loaded order 5 drifts from 10 to 60 counts; the firmware raises an alarm and reports the
    remaining error, 43.7″ RMS."""
    made = started()
    load(made, exact_file_of(disc(), [1, 2, 5]))
    made.turn(turn(1))
    quiet = [made.turn(turn(seed)) for seed in range(2, 8)]
    assert {tuple(telemetry["alarms"]) for telemetry in quiet} == {()}
    for step in range(11):
        now = disc(o5=10.0 + 5.0 * step)
        telemetry = made.turn(turn(10 + step, now))
    left = left_rms_arcsec(made, now)
    assert left == pytest.approx(50.0 * ARCSEC / np.sqrt(2.0), rel=0.01)
    assert telemetry["active_arcsec"] == pytest.approx(left, rel=0.01)
    assert telemetry["loaded_arcsec"] == pytest.approx(left, rel=0.01)
    assert telemetry["alarms"] == ["error"]
    (row,) = [r for r in made.send("load status").splitlines() if r.startswith("left_arcsec 5 ")]
    assert float(row.split()[2]) == pytest.approx(50.0 * ARCSEC, rel=0.01)


def test_a_small_drift_is_separated_from_the_scatter_after_three_turns() -> None:
    """The firmware reports a drift of 0.6 count after three turns: it is below
    ``alarm_error_arcsec``, but many times the scatter of the order."""
    made = started()
    load(made, exact_file_of(disc(), [1, 2, 5]))
    for seed in range(8):
        assert made.turn(turn(seed))["alarms"] == []
    alarms = [made.turn(turn(20 + seed, disc(o5=10.6)))["alarms"] for seed in range(4)]
    assert alarms == [[], [], ["error"], ["error"]]
    assert made.turn(turn(30))["alarms"] == [], "the alarm ends with its cause"


@pytest.mark.parametrize("loaded", [False, True])
def test_a_saved_set_whose_order_5_has_reversed_is_not_confirmed(loaded: bool) -> None:
    board = Board()
    board.firmware.send(f"set counts_per_rev {COUNTS}")
    board.core.see_index()
    board.firmware.step()
    for seed in range(3):
        board.firmware.turn(turn(seed))
    if loaded:
        load(board.firmware, file_of(o5=10.0))
        board.firmware.turn(turn(5))
        assert state(board.firmware) == "load active"
    assert board.order("save").startswith("ok, record 1")
    board.power_on()
    now = disc(o5=-10.0)
    telemetry = board.firmware.turn(turn(9, now))
    assert board.status("saved") == ["not_confirmed"]
    assert telemetry["alarms"] == ["not_confirmed"]
    assert left_rms_arcsec(board.firmware, now) < QUIET_RMS_ARCSEC
    # After a power cycle, a turn of the disc as it was when the record was saved confirms the
    # record.
    board.power_on()
    assert board.firmware.turn(turn(10))["result"] == "applied"
    assert board.status("saved") == ["confirmed"]


def test_an_order_that_a_turn_cannot_judge_waits(monkeypatch: pytest.MonkeyPatch) -> None:
    """A file waits if the noise of a turn hides one order, here 0.02 count of order 6; the file
    also has a good order 5."""
    made = started()
    load(made, file_of(o5=10.0, o6=0.02))
    made.turn(turn(1))
    assert state(made) == "load waiting"
    lines = made.send("load status").splitlines()
    assert [line for line in lines if "order" in line] == ["undecided_order 6"]
    assert left_rms_arcsec(made, disc()) < QUIET_RMS_ARCSEC, "meanwhile the device calibrates"


def test_evidence_of_turns_adds_up() -> None:
    """An order with an amplitude of two standard uncertainties needs more than one turn to be
    confirmed; the test allows 24."""
    weak = 0.018
    made = started()
    load(made, file_of(o8=weak))
    states = [(made.turn(turn(seed, disc(o8=weak))), state(made))[1] for seed in range(1, 25)]
    assert states[0] == "load waiting"
    assert "load active" in states
    assert "refused" not in " ".join(states)


@pytest.mark.parametrize("order", [120, 240])
def test_an_order_that_two_heads_cannot_see_takes_force(order: int) -> None:
    made = started()
    load(made, file_of(o1=200.0, **{f"o{order}": 2.0}))
    made.turn(turn(1))
    assert state(made) == "load refused unseen_order"
    assert f"refused_order {order}\r\n" in made.send("load status")
    assert len(made.send("help unseen_order").splitlines()[0].split()) > 5
    load(made, file_of(force=True, o1=200.0, **{f"o{order}": 2.0}))
    made.turn(turn(2))
    assert state(made) == "load active"
    assert f"unjudged_order {order}\r\n" in made.send("load status")
    assert "unjudged_order 1\r\n" not in made.send("load status")
    assert made.turn(turn(3))["unjudged"] == [order]


def test_force_takes_no_order_that_a_turn_speaks_against() -> None:
    made = started()
    load(made, file_of(force=True, o120=2.0, o5=-10.0))
    made.turn(turn(1))
    assert state(made) == "load refused worse_prediction"


def test_a_forced_order_is_saved_and_comes_back() -> None:
    board = Board()
    board.firmware.send(f"set counts_per_rev {COUNTS}")
    board.core.see_index()
    board.firmware.step()
    load(board.firmware, file_of(force=True, o1=200.0, o120=2.0))
    board.firmware.turn(turn(1))
    assert board.order("save").startswith("ok, record 1")
    board.power_on()
    board.firmware.turn(turn(2))
    assert board.status("saved") == ["confirmed"]
    assert "unjudged_order 120\r\n" in board.firmware.send("load status")


def subdivided(seed: int, amplitudes: tuple[complex, complex], order: int) -> NDArray[np.int64]:
    """Return a turn in which each head has a different error Re(a e^{jmR}) of a high order, in
    counts (a: amplitude of the head, m: ``order``, R: reading)."""
    counts = turn(seed)
    for head, amplitude in enumerate(amplitudes):
        phase = np.exp(1j * order * counts[head] * (2.0 * np.pi / COUNTS))
        counts[head] += np.rint((amplitude * phase).real).astype(np.int64)
    return counts


@pytest.mark.parametrize("head2", [0.0, 3.0, 3.0j, -2.0])
@pytest.mark.parametrize("order", [4096, 3600])
def test_the_heads_own_subdivision_errors_are_separated(head2: complex, order: int) -> None:
    """The firmware judges head 1's subdivision error although head 2 has another error of the same
    order. An order that is a multiple of 120, such as 3,600, has the same phase at both heads; but
    the eccentricity changes the distance between their readings, so that the order becomes visible.
    """
    made = started()
    made.send("set alarm_noise_arcsec 10")
    both = (4.0 + 0.0j, head2)
    true = Coefficients.from_harmonics([order], [4.0], [0.0], COUNTS, 32)
    wrong = Coefficients.from_harmonics([order], [4.0], [np.pi], COUNTS, 32)
    load(made, load_frames(wrong))
    made.turn(subdivided(1, both, order))
    assert state(made) == "load refused worse_prediction"
    load(made, load_frames(true))
    made.turn(subdivided(2, both, order))
    assert state(made) == "load active"
    telemetry = made.turn(subdivided(3, both, order))
    assert (telemetry["loaded_arcsec"] < QUIET_RMS_ARCSEC, telemetry["alarms"]) == (True, [])


def test_samples_that_cannot_separate_an_order_decide_nothing() -> None:
    """No turn can decide about order 1,024 with 512 samples per turn, however small the noise is,
    because the order looks like a constant."""
    made = started()
    counts = subdivided(1, (4.0 + 0j, 0j), 1024)
    theta = 0.3 + np.arange(513) * (2.0 * np.pi / 512)
    even = disc().heads(theta, 0.0, np.random.default_rng(1))
    even[0] += 4
    load(made, load_frames(Coefficients.from_harmonics([1024], [4.0], [0.0], COUNTS, 32)))
    made.turn(even)
    assert state(made) == "load waiting"
    assert "undecided_order 1024\r\n" in made.send("load status")
    made.turn(counts)
    assert state(made) == "load active"


QUIET_TURNS = 200
"""Number of turns in this test. A run of 2,000 turns by hand raised no alarm either; noise alone
raises one with a probability of 32 e^-54 per turn."""


def test_quiet_turns_raise_no_alarm() -> None:
    of = disc(**{f"o{n}": 3.0 for n in range(1, 33) if n not in SIZES})
    made = started()
    load(made, exact_file_of(of, list(range(1, 33))))
    made.turn(turn(1, of, 600))
    assert state(made) == "load active"
    alarms = [made.turn(turn(2 + seed, of, 600))["alarms"] for seed in range(QUIET_TURNS)]
    assert sum(map(bool, alarms)) == 0


def test_a_re_arm_and_a_refused_load_leave_the_loaded_set() -> None:
    made = started()
    load(made, file_of(o5=10.0))
    made.turn(turn(1))
    assert state(made) == "load active"
    made.send("rearm")
    made.core.see_index()
    made.step()
    load(made, file_of(o9=20.0))
    for seed in range(2, 4):
        made.turn(turn(seed))
    telemetry: Any = made.turn(turn(4))
    assert "loaded_order 5\r\n" in made.send("load status")
    assert telemetry["alarms"] == []
    rows = [line.split() for line in made.send("show harmonics").splitlines()[1:-1]]
    assert rows[4][-1] == "loaded"


def test_a_set_that_is_broken_off_leaves_the_loaded_set() -> None:
    made = started()
    load(made, file_of(o5=10.0))
    made.turn(turn(1))
    made.send("rearm")
    made.core.see_index()
    made.step()
    send(made, file_of(o9=20.0)[:2])
    made.send("load abort")
    assert state(made) == "load waiting"
    made.turn(turn(2))
    assert state(made) == "load active"
