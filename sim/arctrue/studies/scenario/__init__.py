"""Runs scenarios on the virtual instrument: long runs that a TOML file describes."""

from arctrue.studies.scenario.errors import ScenarioError
from arctrue.studies.scenario.reader import read_scenario
from arctrue.studies.scenario.result import ScenarioResult, ScenarioTurn
from arctrue.studies.scenario.runner import run_scenario
from arctrue.studies.scenario.scenario import Scenario

__all__ = [
    "Scenario",
    "ScenarioError",
    "ScenarioResult",
    "ScenarioTurn",
    "read_scenario",
    "run_scenario",
]
