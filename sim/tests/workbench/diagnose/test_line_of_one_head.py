"""Tests a line of an order that is not whole: an error of one head, or a motion of the axis that
head 1 must also show."""

from __future__ import annotations

import numpy as np
import pytest
from sim.tests.workbench.base_diagnosis import diagnosis_of
from sim.tests.workbench.small_sets import ALPHA, COUNTS_PER_REV, Float, measurement_set

from arctrue.measurement import MeasurementSet
from arctrue.workbench.effects.catalogue.bearing_ball_pass import BearingBallPass
from arctrue.workbench.observations.build import observations_of

ORDER = 13.7
TURNS_OF_THE_REFERENCE = 6
"""The stations of each cycle continue the angle of the cycle before."""


def _with_line(x_arcsec: float, y_arcsec: float, head2_arcsec: float) -> MeasurementSet:
    """Return a set with an ellipse of the axis and with a line of head 2 alone, both of ORDER."""
    measured = measurement_set(cycles=TURNS_OF_THE_REFERENCE)
    capture, reference = measured.capture, measured.reference
    assert capture is not None
    assert reference is not None

    def y(angle: Float) -> Float:
        return y_arcsec * np.sin(ORDER * angle)

    angle = 2.0 * np.pi / COUNTS_PER_REV * capture.head1_counts
    head2 = x_arcsec * np.cos(ORDER * angle) * np.sin(ALPHA) + y(angle) * np.cos(ALPHA)
    head2 += head2_arcsec * np.cos(ORDER * angle + 0.2)
    for counts, moved in ((capture.head1_counts, y(angle)), (capture.head2_counts, head2)):
        counts += np.round(moved / 3600.0 / 360.0 * COUNTS_PER_REV).astype(np.int64)
    reference.error_arcsec[:] += y(np.radians(reference.target_deg))
    return measured


@pytest.mark.large
def test_a_line_of_head_2_alone_is_no_motion_of_the_axis() -> None:
    """The line of 0.1″ would need a motion of 0.18″, of which head 1 shows 0 ± 0.02″."""
    found = diagnosis_of(_with_line(0.0, 0.0, 0.1))
    assert found.verdict in ("named", "ambiguous")
    assert found.effect_class[0] == "periodic_error"


@pytest.mark.large
def test_a_motion_that_head_1_shows_is_a_ball_pass() -> None:
    found = diagnosis_of(_with_line(0.2, 0.2, 0.0))
    assert (found.verdict, found.effect_class) == ("named", ["bearing_ball_pass"])


@pytest.mark.parametrize(
    ("y_arcsec", "sigma_arcsec", "refused"),
    [(0.0, 0.03, True), (0.0, 0.04, False), (0.05, 0.03, False), (1.0, 0.01, False)],
)
def test_a_motion_without_y_is_refused(y_arcsec: float, sigma_arcsec: float, refused: bool) -> None:
    """With x = 1″, the limit of y plus three standard uncertainties is 0.1″."""
    observations = observations_of(measurement_set())
    why = BearingBallPass().contradiction(
        np.array([1.0, 0.0, y_arcsec, 0.0]),
        np.diag([1e-4, 1e-4, sigma_arcsec**2, sigma_arcsec**2]),
        {"order": ORDER},
        observations,
    )
    assert (why is not None) == refused
