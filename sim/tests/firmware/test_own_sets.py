"""Tests of the sets (coefficients and weights) for a missing head that the device computes from its
own calibration.

The table has four heads with errors of mounting and index, an axis that moves, and noise; the
firmware reads only its captures. The test compares the words in the gateware's windows with numpy's
solution of the same turn and with the true angle.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from sim.tests.calibration.synthetic import COUNTS
from sim.tests.firmware.calibrator import BOTH_INDICES_SEEN, words_of_bank
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware, ModelCore, address, bit
from sim.tests.firmware.test_heads import DISC, PLACES, World
from sim.tests.firmware.test_prepared_sets import (
    FIRST_WINDOW,
    FURTHER_INDICES_SEEN,
    HEADS,
    LANES,
    WINDOW,
    FailoverCore,
)
from sim.tests.firmware.test_save import Board

from arctrue.calibration.head_weights import weight_words, weights_without_each
from arctrue.calibration.heads_on_device import heads_on_device, mean_orders
from arctrue.calibration.mean_banks import mean_angle_counts
from arctrue.gateware.coefficients import Coefficients, Extension
from arctrue.gateware.mean_set import MeanSet

ORDERS = 32
ARCSEC_PER_COUNT = 1_296_000.0 / COUNTS
AXIS = ((1, 0.0, 0.2j), (2, 0.4, 0.1), (3, 0.0, 0.3), (4.37, 0.95, 0.0))
WORLD = World(noise_arcsec=0.1, late_arcsec=(0.0,) * 4, samples=6000, axis=AXIS)
CHOICE = 0x820
COEFFICIENT_OFFSET = 0x83C


class FourHeadsCore(FailoverCore):
    """A model of the core with four heads, which read the simulated world."""

    def __init__(self) -> None:
        super().__init__()
        ffi, _ = firmware()
        self.further: Any = None
        self._further = ffi.callback(
            "core_capture_words", lambda *_: ffi.cast("int32_t *", self.further.ctypes.data)
        )
        self.access.further_capture = self._further

    def hand_over(self, counts: Any, flags: int = BOTH_INDICES_SEEN, travel: int = 0) -> None:
        ModelCore.hand_over(self, counts[:2], flags | FURTHER_INDICES_SEEN, travel)
        self.further = words_of_bank(counts[2:])
        for head, row in enumerate(counts, start=1):
            there = "snapshot." if head < 3 else ""
            last = "_" if head < 3 else "."
            self.set(f"{there}head{head}{last}turn_position", int(row[-1]))
            self.set(f"{there}head{head}{last}angle", int(row[-1]) % COUNTS)

    def set_of(self, number: int) -> Coefficients:
        """Return the coefficients that the gateware would load from the window of a set."""
        words = self.window(number)

        def signed(at: int) -> int:
            return int(np.array(words.get(at, 0), dtype=np.uint32).view(np.int32))

        lanes = range(LANES)
        steps = [words[16 * lane] | (words[16 * lane + 4] & 0xFFFF) << 32 for lane in lanes]
        choice = words[CHOICE]
        missing = [head for head in range(1, HEADS + 1) if not choice >> 3 + head & 1]
        mean = MeanSet(
            tuple(signed(0x810 + 4 * head) for head in range(HEADS)),
            tuple(words[0x800 + 4 * head] for head in range(HEADS)),
            1 + (choice & 3),
            missing[0] if missing else 0,
        )
        return Coefficients(
            np.array(steps, dtype=np.uint64),
            np.array([words[16 * lane + 8] for lane in lanes], dtype=np.uint32),
            np.array([signed(16 * lane + 12) for lane in lanes], dtype=np.int32),
            signed(COEFFICIENT_OFFSET),
            COUNTS,
            extension=Extension(mean=mean),
        )


def set_places(made: Firmware, world: World) -> None:
    made.send(f"set orders {ORDERS}")
    _, second, third, fourth = np.degrees(world.nominal_rad)
    for name, place in (("separation_deg", second), ("head3_deg", third), ("head4_deg", fourth)):
        assert made.send(f"set {name} {place:.6f}").startswith("ok")


def started(world: World) -> Firmware:
    """Return the firmware before its first turn; the console has set the places of the heads."""
    made = Firmware(FourHeadsCore())
    made.library.application_start(made.application)
    made.core.see_index()
    set_places(made, world)
    made.core.see_index()
    made.step()
    return made


def failover_is_on(running: Firmware) -> bool:
    return bool(running.core.get("failover") & bit("failover", "enable"))


@pytest.fixture(scope="module")
def calibrated() -> Firmware:
    running = started(WORLD)
    telemetry = running.turn(WORLD.counts())
    running.step(3)
    assert (telemetry["result"], telemetry["mean_of_heads"]) == ("applied", HEADS)
    return running


@pytest.mark.parametrize(("number", "at"), [(0, 12), (3, 12), (4, 0x810)])
def test_a_word_that_is_lost_while_it_is_written_keeps_the_failover_off(
    number: int, at: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The firmware finds an amplitude that is wrong by 6 counts, or a weight that is wrong by 0.19,
    in any set before it switches the failover on."""
    lost = FIRST_WINDOW + number * WINDOW + at

    class LossyCore(FourHeadsCore):
        def write(self, context: Any, offset: int, word: int) -> None:
            super().write(context, offset, word ^ 0x3000 if offset == lost else word)

    monkeypatch.setattr(f"{__name__}.FourHeadsCore", LossyCore)
    running = started(WORLD)
    running.core.hand_over(WORLD.counts())
    running.send("telemetry on")
    said = running.step(4)
    assert '"mean_of_heads":4' in said
    assert not failover_is_on(running)
    assert '"alarms":["coefficients"]' in said
    assert running.status("set_without_head") == []


def lane_orders(words: Coefficients) -> dict[int, complex]:
    """Return the complex amplitude of each lane in arcseconds, keyed by order."""
    orders = np.rint(words.phase_steps.astype(float) * COUNTS / 2.0**48).astype(int)
    amplitude = words.amplitudes / 2.0**11 * ARCSEC_PER_COUNT
    phase = 2.0 * np.pi * words.phase_offsets / 2.0**24
    found = amplitude * np.exp(1j * phase)
    return {int(n): complex(value) for n, value in zip(orders, found, strict=True) if n}


@pytest.mark.parametrize("missing", range(HEADS + 1))
def test_each_set_is_that_of_numpy(calibrated: Firmware, missing: int) -> None:
    """The sets of the firmware and of numpy agree: carrier, weights and offsets in every bit, and
    lanes within their quantisation.

    The amplitude of a lane is rounded to 2⁻¹¹ counts and its phase to 2⁻²⁴ turns.
    """
    words = calibrated.core.set_of(missing)
    assert words.extension is not None
    mean = words.extension.mean
    assert mean is not None
    every = calibrated.application.active.mean
    assert mean.offsets == tuple(every.offset)
    assert (mean.carrier, mean.missing) == (2 if missing == 1 else 1, missing)
    numpy = heads_on_device(WORLD.turns(), COUNTS, WORLD.nominal_rad, ORDERS)
    places = numpy.offsets_rad + numpy.late_rad
    if missing:
        exact = weights_without_each(places, numpy.ratios)[missing - 1]
        assert not isinstance(exact, Exception)
        assert mean.weights == tuple(weight_words(exact, places, numpy.ratios).tolist())
    else:
        assert mean.weights == tuple(every.weight)
    offsets_rad = np.array(mean.offsets) / (16.0 * COUNTS) * 2.0 * np.pi
    weights = np.array(mean.weights) / 65_536.0
    orders, constant, noise, by_places = mean_orders(numpy, weights, offsets_rad, mean.carrier - 1)
    found = lane_orders(words)
    for order, value in found.items():
        steps = np.sqrt(0.5) * ARCSEC_PER_COUNT / 2**11 + abs(value) * np.pi / 2**24
        assert abs(value - orders[order - 1]) < steps + 1e-9 * 144.0, order
    left = [n - 1 for n in range(1, ORDERS + 1) if n not in found]
    # The set omits orders that one turn cannot show, that is, orders below 5 standard
    # uncertainties.
    assert np.all(np.abs(orders[left]) < 5.0 * np.sqrt((noise + by_places)[left]))
    assert abs(words.offset / 2**11 * ARCSEC_PER_COUNT - constant) < ARCSEC_PER_COUNT / 2**11


@pytest.mark.parametrize("missing", range(HEADS + 1))
def test_each_set_corrects_another_turn(calibrated: Firmware, missing: int) -> None:
    """Each set corrects another turn: the result of the bit-true mean is within 0.04″ RMS of the
    true angle of the table.

    Rounding three heads to counts leaves up to 0.018″. One turn with 0.1″ of noise leaves about
    0.01″ in each of the six orders that have a lane: 0.03″ together. The zeros of all sets agree
    within 0.01″.
    """
    fresh = replace(WORLD, seed=9, noise_arcsec=0.0)

    def wrong(number: int) -> Any:
        angle = mean_angle_counts(calibrated.core.set_of(number), fresh.counts())
        turns = angle / COUNTS - fresh.theta() / (2.0 * np.pi)
        return (turns - np.rint(turns - turns[0])) * 1_296_000.0

    left = wrong(missing)
    assert np.std(left) < 0.04
    apart = np.mean(left - wrong(0)) / 1_296_000.0
    assert abs(apart - np.rint(apart)) * 1_296_000.0 < 0.01
    assert np.std(fresh.counts()[0] * ARCSEC_PER_COUNT - fresh.theta() * 648_000.0 / np.pi) > 100.0


def test_the_failover_is_on_and_off_while_words_change(calibrated: Firmware) -> None:
    assert failover_is_on(calibrated)
    assert calibrated.status("set_without_head") == ["1", "2", "3", "4"]
    on = False
    written = 0
    for at, word in calibrated.core.writes:
        if at == address("failover"):
            on = bool(word & 1)
        if FIRST_WINDOW <= at < FIRST_WINDOW + (HEADS + 1) * WINDOW:
            written += 1
            assert not on, f"{at:#x} is written while the gateware may load it"
    assert written > HEADS * LANES * 4


def test_telemetry_has_places_and_radii() -> None:
    """Places and radii agree with the simulated world within 4 of their own standard
    uncertainties."""
    world = replace(WORLD, ratios=(1.0, 1.001, 0.999, 1.0005), axis=())
    telemetry = started(world).turn(world.counts())
    places = np.degrees(world.true_rad)
    off = np.abs(np.array(telemetry["places_deg"]) - places) * 3600.0
    assert np.all(off <= 4.0 * np.array(telemetry["u_places_arcsec"]) + 1e-3)
    radii = np.abs(np.array(telemetry["radii"]) - 1.0 / np.array(world.ratios))
    assert np.all(radii <= 4.0 * np.array(telemetry["u_radii"]) + 1e-6)
    assert max(telemetry["u_radii"]) <= 0.0011, "0.1 mm, rectangular, on 53.975 mm"


def test_heads_whose_loss_leaves_too_much_noise_have_no_set(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """A head has no set if the mean without it would be too noisy or would need weights that the
    gateware cannot hold. Without head 4 the other three stand within 60°; their mean would need a
    weight of −6.5, and the gateware holds −2 to 2."""
    places = (0.0, 30.0, 60.0, 200.0)
    monkeypatch.setitem(PLACES, HEADS, places)
    running = started(WORLD)
    telemetry = running.turn(WORLD.counts())
    running.step(3)
    assert telemetry["mean_of_heads"] == HEADS
    noises = [
        np.inf if isinstance(one, Exception) else float(np.linalg.norm(one))
        for one in weights_without_each(np.radians(places), noise_limit=np.inf)
    ]
    quiet = [str(head) for head, noise in enumerate(noises, start=1) if noise <= 1.0]
    assert "4" not in quiet
    assert running.status("set_without_head") == quiet
    for head in range(1, HEADS + 1):
        opened = running.core.window(head)[CHOICE] != 0
        assert opened == (str(head) in quiet)
    assert failover_is_on(running) == bool(quiet)


def test_a_turn_while_a_head_is_left_out_takes_its_new_set(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """The firmware activates the new set without head 2: head 2 counts again, but is left out until
    it passes its index."""
    running = started(WORLD)
    running.turn(WORLD.counts())
    running.step(3)
    before = running.core.window(2)
    running.core.status(left_out=0b0010, active=2)
    running.core.writes.clear()
    # The disc's order 2 grows by 1″, so that the new turn is better than the active lanes.
    monkeypatch.setitem(DISC, 2, (7.0, 4.2))
    assert running.turn(replace(WORLD, seed=5).counts())["result"] == "applied"
    running.step(3)
    swap = (address("command"), bit("command", "swap"))
    assert swap not in running.core.writes
    assert (address("heads_command"), 1 << 7 | 2 << 4) in running.core.writes
    assert running.core.window(2) != before
    assert failover_is_on(running)


class BoardWithFourHeads(Board):
    """A board whose core has four heads; ``power_on`` keeps only the flash chip."""

    failover = True

    def new_core(self) -> ModelCore:
        core = FourHeadsCore()
        if not self.failover:
            core.set("capability", HEADS | 1 << 3)
        return core


def ready(board: BoardWithFourHeads) -> None:
    """Let the board calibrate its mean of four heads from one turn."""
    set_places(board.firmware, WORLD)
    board.core.see_index()
    board.firmware.step()
    assert board.firmware.turn(WORLD.counts())["mean_of_heads"] == HEADS
    board.firmware.step(3)


def windows(board: BoardWithFourHeads) -> list[dict[int, int]]:
    return [board.core.window(number) for number in range(1, HEADS + 1)]


def test_saved_sets_outlive_the_power() -> None:
    """A turn confirms the saved mean; then every word of every window has the value from before
    power-off."""
    board = BoardWithFourHeads()
    ready(board)
    before = windows(board)
    assert board.order("save").startswith("ok, record 1: ")
    board.power_on()
    assert windows(board) == [{}] * HEADS, "the gateware was without power"
    assert board.status("saved") == ["waiting"]
    # A second save, before a turn has confirmed the record, keeps the sets that the record
    # contains.
    assert board.order("save").startswith("ok, record 2: ")
    board.power_on()
    board.core.writes.clear()
    assert board.firmware.turn(replace(WORLD, seed=7).counts())["alarms"] == []
    board.firmware.step(3)
    assert board.status("saved") == ["confirmed"]
    assert windows(board) == before
    assert board.status("set_without_head") == ["1", "2", "3", "4"]
    assert failover_is_on(board.firmware)
    # The restored set now counts as a loaded one; a save stores it again with its sets.
    assert board.order("save").startswith("ok, record 3: ")
    board.power_on()
    board.firmware.turn(replace(WORLD, seed=8).counts())
    board.firmware.step(3)
    assert windows(board) == before


def test_a_record_without_sets_and_a_core_without_failover() -> None:
    """The firmware accepts a record without sets, as an older firmware writes it. From a record
    with sets it restores only the mean if the core has no failover."""
    board = BoardWithFourHeads()
    board.failover = False
    board.power_on()
    ready(board)
    assert board.order("save").startswith("ok, record 1: ")
    board.failover = True
    board.power_on()
    board.firmware.turn(replace(WORLD, seed=7).counts())
    board.firmware.step(3)
    assert board.status("saved") == ["confirmed"]
    assert board.status("set_without_head") == []
    assert not failover_is_on(board.firmware)

    board.firmware.send("forget")
    ready(board)
    assert failover_is_on(board.firmware)
    assert board.order("save").startswith("ok, record 2: ")
    board.failover = False
    board.power_on()
    board.firmware.turn(replace(WORLD, seed=7).counts())
    board.firmware.step(3)
    assert board.status("saved") == ["confirmed"]
    beyond = FIRST_WINDOW + (HEADS + 1) * WINDOW
    assert not [at for at, _ in board.core.writes if FIRST_WINDOW <= at < beyond]


def test_words_that_the_gateware_lost_are_not_saved() -> None:
    board = BoardWithFourHeads()
    ready(board)
    board.core.words[FIRST_WINDOW + 3 * WINDOW + 0x810] ^= 1
    assert board.order("save").startswith("ok, record 1: ")
    board.power_on()
    board.firmware.turn(replace(WORLD, seed=7).counts())
    board.firmware.step(3)
    assert board.status("saved") == ["confirmed"]
    assert board.status("set_without_head") == []


def kept_from(core: FourHeadsCore) -> Any:
    ffi, library = firmware()
    kept = ffi.new("struct kept_sets *")
    for head in range(1, HEADS + 1):
        one = ffi.new("struct coefficients *", {"lanes": LANES, "counts_per_rev": COUNTS})
        library.core_read_prepared(core.access, head, one)
        assert library.kept_sets_add(kept, head, one)
    return kept


def test_kept_sets_that_do_not_fit_are_refused(calibrated: Firmware) -> None:
    """The firmware refuses a kept record with one of these changes, which gives a mean, a lane or a
    length that the gateware cannot hold."""
    ffi, library = firmware()
    good = kept_from(calibrated.core)
    assert library.kept_sets_are_valid(good, HEADS, COUNTS)
    assert not library.kept_sets_are_valid(good, 3, COUNTS)
    assert not library.kept_sets_are_valid(good, HEADS, COUNTS // 64), "offsets beyond the turn"

    def judged(place: int, word: int) -> bool:
        changed = ffi.new("struct kept_sets *", good[0])
        changed.word[place] = word
        return bool(library.kept_sets_are_valid(changed, HEADS, COUNTS))

    assert judged(0, good.word[0])
    for place, word in (
        (0, good.word[0] & ~0xFF),  # no head
        (0, good.word[0] & ~0xFF | 5),
        (0, good.word[0] & ~0xFF | 2),  # the weight of head 2 is not 0
        (0, good.word[0] | 33 << 8),  # more lanes than words
        (2, good.word[2] & ~3),  # head 1 is both missing and the carrier
        (2, good.word[2] | 1 << 4),
        (3, 1),  # the sum of the weights is not 1
        (7, COUNTS * 16),
        (11, good.word[11] & 0xFFFFFF),  # a lane of order 0
    ):
        assert not judged(place, word & 0xFFFFFFFF), (place, hex(word))
    short = ffi.new("struct kept_sets *", good[0])
    short.number -= 1
    assert not library.kept_sets_are_valid(short, HEADS, COUNTS)
