"""The application over a model of the core: from the index to swapped coefficients."""

from __future__ import annotations

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


def active_coefficients(core: ModelCore) -> Coefficients:
    words = [core.active[COEFFICIENTS + 4 * i] for i in range(128)]
    lanes = np.array(words, dtype=np.uint64).reshape(-1, 4)
    return Coefficients(
        lanes[:, 0] | lanes[:, 1] << np.uint64(32),
        lanes[:, 2].astype(np.uint32),
        lanes[:, 3].astype(np.uint32).view(np.int32),
        0,
        COUNTS,
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
        "compensate": False,  # the banks may hold what was there before a reset
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
    told = running.turn(turn())
    assert told["result"] == "applied"
    assert controls(running.core)["compensate"]
    assert running.phase == "capture"
    assert not running.core.get("status") & bit("status", "capture_ready")
    reading = np.arange(0, COUNTS, COUNTS // 997)
    angle = reading * (2 * np.pi / COUNTS)
    true = DISC.true_angle(angle)
    wrong_arcsec = np.rad2deg(angle - true) * 3600
    left = wrong_arcsec - active_coefficients(running.core).error_counts(reading) * ARCSEC_PER_COUNT
    assert np.abs(left).max() < 0.3, "order 11 alone has a noise gain of 19"
    assert told["active_arcsec"] > 100
    assert told["candidate_arcsec"] < 0.15
    assert told["alarms"] == []
    assert {n for n, *_, chosen in told["harmonics"] if chosen} >= {1, 2, 3}


def test_the_second_turn_does_not_swap_for_nothing(running: Firmware) -> None:
    running.turn(turn())
    swaps = [running.turn(turn(seed=seed))["swaps"] for seed in range(2, 7)]
    assert swaps[-1] <= 3, "five more turns of the same disc"


def test_a_disc_that_changes_is_followed(running: Firmware) -> None:
    running.turn(turn())
    for seed in range(2, 22):
        told = running.turn(turn(Disc({**DISC.orders, 1: (155.0, 0.4)}), seed))
    assert told["active_arcsec"] < 0.2
    assert told["swaps"] > 5


def test_frozen_coefficients_stay(running: Firmware) -> None:
    assert running.send("freeze on") == "ok\r\n"
    told = running.turn(turn())
    assert (told["result"], told["reason"], told["swaps"]) == ("kept", "none", 0)
    assert not running.core.active
    running.send("freeze off")
    assert running.turn(turn(seed=2))["result"] == "applied"


def test_bypass_and_back(running: Firmware) -> None:
    running.turn(turn())
    assert running.send("bypass on") == "ok\r\n"
    assert not controls(running.core)["compensate"]
    assert controls(running.core)["capture_enable"], "monitoring goes on"
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
    told = running.turn(bad)
    assert (told["result"], told["reason"]) == ("refused", "jump")
    assert (told["fault_head"], told["fault_sample"]) == (1, 500)
    assert "harmonics" not in told
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
    told = running.turn(turn())
    assert told["alarms"] == ["coefficients"]
    assert (told["result"], told["swaps"]) == ("kept", 0)
    assert not controls(running.core)["compensate"]


def test_a_stuck_capture_ends_in_the_safe_state(running: Firmware) -> None:
    running.turn(turn())
    position = running.core.get("snapshot.head1_position")
    running.core.set("snapshot.head1_position", position + 3 * COUNTS)
    running.step()
    assert controls(running.core)["compensate"]
    running.core.set("snapshot.head1_position", position + 5 * COUNTS)
    assert '"stuck_capture"' in running.step()
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
    told = running.turn(turn(Disc({1: (160.0, 0.4)}, alpha_deg=33.001), seed=3))
    assert told["alarms"] == ["noise", "error", "separation", "output", "overrun"]
    assert running.turn(turn(seed=5))["alarms"][-1] == "output", "an overrun is told once"


def test_a_turn_of_counts_that_the_core_refuses(running: Firmware) -> None:
    running.core.command = lambda word: None  # type: ignore[method-assign]
    assert running.send("set counts_per_rev 4096").startswith("ok")
    assert running.phase == "no_core"


def test_the_core_interrupts_when_a_bank_is_ready(running: Firmware) -> None:
    core = running.core
    assert core.get("interrupt_enable") == bit("interrupt_enable", "capture_ready")
    core.writes.clear()
    core.hand_over(turn())
    running.library.application_interrupt(running.application)
    assert (address("interrupt_status"), bit("interrupt_status", "capture_ready")) in core.writes
    running.step()
    assert (running.application.interrupts, running.application.banks_without_interrupt) == (1, 0)
    running.step(3)
    core.hand_over(turn(seed=2))
    running.step()
    assert running.application.turns == 2, "found all the same"
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
    busy = running.library.application_busy
    assert not busy(running.application)
    running.send("dump")
    running.core.hand_over(turn())
    running.step()
    assert running.phase == "dump"
    assert busy(running.application)


class Sensor:
    """A thermometer that may fail."""

    def __init__(self, firmware: Firmware) -> None:
        ffi, library = c_library()
        self.celsius: float | None = 40.0
        self.call = ffi.callback("temperature_read", self.read)
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
    assert running.turn(turn(seed=4))["temperature_c"] is None, "not the one before"
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
    assert head.endswith(" separation_deg=33.000000 temperature_c=40.00")
