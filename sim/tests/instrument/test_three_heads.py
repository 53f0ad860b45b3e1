"""Tests the device with three heads: the core has no words for head 4 and refuses access to them.

The instrument raises an error for each access that the core refuses, as the processor does.
"""

from __future__ import annotations

import numpy as np
import pytest

from arctrue.studies.heads.device import HeadsDevice
from arctrue.studies.revolution.settings import RevolutionSettings

PLACES_DEG = (0.0, 118.0, 237.0)
SETTINGS = RevolutionSettings(
    lines=256, lanes=4, samples=1600, orders=8, noise_arcsec=0.0, clocks_per_count=1.15
)


@pytest.mark.large
def test_three_heads_calibrate_their_mean_and_fresh_turns_agree() -> None:
    """The firmware calibrates the mean of three heads by itself; in fresh turns the output differs
    from the true angle by its rounding.

    The output is rounded to counts: 1/√12 count RMS. The bound adds the rounding of the mean, at
    most that of one head, and a tenth of a count for the calibration from rounded readings.
    """
    with HeadsDevice(SETTINGS, places_deg=PLACES_DEG) as device:
        device.calibrate_alone()
        device.turn_before()
        first = device.accepted_turn()
        assert (first["result"], first["mean_of_heads"]) == ("applied", len(PLACES_DEG))
        assert device.accepted_turn()["alarms"] == []
        output, head1 = device.record()
    count = SETTINGS.arcsec_per_count
    rounding = count / np.sqrt(12.0)
    assert float(np.std(head1.error_arcsec)) > 50.0, "the disc is eccentric"
    assert float(np.std(output.error_arcsec)) < np.sqrt(2.0) * rounding + 0.1 * count
