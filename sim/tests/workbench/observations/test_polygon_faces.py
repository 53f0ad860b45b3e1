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


def test_a_polygon_half_a_face_away_from_zero_has_its_faces() -> None:
    """Stations in the middle between the nominal faces get the right faces, in a first run and in a
    second run on a turned polygon, although rounding puts half of them on each side of the
    middle."""
    half = STATIONS_DEG + 7.5
    for target in (half, half + 1e-10 * (-1.0) ** np.arange(FACES)):
        found = faces_of(FACES, _runs(FACES), target)
        assert found is not None
        assert np.mod(np.diff(found), FACES).tolist() == [1] * (FACES - 1)
        run = _runs(FACES, FACES)
        found = faces_of(FACES, run, np.concatenate([STATIONS_DEG, target]))
        assert found is not None
        assert found[:FACES].tolist() == list(range(FACES))
        assert np.mod(np.diff(found[FACES:]), FACES).tolist() == [1] * (FACES - 1)
        assert keep_to_faces(FACES, run, np.concatenate([STATIONS_DEG, target]))


def test_a_short_run_on_a_turned_polygon_leaves_the_faces_of_a_complete_run() -> None:
    """A complete run keeps its faces if a second, shorter run has the polygon turned."""
    target = np.concatenate([STATIONS_DEG, STATIONS_DEG[:10] + 5.0])
    run = _runs(FACES, 10)
    found = faces_of(FACES, run, target)
    assert found is not None
    assert found.tolist() == [*range(FACES), *range(10)]
    assert keep_to_faces(FACES, run, target)


def test_short_runs_at_the_same_stations_show_the_faces_together() -> None:
    """Runs of few stations each show together how the polygon stands on the table."""
    found = faces_of(FACES, _runs(10, 10, 4), STATIONS_DEG + 4.0)
    assert found is not None
    assert found.tolist() == list(range(FACES))


def test_two_readings_between_the_faces_show_no_turned_polygon() -> None:
    """Two readings 4° beyond their stations get the nearest faces of the polygon, which stands 5°
    from zero, and not those of a polygon that was turned by 4°."""
    target = np.concatenate([STATIONS_DEG + 5.0, [54.0, 69.0]])
    found = faces_of(FACES, _runs(FACES, 2), target)
    assert found is not None
    assert found[FACES:].tolist() == [3, 4]
    assert faces_of(FACES, _runs(360, 2), np.concatenate([np.arange(360.0), [54.0, 69.0]])) is None
