"""Provides the fixtures that set up the scene (instrument, table and firmware) of every fault
test."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import pytest
from sim.tests.faults.scene import Scene

MakeScene = Callable[..., Scene]


@pytest.fixture
def make_scene() -> Iterator[MakeScene]:
    """Return a function that makes scenes and takes the arguments of Scene."""
    made: list[Scene] = []

    def make(*arguments: Any, **named: Any) -> Scene:
        made.append(Scene(*arguments, **named))
        return made[-1]

    yield make
    for scene in made:
        scene.instrument.close()


@pytest.fixture
def scene(make_scene: MakeScene) -> Scene:
    """Return a new, calibrated scene whose table stands 0.3 of a turn after the index and whose
    recording has begun."""
    calibrated = make_scene()
    calibrated.calibrate()
    calibrated.to_part(0.3)
    calibrated.record()
    return calibrated
