"""Tests that each reading gets the right face of a polygon: at its stations, turned on the table,
and between the stations."""

from __future__ import annotations

import numpy as np

from arctrue.workbench.observations.polygon_faces import faces_of, keep_to_faces

FACES = 24
STATIONS_DEG = np.arange(FACES) * 15.0


def _runs(*sizes: int) -> np.ndarray:  # type: ignore[type-arg]
    return np.repeat(np.arange(len(sizes)), sizes)


def test_each_station_has_its_face_however_the_polygon_is_turned() -> None:
    target = np.concatenate([STATIONS_DEG, STATIONS_DEG + 5.0])
    run = _runs(FACES, FACES)
    found = faces_of(FACES, run, target)
    assert found is not None
    assert found.tolist() == 2 * list(range(FACES))
    assert keep_to_faces(FACES, run, target)


def test_a_pass_between_the_faces_is_read_with_the_nearest_one() -> None:
    """A pass between the faces is read with the nearest face: each face has 15 readings one degree
    apart, one at its station, and 7 on each side."""
    between = np.arange(360.0)
    target = np.concatenate([STATIONS_DEG, between])
    run = _runs(FACES, between.size)
    found = faces_of(FACES, run, target)
    assert found is not None
    assert found[:FACES].tolist() == list(range(FACES))
    expected = [face for face in range(FACES) for _ in range(15)]
    assert np.roll(found[FACES:], 7).tolist() == expected
    assert not keep_to_faces(FACES, run, target)


def test_without_a_run_at_the_faces_nothing_tells_how_the_polygon_stands() -> None:
    assert faces_of(FACES, _runs(360), np.arange(360.0)) is None
    assert faces_of(None, _runs(FACES), STATIONS_DEG) is None
