"""Counts how often the 95 % interval of a drift contains the true drift if the reference wanders.

Run ``python -m scripts.interval_coverage --sets 40``: each set has six cycles of 24 stations, a
drift of 1″/h, a random walk of 0.05″ per reading and 0.1″ of white noise.
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence

import numpy as np

import arctrue as at

TRUE_ARCSEC_H = 1.0
STEP_ARCSEC, WHITE_ARCSEC, READING_S = 0.05, 0.1, 10.0
LEVEL, NORMAL = 0.95, 1.96
NAME = "reference_drift.rate"


def drift_of(seed: int) -> at.FitParameter:
    """Return the fitted drift of one simulated set."""
    random = np.random.default_rng(seed)
    angle = np.tile(np.arange(24) * 15.0, 6)
    time_s = np.arange(angle.size) * READING_S
    noise = np.cumsum(random.normal(0.0, STEP_ARCSEC, angle.size))
    noise += random.normal(0.0, WHITE_ARCSEC, angle.size)
    error = 2.0 * np.cos(np.deg2rad(angle)) + TRUE_ARCSEC_H * time_s / 3600.0 + noise
    data = at.Dataset.from_arrays(
        reference={"target_deg": angle, "error_arcsec": error, "time_s": time_s}
    )
    model = at.Model().having("reference_drift", graduation_harmonics={"orders": [1]})
    return at.fit(data, model).params[NAME]


def main(arguments: Sequence[str] | None = None) -> None:
    """Fit all sets; print how many of the profile intervals and of the linear intervals contain the
    true drift."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--sets", type=int, default=40, help="how many (8 s each)")
    sets = parser.parse_args(arguments).sets
    profile = linear = 0
    for seed in range(sets):
        drift = drift_of(seed)
        low, high = drift.interval(LEVEL)
        profile += low <= TRUE_ARCSEC_H <= high
        linear += abs(drift.value - TRUE_ARCSEC_H) <= NORMAL * drift.stderr
    print(f"interval(0.95) holds the drift in {profile} of {sets} sets, ±1.96·stderr in {linear}")


if __name__ == "__main__":
    main()
