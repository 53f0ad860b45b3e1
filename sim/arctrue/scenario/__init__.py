"""Long runs on the virtual instrument, described in files that people can read."""

from arctrue.scenario.errors import ScenarioError
from arctrue.scenario.reader import read_scenario
from arctrue.scenario.result import ScenarioResult, Turn
from arctrue.scenario.runner import run_scenario
from arctrue.scenario.scenario import Scenario

__all__ = ["Scenario", "ScenarioError", "ScenarioResult", "Turn", "read_scenario", "run_scenario"]
