"""Tests that the demo's judgement accepts a right output and rejects each wrong one."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from arctrue.studies.demo.judgement import (
    OutputRecording,
    RecordingError,
    decode_recording,
    faults,
    index_offset_counts,
    output_score,
    pin_to_pin_latency,
)
from arctrue.studies.demo.scene import Scene, build_scene
from arctrue.studies.demo.settings import DemoSettings
from arctrue.table import PinEvents, pin_states

SETTINGS = DemoSettings(counts_per_rev=1 << 14, turns=2.4)
LATENCY = 37


@pytest.fixture(scope="module")
def scene() -> Scene:
    return build_scene(SETTINGS)


def follow(scene: Scene, position: NDArray[np.int64], latency: int = LATENCY) -> PinEvents:
    """Return the pin events of an output that moves to ``position``, which has one value per edge
    of head 1. The output moves by one count per clock, ``latency`` clocks after the edge."""
    clocks = np.ceil(scene.heads[0].time_s * SETTINGS.clock_hz).astype(np.int64) + latency
    shown = scene.heads[0].first_count
    free = 0
    at, count = [], []
    for clock, target in zip(clocks.tolist(), position.tolist(), strict=True):
        while shown != target:
            shown += 1 if target > shown else -1
            free = max(free + 1, clock)
            at.append(free)
            count.append(shown)
    states = pin_states(np.array(count), SETTINGS.counts_per_rev)
    first = pin_states(np.array([scene.heads[0].first_count]), SETTINGS.counts_per_rev)
    return PinEvents(int(first[0]), np.array(at), states)


def corrected(scene: Scene, share: float = 1.0) -> NDArray[np.int64]:
    """Return the corrected counts of head 1. After the index, the correction subtracts ``share``
    times the true error of head 1, without the error's mean."""
    count = scene.heads[0].count
    scale = SETTINGS.counts_per_rev / (2 * np.pi)
    error = count - scene.heads[0].true_angle_rad * scale
    error -= error[(count >= 0) & (count < SETTINGS.counts_per_rev)].mean()
    return count - np.where(count > 0, np.rint(share * error), 0).astype(np.int64)


def judged(scene: Scene, position: NDArray[np.int64], latency: int = LATENCY) -> list[str]:
    recording = decode_recording(follow(scene, position, latency))
    at_index = np.argmax(scene.heads[0].count >= 0)
    start = int(scene.heads[0].time_s[at_index] * SETTINGS.clock_hz) + latency + 100
    clocks = pin_to_pin_latency(scene, SETTINGS, recording)
    score = output_score(scene, SETTINGS, recording, start, clocks)
    return faults(score, index_offset_counts(scene, SETTINGS, recording, clocks), SETTINGS)


def test_true_correction_passes(scene: Scene) -> None:
    assert judged(scene, corrected(scene)) == []


def test_other_latency_is_measured_and_accounted(scene: Scene) -> None:
    assert judged(scene, corrected(scene), latency=90) == []


@pytest.mark.parametrize("share", [0.0, 0.9, -1.0])
def test_missing_correction_fails(scene: Scene, share: float) -> None:
    found = judged(scene, corrected(scene, share))
    assert any("order 1 still has" in text for text in found)


def test_small_order_left_behind_fails_by_its_order(scene: Scene) -> None:
    position = corrected(scene)
    ripple = np.rint(0.8 * np.cos(5 * scene.heads[0].true_angle_rad)).astype(np.int64)
    error = position + np.where(position > 100, ripple, 0)
    assert any("order 5 still has" in text for text in judged(scene, error))


def test_lost_count_fails(scene: Scene) -> None:
    position = corrected(scene)
    position[position > SETTINGS.counts_per_rev // 2] -= 4
    assert judged(scene, position) != []


def test_index_in_the_wrong_place_fails(scene: Scene) -> None:
    events = follow(scene, corrected(scene))
    shifted = np.roll(events.levels & 4, 5) | events.levels & 3
    recording = decode_recording(PinEvents(events.first_levels, events.clock, shifted))
    assert index_offset_counts(scene, SETTINGS, recording, LATENCY) == pytest.approx(5, abs=1)
    dumb = decode_recording(PinEvents(0, events.clock, events.levels & 3))
    with pytest.raises(RecordingError, match="never raised Z"):
        index_offset_counts(scene, SETTINGS, dumb, LATENCY)


def test_short_recording_is_refused(scene: Scene) -> None:
    events = follow(scene, corrected(scene))
    half = PinEvents(events.first_levels, events.clock[:9000], events.levels[:9000])
    with pytest.raises(RecordingError, match="expected a whole one"):
        output_score(scene, SETTINGS, decode_recording(half), 2000, LATENCY)


def test_illegal_output_is_refused() -> None:
    with pytest.raises(RecordingError, match="illegal transition at clock 20"):
        decode_recording(PinEvents(0, np.array([10, 20]), np.array([1, 2], dtype=np.uint8)))


def test_uneven_delay_and_dead_output_are_refused(scene: Scene) -> None:
    recording = decode_recording(follow(scene, corrected(scene)))
    late = recording.clock.copy()
    late[50] += 1
    with pytest.raises(RecordingError, match="varies from 37 to 38"):
        pin_to_pin_latency(scene, SETTINGS, replace(recording, clock=late))
    none = np.zeros(0, dtype=np.int64)
    empty = OutputRecording(none, none, none)
    with pytest.raises(RecordingError, match="is the output enabled"):
        pin_to_pin_latency(scene, SETTINGS, empty)
