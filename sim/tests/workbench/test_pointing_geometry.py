"""Tests of leaning axes of a mount against rotations of the line of sight in three dimensions.

The tests use no formula of the effect: the axes of the mount turn a unit vector, and the angles of
this vector in the frame of the ground are the angles of the stars.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from arctrue.measurement import MeasurementSet, Reference, Table
from arctrue.workbench.diagnose.diagnosis import diagnose
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.inference.design_matrix import Term
from arctrue.workbench.inference.fit import fit
from arctrue.workbench.observations.build import observations_of

Float = NDArray[np.float64]

EFFECTS = built_in()
ARCSEC = np.pi / 648_000.0
NOISE_ARCSEC = 0.5
LEAN_X, LEAN_Y, SQUARENESS, COLLIMATION = -10.0, 4.0, 6.0, -8.0
"""Errors in arcseconds: tilt of the first axis about x and about y, deviation of the angle between
the axes from a right angle, and deviation of the line of sight."""


def _sky(azimuth: Float, elevation: Float) -> tuple[Float, Float]:
    """Return azimuth and elevation of the line of sight in radians, for these angles of the
    encoders."""
    lean = Rotation.from_euler("xy", [LEAN_X * ARCSEC, LEAN_Y * ARCSEC])
    square = Rotation.from_euler("x", SQUARENESS * ARCSEC)
    look = Rotation.from_euler("z", COLLIMATION * ARCSEC).apply([1.0, 0.0, 0.0])
    at = np.stack(
        [
            (
                lean * Rotation.from_euler("z", first) * square * Rotation.from_euler("y", -second)
            ).apply(look)
            for first, second in zip(azimuth, elevation, strict=True)
        ]
    )
    return np.arctan2(at[:, 1], at[:, 0]), np.arcsin(at[:, 2])


def _set(
    axis: int, conditions: tuple[str, ...], *, seed: int = 4, stars: int = 80, level: bool = False
) -> MeasurementSet:
    """Return a set with stars all over the sky, for the first or second axis (``axis`` 0 or 1);
    with ``level`` all stars have the same elevation."""
    random = np.random.default_rng(seed)
    encoder = random.uniform(0.0, 2.0 * np.pi, stars), np.radians(random.uniform(15, 80, stars))
    if level:
        encoder[1][:] = np.radians(45.0)
    seen = _sky(*encoder)
    error = np.angle(np.exp(1j * (encoder[axis] - seen[axis]))) / ARCSEC
    known = {
        "elevation_deg": np.degrees(seen[1]),
        "declination_deg": np.degrees(seen[1]),
        "azimuth_deg": np.degrees(seen[0]) % 360.0,
    }
    given: Mapping[str, Float] = {name: known[name] for name in conditions}
    reference = Reference(
        np.degrees(seen[axis]) % 360.0,
        error + 900.0 + random.normal(0.0, NOISE_ARCSEC, stars),
        time_s=np.arange(stars) * 60.0,
        conditions=given,
    )
    return MeasurementSet(table=Table(), capture=None, reference=reference, title="stars")


def _diagnosed(measurement: MeasurementSet):  # type: ignore[no-untyped-def]
    base = Term(EFFECTS["graduation_harmonics"](), {})
    return diagnose(observations_of(measurement), [base], EFFECTS)


@pytest.mark.parametrize(
    ("axis", "column"), [(0, "elevation_deg"), (0, "declination_deg"), (1, "azimuth_deg")]
)
def test_a_mount_that_leans_is_named(axis: int, column: str) -> None:
    found = _diagnosed(_set(axis, (column,)))
    assert found.verdict == "named", found.verdict
    assert found.named is not None
    assert found.named.name == "pointing_geometry"


def test_the_columns_take_the_rotations_away() -> None:
    """The columns of the effect explain the rotations: the squared residual of 80 stars with 0.5″
    of noise is a χ² with 75 degrees of freedom, and the bound is the 99.9 % point of χ²."""
    effect = EFFECTS["pointing_geometry"]()
    observations = observations_of(_set(0, ("elevation_deg",)))
    solution = fit([Term(effect, {})], observations)
    rows = observations.reference
    assert rows is not None
    columns = effect.reference_columns(rows, {}, solution.context)
    assert columns is not None
    left = rows.error_arcsec - columns @ solution.coefficients - solution.reference_offset_arcsec
    assert np.sum((left / NOISE_ARCSEC) ** 2) < 118.6
    values = {name: item.value for name, item in solution.parameters()[0].items()}
    # The lean is a vector: its length is equal in every frame in which the angle is counted.
    lean = np.hypot(values["tilt_cosine"], values["tilt_sine"])
    assert lean == pytest.approx(np.hypot(LEAN_X, LEAN_Y), abs=0.5)
    assert abs(values["squareness"]) == pytest.approx(SQUARENESS, abs=2.0)
    assert abs(values["collimation"]) == pytest.approx(-COLLIMATION, abs=2.5)


def test_a_table_without_such_a_column_is_not_asked_about_it() -> None:
    found = _diagnosed(_set(0, ()))
    assert "pointing_geometry" not in found.untestable
    assert found.named is None


def test_one_elevation_cannot_tell() -> None:
    """The effect cannot be tested with stars at a single elevation, because a lean then looks like
    order 1 of the azimuth."""
    found = _diagnosed(_set(0, ("elevation_deg",), level=True))
    assert "over 20° of the mount's other axis" in found.untestable["pointing_geometry"][0]
