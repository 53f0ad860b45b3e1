"""Tests of the firmware's application on a model of the core, from the first index to swapped
coefficients."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS, Disc
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN, header_flag
from sim.tests.firmware.library import firmware as c_library
from sim.tests.firmware.model_core import COEFFICIENTS, Firmware, ModelCore, address, bit
from sim.tests.firmware.test_estimates import DISC, counts_of

from arctrue.gateware.coefficients import Coefficients

SAMPLES = 1500
ARCSEC_PER_COUNT = 1_296_000 / COUNTS


def turn(disc: Disc = DISC, seed: int = 1, noise: float = 0.1) -> Any:
    return counts_of(disc, noise, seed, samples=SAMPLES)


@pytest.fixture
def running() -> Firmware:
    firmware = Firmware(ModelCore())
    firmware.library.application_start(firmware.application)
    firmware.core.see_index()
    firmware.step()
    assert firmware.phase == "capture"
    return firmware


def active_coefficients(core: ModelCore, counts_per_rev: int = COUNTS) -> Coefficients:
    words = [core.active[COEFFICIENTS + 4 * i] for i in range(128)]
    lanes = np.array(words, dtype=np.uint64).reshape(-1, 4)
    return Coefficients(
        lanes[:, 0] | lanes[:, 1] << np.uint64(32),
        lanes[:, 2].astype(np.uint32),
        lanes[:, 3].astype(np.uint32).view(np.int32),
        0,
        counts_per_rev,
    )


def controls(core: ModelCore) -> dict[str, bool]:
    names = ("compensate", "output_enable", "capture_enable")
    return {name: bool(core.get("control") & bit("control", name)) for name in names}


def test_it_waits_for_the_index_of_both_heads() -> None:
    firmware = Firmware(ModelCore())
    assert firmware.phase == "no_core"
    firmware.library.application_start(firmware.application)
    firmware.step(3)
    assert firmware.phase == "wait_for_index"
    firmware.core.set("head1.flags", 1)
    firmware.step(3)
    assert firmware.phase == "wait_for_index"
    firmware.core.set("head2.flags", 1)
    firmware.step()
    assert firmware.phase == "capture"
    assert controls(firmware.core) == {
        "compensate": False,  # after a reset of the processor the banks may still contain old words
        "output_enable": True,
        "capture_enable": True,
    }


@pytest.mark.parametrize(
    ("register", "word"),
    [
        ("identification", 0),
        ("version", 1 << 16),
        ("core_configuration", 0),
        ("clock_hz", 0),
    ],
)
def test_another_core_is_refused(register: str, word: int) -> None:
    core = ModelCore()
    core.set(register, word)
    firmware = Firmware(core)
    firmware.library.application_start(firmware.application)
    assert firmware.phase == "no_core"
    assert not core.writes
    assert firmware.send("dump").startswith("error: no core")


@pytest.mark.parametrize("method", [0, 1])
def test_a_turn_becomes_coefficients(running: Firmware, method: int) -> None:
    assert running.send(f"set method {method}") == "ok\r\n"
    telemetry = running.turn(turn())
    assert telemetry["result"] == "applied"
    assert controls(running.core)["compensate"]
    assert running.phase == "capture"
    assert not running.core.get("status") & bit("status", "capture_ready")
    reading = np.arange(0, COUNTS, COUNTS // 997)
    angle = reading * (2 * np.pi / COUNTS)
    true = DISC.true_angle(angle)
    wrong_arcsec = np.rad2deg(angle - true) * 3600
    left = wrong_arcsec - active_coefficients(running.core).error_counts(reading) * ARCSEC_PER_COUNT
    assert np.abs(left).max() < 0.3, "order 11 alone has a noise gain of 19"
    assert telemetry["active_arcsec"] > 100
    assert telemetry["candidate_arcsec"] < 0.15
    assert telemetry["alarms"] == []
    assert {n for n, *_, chosen in telemetry["harmonics"] if chosen} >= {1, 2, 3}


def test_the_second_turn_does_not_swap_for_nothing(running: Firmware) -> None:
    running.turn(turn())
    swaps = [running.turn(turn(seed=seed))["swaps"] for seed in range(2, 7)]
    assert swaps[-1] <= 3, "five more turns of the same disc"


def test_a_disc_that_changes_is_followed(running: Firmware) -> None:
    running.turn(turn())
    for seed in range(2, 22):
        telemetry = running.turn(turn(Disc({**DISC.orders, 1: (155.0, 0.4)}), seed))
    assert telemetry["active_arcsec"] < 0.2
    assert telemetry["swaps"] > 5


def test_frozen_coefficients_stay(running: Firmware) -> None:
    assert running.send("freeze on") == "ok\r\n"
    telemetry = running.turn(turn())
    assert (telemetry["result"], telemetry["reason"], telemetry["swaps"]) == ("kept", "none", 0)
    assert not running.core.active
    running.send("freeze off")
    assert running.turn(turn(seed=2))["result"] == "applied"


def test_bypass_and_back(running: Firmware) -> None:
    running.turn(turn())
    assert running.send("bypass on") == "ok\r\n"
    assert not controls(running.core)["compensate"]
    assert controls(running.core)["capture_enable"], "the capture continues"
    assert "bypassed" in running.send("status")
    assert running.turn(turn(Disc({1: (20.0, 1.0)}), seed=3))["result"] == "applied"
    assert not controls(running.core)["compensate"]
    running.send("bypass off")
    assert controls(running.core)["compensate"]


def test_a_bad_turn_is_counted_and_the_last_good_stays(running: Firmware) -> None:
    running.turn(turn())
    good = dict(running.core.active)
    bad = turn(seed=2)
    bad[0, 500:] += 50_000
    telemetry = running.turn(bad)
    assert (telemetry["result"], telemetry["reason"]) == ("refused", "jump")
    assert (telemetry["fault_head"], telemetry["fault_sample"]) == (1, 500)
    assert "harmonics" not in telemetry
    flagged = running.turn(turn(), BOTH_INDICES_SEEN | header_flag("illegal1"))
    assert flagged["reason"] == "illegal_transition"
    cleared = bit("command", "clear_head1") | bit("command", "clear_head2")
    commands = [word for offset, word in running.core.writes if offset == address("command")]
    assert any(word & cleared == cleared for word in commands[-3:]), "the flags are sticky"
    assert running.core.active == good
    assert controls(running.core)["compensate"]
    status = running.send("status")
    assert "refused jump 1\r\n" in status
    assert "refused illegal_transition 1\r\n" in status


def test_only_the_operator_ends_the_fault_of_the_output(running: Firmware) -> None:
    """Only the operator ends the fault of the output: a servo that follows the output would move
    the table if the output returned by itself, and the output has also lost counts."""
    assert running.turn(turn())["output_fault"] == "none"
    assert "output_fault none\r\n" in running.send("status")
    running.core.set("status", bit("status", "cannot_keep_up"))
    running.core.writes.clear()
    flagged = running.turn(turn(seed=2), BOTH_INDICES_SEEN | header_flag("illegal1"))
    assert (flagged["result"], flagged["output_fault"]) == ("refused", "cannot_keep_up")
    running.send("rearm")
    running.send("set sample_period 35")
    running.send("forget")
    running.step(3)
    ends = bit("command", "clear_output")
    commands = [word for offset, word in running.core.writes if offset == address("command")]
    assert commands
    assert not any(word & ends for word in commands)
    assert "output_fault cannot_keep_up\r\nadvice the output stands" in running.send("status")
    running.core.writes.clear()
    assert running.send("clear_output") == "ok, the output follows from the present position\r\n"
    assert running.core.writes == [(address("command"), ends)]
    assert "output_fault none\r\n" in running.send("status")
    assert running.send("clear_output") == "error: the output has no fault\r\n"


def test_a_fault_of_the_output_that_is_still_there_is_reported(running: Firmware) -> None:
    """The firmware reports a fault of the output that is still present: the core sets the fault
    again at once while the output lags too far."""
    running.core.set("status", bit("status", "cannot_keep_up"))
    running.core.command = lambda word: None  # type: ignore[method-assign]
    answer = running.send("clear_output")
    assert answer == "error: the output has a fault again; try help output\r\n"


def test_without_a_core_there_is_no_output_to_clear() -> None:
    core = ModelCore()
    core.set("identification", 0)
    assert Firmware(core).send("clear_output") == "error: no core\r\n"
    assert not core.writes


LOST = BOTH_INDICES_SEEN | header_flag("index_error2")


def slipped(counts: Any, slip: int) -> Any:
    return counts + np.array([[0], [slip]])


@pytest.mark.parametrize("method", [0, 1])
@pytest.mark.parametrize("slip", [-4, 40, -11_651, 1 << 20, (1 << 23) - 1])
def test_counts_that_head_2_lost(running: Firmware, method: int, slip: int) -> None:
    """The firmware corrects the zero of head 2 after head 2 has lost or gained between 4 counts and
    half a turn; an undetected loss would shift the separation."""
    running.send(f"set method {method}")
    running.turn(turn())
    clean = running.turn(turn(seed=2))
    good = dict(running.core.active)
    running.core.head2_slips(slip)
    running.core.writes.clear()
    telemetry = running.turn(slipped(turn(seed=3), slip), LOST)
    assert (telemetry["reason"], telemetry["alarms"]) == ("index_error", ["zero_lost"])
    rearm = (address("command"), bit("command", "rearm"))
    assert rearm not in running.core.writes, "a re-arm would leave a turn without correction"
    assert controls(running.core)["compensate"]
    assert running.core.active == good
    assert f"head2_zero_counts {slip}\r\n" in running.send("status")
    after = running.turn(slipped(turn(seed=2), slip))
    assert after["alarms"] == []
    assert after["separation"] == "measured"
    assert after["separation_deg"] == clean["separation_deg"]
    assert after["residual_arcsec"] == clean["residual_arcsec"]


def test_an_index_of_head_2_that_repeats_to_a_count(running: Firmware) -> None:
    """A slip of head 2 within index_tolerance of its known zero changes nothing and raises no
    alarm. A larger slip, and the return to zero, move the known zero and raise an alarm."""
    for slip, zero, alarms in (
        (1, 0, []),
        (-40, -40, ["zero_lost"]),
        (-38, -40, []),
        (-44, -44, ["zero_lost"]),
        (2, 0, ["zero_lost"]),
    ):
        running.core.head2_slips(slip)
        telemetry = running.turn(turn(), LOST)
        assert (running.application.head2_zero, telemetry["alarms"]) == (zero, alarms)


def test_an_index_error_of_head_2_that_would_be_cleared_unseen(running: Firmware) -> None:
    """The firmware processes an index error of head 2 even if the turn in which it occurs is
    refused for another reason."""
    running.core.set("head2.flags", 0b11)
    running.core.head2_slips(40)
    telemetry = running.turn(turn(), BOTH_INDICES_SEEN | header_flag("illegal1"))
    assert (telemetry["reason"], telemetry["alarms"]) == ("illegal_transition", ["zero_lost"])
    assert running.application.head2_zero == 40
    running.core.set("head2.flags", 0b01)
    telemetry = running.turn(turn(), BOTH_INDICES_SEEN | header_flag("illegal1"))
    assert telemetry["alarms"] == [], "the zero is checked only after an index error"


def is_rearmed(core: ModelCore) -> bool:
    commands = [word for offset, word in core.writes if offset == address("command")]
    return any(word & bit("command", "rearm") for word in commands)


def test_the_core_moves_the_zero_of_head_1(running: Firmware) -> None:
    """The firmware reports at once that the core moved the zero of head 1, before the core hands
    over the next bank. The correction stays on, and the capture starts again."""
    assert running.core.get("lost_counts") == bit("lost_counts", "zero_again")
    running.turn(turn())
    running.core.writes.clear()
    running.core.moves_zero(-8)
    telemetry = json.loads(running.step())
    assert telemetry["alarms"] == ["zero_lost"]
    assert running.phase == "capture"
    words = [word for offset, word in running.core.writes if offset == address("control")]
    assert all(word & bit("control", "compensate") for word in words)
    captures = [bool(word & bit("control", "capture_enable")) for word in words]
    assert captures == [False, True], "half a turn with the wrong zero is not used"
    assert not is_rearmed(running.core)
    assert running.core.get("head1.flags") == 1, "the next turn is judged by itself"
    assert running.step() == "", "reported once"
    assert running.turn(turn(seed=2))["alarms"] == []


def test_the_zero_moved_as_the_bank_became_full(running: Firmware) -> None:
    running.turn(turn())
    running.core.writes.clear()
    running.core.moves_zero(-8)
    telemetry = running.turn(turn(), BOTH_INDICES_SEEN | header_flag("index_error1"))
    assert (telemetry["reason"], telemetry["alarms"]) == ("index_error", ["zero_lost"])
    assert not is_rearmed(running.core)
    assert running.turn(turn(seed=2))["alarms"] == []


def test_counts_are_put_back_where_the_operator_says_so(running: Firmware) -> None:
    running.send("set heal 1")
    both = bit("lost_counts", "zero_again") | bit("lost_counts", "heal")
    assert running.core.get("lost_counts") == both


@pytest.mark.parametrize(("slip", "doubts"), [(2, False), (-8, True), (COUNTS // 3, False)])
def test_a_zero_that_no_mark_proves(running: Firmware, slip: int, doubts: bool) -> None:
    """Head 1 loses counts in every turn: after four turns the firmware switches the correction off
    and seeks the zero again.

    The firmware keeps the correction on for a slip within the repeatability of the index, and for a
    large slip, which comes from a false pulse.
    """
    running.turn(turn())
    begin = running.core.get("snapshot.head1_position")
    running.application.position_at_bank = begin
    running.core.writes.clear()
    for turns in (0.0, 1.0, 2.0, 3.0, 3.9):
        running.core.set("snapshot.head1_position", int(begin + turns * COUNTS))
        running.core.head1_slips(slip)
        running.core.set("head1.flags", 0b11)
        running.step()
        assert not running.core.writes, "the correction goes on meanwhile"
    running.application.position_at_bank = int(begin + 3.9 * COUNTS)
    running.core.set("snapshot.head1_position", int(begin + 4.1 * COUNTS))
    running.core.head1_slips(slip)
    said = running.step()
    assert is_rearmed(running.core) == doubts
    assert running.phase == ("wait_for_index" if doubts else "capture")
    assert ("zero_lost" in said) == doubts
    assert running.application.has_active, "the coefficients belong to the index"


def test_a_doubt_that_ends(running: Firmware) -> None:
    """A false mark near the index makes the zero of head 1 doubtful; the doubt ends when the next
    mark is at the right place."""
    running.turn(turn())
    running.core.writes.clear()
    running.core.head1_slips(-8)
    running.core.set("head1.flags", 0b11)
    running.step()
    assert running.application.zero_in_doubt
    running.core.head1_slips(0)
    running.step()
    assert not running.application.zero_in_doubt


def test_a_re_arm_makes_both_zeros_anew(running: Firmware) -> None:
    running.core.head2_slips(40)
    running.turn(turn(), LOST)
    assert running.send("rearm").startswith("ok")
    assert running.application.head2_zero == 0
    running.step()
    running.turn(turn(), LOST)
    assert running.application.head2_zero == 40


def test_a_dump_has_the_zero_that_is_known(running: Firmware) -> None:
    running.core.head2_slips(-400)
    running.turn(turn(), LOST)
    running.send("dump")
    running.core.hand_over(slipped(turn(), -400))
    first = running.step(3).splitlines()[2]
    assert first.split(",")[1:3] == [str(int(word)) for word in turn()[:, 0]]


@pytest.mark.parametrize("method", [0, 1])
def test_heads_that_are_exchanged(running: Firmware, method: int) -> None:
    running.send(f"set method {method}")
    telemetry = running.turn(turn()[::-1])
    assert (telemetry["result"], telemetry["reason"]) == ("refused", "heads_exchanged")
    assert telemetry["alarms"] == ["separation"]
    assert not running.core.active
    assert not controls(running.core)["compensate"]
    status = running.send("status")
    assert "reason heads_exchanged\r\nadvice head 2 is where head 1 should be: exchange" in status
    (line,) = [text for text in status.splitlines() if text.startswith("separation_deg")]
    assert float(line.split()[1]) == pytest.approx(-33.0, abs=0.01)
    assert running.turn(turn(seed=2))["result"] == "applied"
    # A wrong stated separation of the heads can change the sign of the separation, too.
    assert running.send("set separation_deg 327") == "ok\r\n"
    assert running.turn(turn(seed=3))["reason"] == "heads_exchanged"
    assert running.turn(turn(seed=4)[::-1])["reason"] in ("none", "not_better")


@pytest.mark.parametrize(
    ("nominal", "measured", "exchanged"),
    [
        (33.0, -33.0, True),
        (33.0, 327.2, True),
        # The difference exceeds 0.25°, the accepted deviation of a separation.
        (33.0, -33.3, False),
        (33.0, 33.2, False),
        (33.0, 90.0, False),
        # The heads fit equally well if they are exchanged.
        (180.0, 180.0, False),
        (180.0, -180.0, False),
        (0.1, -0.1, False),
    ],
)
def test_which_separation_is_an_exchanged_one(
    nominal: float, measured: float, exchanged: bool
) -> None:
    library = c_library()[1]
    assert library.separation_is_exchanged(*np.radians([nominal, measured])) == exchanged


def test_noise_that_stays_is_taken_for_usual(running: Firmware) -> None:
    running.turn(turn())
    reasons = [running.turn(turn(noise=1.5, seed=9 + i))["reason"] for i in range(6)]
    assert reasons[:4] == ["noise"] * 4
    assert "noise" not in reasons[4:]


def test_a_bank_of_no_samples(running: Firmware) -> None:
    assert running.turn(np.zeros((2, 0), dtype=np.int64))["reason"] == "empty"


def test_a_header_beyond_the_memory_is_not_followed(running: Firmware) -> None:
    running.core.hand_over(turn())
    running.core.set("capture_header.sample_count", 65_535)
    running.core.set("core_configuration", 32 | 18 << 8 | SAMPLES << 16)
    running.application.configuration.capture_depth = SAMPLES
    running.step()
    assert running.application.capture.samples == SAMPLES


def test_coefficients_that_do_not_read_back(running: Firmware) -> None:
    running.core.broken_lane = 1
    telemetry = running.turn(turn())
    assert telemetry["alarms"] == ["coefficients"]
    assert (telemetry["result"], telemetry["swaps"]) == ("kept", 0)
    assert not controls(running.core)["compensate"]


def test_a_swap_that_never_comes_ends_in_the_safe_state(running: Firmware) -> None:
    running.turn(turn())
    running.core.swaps_are_lost = True
    running.core.hand_over(turn(Disc({1: (20.0, 1.0)}), seed=3))
    running.step()
    assert running.phase == "swap"
    running.said.clear()
    said = running.step(2000)
    assert "swap" in json.loads(said.splitlines()[-1])["alarms"]
    assert running.phase == "capture"
    assert not controls(running.core)["compensate"]
    running.core.swaps_are_lost = False
    assert running.turn(turn(seed=4))["result"] == "applied"
    assert controls(running.core)["compensate"]


def test_orders_that_are_no_longer_judged_are_no_longer_applied(running: Firmware) -> None:
    """After "set orders 5" the firmware removes the higher orders from the bank. The disc has not
    changed, so that orders 1 to 3 keep their values and the next turn gives no improvement."""
    for seed in range(1, 6):
        running.turn(turn(seed=seed))
    reading = np.arange(0, COUNTS, COUNTS // 1024)

    def spectrum() -> Any:
        error = active_coefficients(running.core).error_counts(reading)
        return np.abs(np.fft.rfft(error))[:32] * 2 * ARCSEC_PER_COUNT / reading.size

    before = spectrum()
    assert before[31] > 0.2
    assert running.send("set orders 5") == "ok\r\n"
    assert running.turn(turn(seed=6, noise=0.25))["result"] == "applied"
    after = spectrum()
    assert (after[6:] < 0.01).all(), "rounding of the samples"
    np.testing.assert_allclose(after[1:4], before[1:4], atol=0.05)
    assert running.turn(turn(seed=6, noise=0.25))["reason"] == "not_better"


def capture_mode(core: ModelCore) -> int:
    return core.get("control") >> 3 & 3


def test_a_swinging_speed_is_sampled_at_equal_angles(running: Firmware) -> None:
    """If the speed varies, here by ±19 % once per turn, the firmware refuses samples at equal times
    and from then on samples at equal angles."""
    random = np.random.default_rng(5)
    part = np.linspace(0.0, 1.01, SAMPLES)
    theta = 2.0 * np.pi * (part + 0.03 * np.sin(2.0 * np.pi * part))
    running.core.writes.clear()
    telemetry = running.turn(DISC.heads(theta, 0.1, random))
    assert (telemetry["result"], telemetry["reason"]) == ("refused", "wrong_step")
    # The capture restarts, which discards the samples of the next turn, because they were taken at
    # equal times.
    orders = [word for offset, word in running.core.writes if offset == address("control")]
    assert [bool(word & bit("control", "capture_enable")) for word in orders[-2:]] == [False, True]
    assert capture_mode(running.core) == 1
    assert "samples equal_angles" in running.send("status").splitlines()
    step = running.core.get("angle_step")
    assert COUNTS % step == 0
    assert 12288 / 2 - 1 <= COUNTS / step <= 12288
    reading = np.arange(3, COUNTS // step + 6) * step
    theta = DISC.true_angle(reading * 2.0 * np.pi / COUNTS)
    telemetry = running.turn(DISC.heads(theta, 0.1, random))
    assert telemetry["result"] == "applied"
    found = {int(n): (amplitude, phase) for n, amplitude, phase, *_ in telemetry["harmonics"]}
    for order, (amplitude, phase) in DISC.orders.items():
        value = found[order][0] * np.exp(1j * found[order][1])
        # The 0.1″ of the bound are four times the standard uncertainty that the noise of a turn
        # gives the weakest order.
        assert abs(value - amplitude * np.exp(1j * phase)) < 0.1 + 2e-3 * amplitude, order


@pytest.mark.parametrize("order", ["dump", "rearm"])
def test_equal_times_come_back(running: Firmware, order: str) -> None:
    """A dump and a re-arm return to samples at equal times: the rows of a dump need times, and
    after a re-arm the speed is unknown."""
    running.application.by_angle = True
    running.send(order)
    assert capture_mode(running.core) == 0
    assert "samples equal_times" in running.send("status").splitlines()


def test_a_stuck_capture_ends_in_the_safe_state(running: Firmware) -> None:
    running.turn(turn())
    position = running.core.get("snapshot.head1_position")
    running.core.set("snapshot.head1_position", position + 3 * COUNTS)
    running.step()
    assert controls(running.core)["compensate"]
    running.core.set("snapshot.head1_position", position + 5 * COUNTS)
    (line,) = running.step().splitlines()
    telemetry = json.loads(line)
    assert telemetry == {
        "turn": 1,
        "result": "alarm",
        "reason": "none",
        "swaps": 1,
        "alarms": ["stuck_capture"],
    }
    assert controls(running.core) == {
        "compensate": False,
        "output_enable": True,
        "capture_enable": True,
    }
    assert running.turn(turn(seed=4))["result"] == "applied"
    assert controls(running.core)["compensate"]


def test_alarms(running: Firmware) -> None:
    running.turn(turn())
    running.core.set("status", bit("status", "cannot_keep_up"))
    running.core.set("overrun_count", 1)
    running.send("set alarm_noise_arcsec 0.01")
    running.send("set alarm_separation_arcsec 0.001")
    telemetry = running.turn(turn(Disc({1: (160.0, 0.4)}, alpha_deg=33.001), seed=3))
    assert telemetry["alarms"] == ["noise", "error", "separation", "output", "overrun"]
    assert running.turn(turn(seed=5))["alarms"][-1] == "output", "an overrun is reported once"


def test_a_turn_of_counts_that_the_core_refuses(running: Firmware) -> None:
    running.core.command = lambda word: None  # type: ignore[method-assign]
    assert running.send("set counts_per_rev 4096").startswith("ok")
    assert running.phase == "no_core"


def test_the_core_interrupts_when_a_bank_is_ready(running: Firmware) -> None:
    core = running.core
    enabled = bit("interrupt_enable", "capture_ready") | bit("interrupt_enable", "head1_fault")
    assert core.get("interrupt_enable") == enabled
    core.writes.clear()
    core.hand_over(turn())
    running.library.application_interrupt(running.application)
    assert (address("interrupt_status"), enabled) in core.writes
    running.step()
    assert (running.application.interrupts, running.application.banks_without_interrupt) == (1, 0)
    running.step(3)
    core.hand_over(turn(seed=2))
    running.step()
    assert running.application.turns == 2, "the bank is found without an interrupt"
    assert (running.application.interrupts, running.application.banks_without_interrupt) == (1, 1)
    assert "banks_without_interrupt 1\r\n" in running.send("status")


def test_an_interrupt_without_a_core_touches_nothing() -> None:
    core = ModelCore()
    core.set("identification", 0)
    firmware = Firmware(core)
    firmware.library.application_start(firmware.application)
    firmware.library.application_interrupt(firmware.application)
    assert not core.writes
    assert firmware.application.interrupts == 1


def test_it_does_not_sleep_while_there_is_more_to_do(running: Firmware) -> None:
    library = running.library
    assert not library.application_busy(running.application)
    assert not library.console_busy(running.console)
    running.send("dump")
    running.core.hand_over(turn())
    running.step()
    assert library.application_busy(running.application), "a swap"
    assert library.console_busy(running.console), "rows"


class Sensor:
    """A thermometer that does not always give a temperature."""

    def __init__(self, firmware: Firmware) -> None:
        ffi, library = c_library()
        self.celsius: float | None = 40.0
        self.call = ffi.callback("temperature_read", self.read)
        # The C code holds a pointer to the callback, so that Python must keep the callback.
        firmware.sensor = self
        library.application_use_temperature(firmware.application, self.call, ffi.NULL)

    def read(self, _: Any, celsius: Any) -> bool:
        if self.celsius is None:
            return False
        celsius[0] = self.celsius
        return True


def test_the_temperature_of_a_turn(running: Firmware) -> None:
    assert running.turn(turn())["temperature_c"] is None, "no sensor"
    assert "temperature_c absent\r\n" in running.send("status")
    sensor = Sensor(running)
    assert running.turn(turn(seed=2))["temperature_c"] == 40.0
    assert "temperature_c 40.000000000\r\n" in running.send("status")
    sensor.celsius = -12.346
    assert running.turn(turn(seed=3))["temperature_c"] == -12.35
    sensor.celsius = None
    assert running.turn(turn(seed=4))["temperature_c"] is None, (
        "the former temperature is not repeated"
    )
    assert "temperature_c absent\r\n" in running.send("status")


def test_a_hot_die_is_an_alarm(running: Firmware) -> None:
    sensor = Sensor(running)
    sensor.celsius = 84.9
    assert running.turn(turn())["alarms"] == []
    sensor.celsius = 85.1
    assert running.turn(turn(seed=2))["alarms"] == ["temperature"]
    assert running.send("set alarm_temperature_c 90") == "ok\r\n"
    assert running.turn(turn(seed=3))["alarms"] == []
    bad = turn(seed=5)
    bad[0, 500:] += 50_000
    sensor.celsius = 95.0
    assert running.turn(bad)["alarms"] == ["temperature"], "also with a turn that is refused"


def test_a_dump_tells_the_temperature(running: Firmware) -> None:
    Sensor(running)
    running.send("dump")
    running.core.hand_over(turn())
    head = running.step(3).splitlines()[0]
    assert " separation_deg=33.000000 temperature_c=40.00 crc=" in head


@pytest.mark.parametrize("phase", ["wait_for_index", "capture"])
def test_a_core_that_was_reset_is_set_up_again_at_once(running: Firmware, phase: str) -> None:
    """The firmware detects in its next step that the core was reset, reports this once and sets the
    core up again."""
    running.turn(turn())
    setup = {name: running.core.get(name) for name in ("ramp_rate", "output_spacing", "alarm")}
    if phase == "wait_for_index":
        running.core.set("head1.flags", 0)
        running.send("rearm")
    for name in ("control", "head1.flags", "head2.flags", *setup):
        running.core.set(name, 0)
    running.core.set("counts_per_rev_active", 1 << 24)
    telemetry = json.loads(running.step())
    assert (telemetry["result"], telemetry["alarms"]) == ("alarm", ["core_reset"])
    assert running.phase == "wait_for_index"
    assert controls(running.core) == {
        "compensate": False,
        "output_enable": True,
        "capture_enable": True,
    }
    assert {name: running.core.get(name) for name in setup} == setup
    assert running.core.get("counts_per_rev_active") == COUNTS
    assert running.step(3) == "", "reported once"
    running.core.see_index()
    running.step()
    assert running.turn(turn(seed=2))["result"] == "applied"


def four_heads() -> Firmware:
    """Return the firmware with a core of four heads; the indices of heads 1 and 2 have been
    found."""
    core = ModelCore()
    core.set("version", 0x000800)
    core.set("capability", 4 | 1 << 3)
    core.access.further_capture = core.access.capture
    found = Firmware(core)
    found.library.application_start(found.application)
    core.set("head1.flags", 1)
    core.set("head2.flags", 1)
    return found


def test_it_waits_for_the_index_of_further_heads() -> None:
    """The firmware waits for head 4, because without the zero of head 4 it cannot judge a mean. It
    does not wait for a head that is left out."""
    firmware = four_heads()
    firmware.core.set("heads_status", 0b0111 << 8)
    firmware.step(3)
    assert firmware.phase == "wait_for_index"
    firmware.core.set("heads_status", 0b1111 << 8)
    firmware.step()
    assert firmware.phase == "capture"

    without = four_heads()
    without.core.set("heads_status", 0b0111 << 8 | 0b1000)
    without.step(3)
    assert without.phase == "capture"


def test_a_further_head_without_an_index_holds_nothing_up_for_long() -> None:
    """The firmware does not wait long for heads 3 and 4, which show no index. After a whole turn of
    head 1 the firmware corrects head 1 alone, as with two heads."""
    firmware = four_heads()
    firmware.core.set("heads_status", 0b0011 << 8)
    firmware.step(3)
    assert firmware.phase == "wait_for_index"
    firmware.core.words[address("head1.index") + 4] = 1 << 24
    firmware.step()
    assert firmware.phase == "capture"


def test_telemetry_of_a_mean_has_no_figure_of_head_1(running: Firmware) -> None:
    """Telemetry of a mean omits ``active_arcsec``, because 0 would look like a perfect mean; it
    names a head that the gateware left out."""
    assert running.turn(counts_of(DISC))["active_arcsec"] > 100
    running.turn(counts_of(DISC))
    running.core.set("version", 0x000800)
    running.core.set("capability", 4 | 1 << 3)
    running.application.core.further_capture = running.core.access.capture
    running.core.set("heads_status", 0b1111 << 8 | 0b0100)
    assert running.application.has_active
    running.application.active.mean.heads = 4
    telemetry = running.turn(counts_of(DISC))
    assert telemetry["mean_of_heads"] == 4
    assert "active_arcsec" not in telemetry
    assert "candidate_arcsec" not in telemetry
    assert telemetry["left_out"] == [3]


def test_coefficients_of_its_own_switch_the_failover_off(running: Firmware) -> None:
    """The firmware switches the failover off when it writes coefficients of its own, because
    prepared sets belong to earlier coefficients."""
    running.core.set("version", 0x000800)
    running.core.set("capability", 2 | bit("capability", "failover"))
    running.core.set("failover", bit("failover", "enable") | bit("failover", "illegal"))
    running.core.writes.clear()
    assert running.turn(turn())["result"] == "applied"
    offsets = [offset for offset, _ in running.core.writes]
    assert running.core.get("failover") == 0
    window = range(COEFFICIENTS, COEFFICIENTS + 1024)
    first_word = next(place for place, offset in enumerate(offsets) if offset in window)
    assert offsets.index(address("failover")) < first_word


def test_forgetting_switches_the_failover_off(running: Firmware) -> None:
    running.core.set("version", 0x000800)
    running.core.set("capability", 2 | bit("capability", "failover"))
    running.core.set("failover", bit("failover", "enable"))
    running.library.application_forget(running.application)
    assert running.core.get("failover") == 0


def test_a_core_without_failover_has_no_such_register(running: Firmware) -> None:
    """A write to the failover register would end with a bus fault, so that the firmware must not
    write it."""
    running.core.set("version", 0x000800)
    running.core.set("capability", 2)
    running.core.writes.clear()
    running.turn(turn())
    running.library.application_forget(running.application)
    assert address("failover") not in [offset for offset, _ in running.core.writes]


def test_a_set_that_is_being_loaded_is_awaited(running: Firmware) -> None:
    """The firmware waits while the gateware loads a set into the bank that the firmware is about to
    write."""
    core = running.core
    core.set("version", 0x000800)
    core.set("capability", 2 | bit("capability", "failover"))
    looks = iter([bit("heads_status", "busy")] * 3 + [0] * 1000)
    seen: list[int] = []
    read = core.read

    def counted(context: Any, offset: int) -> int:
        if offset != address("heads_status"):
            return read(context, offset)
        seen.append(next(looks))
        return seen[-1]

    ffi, _library = c_library()
    callback = ffi.callback("core_read_word", counted)
    running.application.core.read = callback
    running.library.application_forget(running.application)
    assert seen == [bit("heads_status", "busy")] * 3 + [0]
