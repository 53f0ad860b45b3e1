"""Evaluates simulated lives (the measurement sets of one table over two years), one set after the
other, and counts the false alarms and the true alarms before the limit."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy import stats

from arctrue.metrology.life.change import DAYS_A_YEAR, FEWEST_SETS, find_changes
from arctrue.metrology.life.forecast import forecast
from arctrue.metrology.life.history import FALSE_ALARMS_A_YEAR, HORIZON_DAYS
from arctrue.studies.life.lives import KINDS, LIMIT_ARCSEC, Life, simulated_life

CONFIDENCE = 0.95


@dataclass(frozen=True)
class Judged:
    """Alarms and forecast in one simulated life."""

    kind: str
    alarm_days: tuple[float, ...]
    """First day of every period in which the alarm is on, before the limit."""
    watched_days: float
    """Number of days on which an alarm is false: the days before the damage begins, or all days of
    a life that never reaches the limit."""
    onset_day: float
    limit_day: float
    covered: bool | None
    """Whether the interval that the first true alarm states contains the day of the limit; None if
    there is no true alarm."""

    @property
    def false_alarms(self) -> int:
        """Return the number of alarms before the damage begins; in a life that never reaches the
        limit, all alarms."""
        never = not np.isfinite(self.limit_day)
        return sum(never or day < self.onset_day for day in self.alarm_days)

    @property
    def in_time(self) -> bool:
        """Tell whether an alarm came after the beginning of the damage and before the limit."""
        return bool(np.isfinite(self.lead_days))

    @property
    def lead_days(self) -> float:
        """Return the days from the first true alarm to the limit; NaN if there is no alarm or no
        limit."""
        if not np.isfinite(self.limit_day):
            return np.nan
        times = [day for day in self.alarm_days if self.onset_day <= day < self.limit_day]
        return self.limit_day - times[0] if times else np.nan


def judge(life: Life, seed: int) -> Judged:
    """Evaluate a life after each of its measurement sets, like ``arctrue life``, until the first
    true alarm or the limit."""
    random = np.random.default_rng(seed)
    days = life.series.days
    alarms: list[float] = []
    on, covered = False, None
    for sets in range(FEWEST_SETS, days.size + 1):
        today = float(days[sets - 1])
        if today >= life.limit_day:
            break
        so_far = life.series.until(sets)
        changes = find_changes([so_far], FALSE_ALARMS_A_YEAR, random)
        found = forecast(so_far, changes, LIMIT_ARCSEC, random)
        alarm = found.alarm(HORIZON_DAYS)
        if alarm and not on:
            alarms.append(today)
            if covered is None and life.onset_day <= today and np.isfinite(life.limit_day):
                covered = found.earliest_day <= life.limit_day <= found.latest_day
        on = alarm
        if on and life.onset_day <= today and np.isfinite(life.limit_day):
            break
    end = min(float(days[-1]), life.limit_day)
    watched = end if not np.isfinite(life.limit_day) else min(life.onset_day, end)
    return Judged(life.kind, tuple(alarms), watched, life.onset_day, life.limit_day, covered)


def run_lives(task: Mapping[str, Any]) -> dict[str, Any]:
    """Do one task of a campaign: simulate and evaluate a life; return its alarms and its forecast
    as numbers."""
    kind, seed = str(task["kind"]), int(task["seed"])
    found = judge(simulated_life(kind, seed), seed)
    return {
        "kind": kind,
        "passes": bool(np.isfinite(found.limit_day)),
        "in_time": found.in_time,
        "false_alarms": found.false_alarms,
        "watched_days": found.watched_days,
        "lead_days": found.lead_days if found.in_time else None,
        "covered": found.covered,
    }


def tasks(lives: int, seed: int) -> list[dict[str, Any]]:
    """Return ``lives`` tasks; the kinds of life repeat in a fixed order."""
    kinds = list(KINDS)
    return [{"kind": kinds[number % len(kinds)], "seed": seed + number} for number in range(lives)]


def share_interval(count: int, of: int) -> tuple[float, float]:
    """Return Clopper and Pearson's 95 % interval of a share."""
    found = stats.binomtest(count, of).proportion_ci(CONFIDENCE, method="exact")
    return float(found.low), float(found.high)


def rate_interval(count: int, years: float) -> tuple[float, float]:
    """Return Garwood's 95 % interval of a Poisson rate, per year."""
    tail = 0.5 * (1.0 - CONFIDENCE)
    low = stats.chi2.ppf(tail, 2 * count) / 2.0 if count else 0.0
    return float(low / years), float(stats.chi2.ppf(1.0 - tail, 2 * count + 2) / 2.0 / years)


def summary(results: Sequence[Mapping[str, Any]]) -> list[dict[str, Any]]:
    """Return a row for each kind of life, and one for all lives."""
    rows = []
    for name in (*KINDS, "all"):
        own = [item for item in results if name in (item["kind"], "all")]
        passing = [item for item in own if item["passes"]]
        in_time = sum(item["in_time"] for item in passing)
        years = sum(item["watched_days"] for item in own) / DAYS_A_YEAR
        false = sum(item["false_alarms"] for item in own)
        leads = [item["lead_days"] for item in passing if item["lead_days"] is not None]
        held = [item["covered"] for item in passing if item["covered"] is not None]
        rows.append(
            {
                "kind": name,
                "lives": len(own),
                "passing": len(passing),
                "in_time": in_time,
                "in_time_interval": share_interval(in_time, len(passing)) if passing else None,
                "lead_days": float(np.median(leads)) if leads else None,
                "covered": sum(held),
                "forecasts": len(held),
                "years": years,
                "false_alarms": false,
                "false_interval": rate_interval(false, years) if years else None,
            }
        )
    return rows
