"""Tests that no effect can change the rows to which other effects are fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from arctrue.workbench.observations.build import observations_of
from tests.workbench.small_sets import measurement_set


def test_no_column_of_the_rows_can_be_written() -> None:
    rows = observations_of(measurement_set()).capture
    assert rows is not None
    loaded = replace(rows, conditions={"load": np.zeros(rows.run.size)})
    for columns in (loaded, loaded.part(slice(10))):
        with pytest.raises(ValueError, match="read-only"):
            columns.angle_rad[0] = 1.0
        with pytest.raises(ValueError, match="read-only"):
            columns.conditions["load"][0] = 1.0
