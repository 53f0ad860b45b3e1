"""Finds changes, outdated calibrations and forecasts in the sets of one machine."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from arctrue.base.similar import did_you_mean
from arctrue.metrology.budget import COVERAGE
from arctrue.metrology.life.change import Change, basis, find_changes, look_probability
from arctrue.metrology.life.forecast import Forecast, forecast
from arctrue.metrology.life.machine import FittedSet, Machine
from arctrue.metrology.life.series import Series, series_of

FALSE_ALARMS_A_YEAR = 0.5
"""Expected number of false changes a year of a machine that is evaluated after every set."""
HORIZON_DAYS = 30.0
"""Time in days; a change that may lead to the limit within this time causes an alarm."""


@dataclass(frozen=True, eq=False)
class Calibration:
    """A measurement set from which a calibration was made, and the changes that make this
    calibration invalid."""

    of: FittedSet
    broken_by: tuple[Change, ...]
    """Changes that may have begun after the set, and drifts that have grown significantly since the
    set, earliest first; empty if the calibration is still valid."""

    @property
    def broken_since_day(self) -> float:
        """Day on which the first change of ``broken_by`` begins, but not before the day of the set;
        infinite if the calibration is still valid."""
        return max(min((one.day for one in self.broken_by), default=np.inf), self.of.day)


@dataclass(frozen=True, eq=False)
class LifeHistory:
    """The history of one machine."""

    machine: Machine
    series: tuple[Series, ...]
    changes: tuple[Change, ...]
    forecasts: tuple[Forecast, ...]
    calibrations: tuple[Calibration, ...]
    false_alarms_a_year: float
    horizon_days: float

    @property
    def look_probability(self) -> float:
        """Permitted probability that this evaluation reports at least one false change."""
        return look_probability(self.machine.days, self.false_alarms_a_year)

    @property
    def alarms(self) -> tuple[Forecast, ...]:
        """Forecasts for which the user should act."""
        return tuple(one for one in self.forecasts if one.alarm(self.horizon_days))

    def changes_of(self, series: Series) -> list[Change]:
        """Return the changes of one series, earliest first."""
        return [one for one in self.changes if one.series.name == series.name]


def history_of(
    machine: Machine,
    limits: Mapping[str, float],
    *,
    false_alarms_a_year: float = FALSE_ALARMS_A_YEAR,
    horizon_days: float = HORIZON_DAYS,
    seed: int = 1,
) -> LifeHistory:
    """Find the changes of every parameter, and forecast when each limit of ``limits`` is passed.

    ``limits``: limits by the name of an effect (for each of its parameters in arcseconds) or by the
    names of effect and parameter (in the parameter's unit). ``seed``: seed of the random draws.
    Raises ValueError for an unknown name or a limit that is not positive.
    """
    random = np.random.default_rng(seed)
    series = series_of(machine.days, [one.parameters for one in machine.sets])
    limited = limits_of(series, limits)
    changes = find_changes(series, false_alarms_a_year, random)
    forecasts = [
        forecast(one, [item for item in changes if item.series is one], limited[one.name], random)
        for one in series
        if one.name in limited
    ]
    changes.sort(key=lambda change: change.day)
    calibrations = [
        Calibration(one, tuple(item for item in changes if _breaks(item, number)))
        for number, one in enumerate(machine.sets)
    ]
    return LifeHistory(
        machine,
        tuple(series),
        tuple(changes),
        tuple(forecasts),
        tuple(calibrations),
        false_alarms_a_year,
        horizon_days,
    )


def _breaks(change: Change, number: int) -> bool:
    """Tell whether this change makes the calibration from set ``number`` invalid for the last set.

    This is so if the change may be later than set ``number``, or if it is a drift that has since
    grown by more than ``COVERAGE`` standard uncertainties of the two fits.
    """
    series = change.series
    if change.latest_day > float(series.days[number]):
        return True
    if change.kind == "step":
        return False
    best = max(change.places, key=lambda place: place.probability)
    since = change.size * (1.0 - float(basis(series.days, *best.shape)[number]))
    return since > COVERAGE * float(np.hypot(series.u[number], series.u[-1]))


def limits_of(series: list[Series], limits: Mapping[str, float]) -> dict[str, float]:
    """Return the limit of each series that has one. Raises ValueError for an unknown name or a
    limit that is not positive."""
    found: dict[str, float] = {}
    effects = {one.name.rpartition(".")[0] for one in series}
    for name, limit in limits.items():
        if not limit > 0.0:
            raise ValueError(f"--limit {name}: expected a size above 0, found {limit:g}")
        own = [
            one.name
            for one in series
            if one.name == name or (one.name.rpartition(".")[0] == name and one.unit == "arcsec")
        ]
        if not own:
            known = sorted({*effects, *(one.name for one in series)})
            raise ValueError(
                f"--limit {name}: there is no parameter of that name, and no effect of that name "
                f"has a parameter in arcseconds.{did_you_mean(name, known)} The effects are: "
                f"{', '.join(sorted(effects))}; write a parameter as EFFECT.PARAMETER"
            )
        found |= dict.fromkeys(own, limit)
    return found
