"""Tests that a misspelt key in a file that users write is refused or reported, and never ignored.

The tests misspell every key of an example file in turn, except the names in NAMED_BY_THE_EFFECT.
The expected message names the file, the misspelt key and the right key.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest
import tomli_w

from arctrue.gateware.coefficient_file import CoefficientFileError, read_coefficient_file
from arctrue.measurement import MeasurementError, read_measurement_set
from arctrue.studies.scenario.errors import ScenarioError
from arctrue.studies.scenario.reader import read_scenario
from arctrue.workbench.model.model_file import ModelFileError, read_model

MODEL = """
schema = 1
effect_folders = ["own"]
reference_offset_arcsec = 0.5
reference_temperature_c = 20.0
[table]
counts_per_rev = 16777216
head_separation_deg = 33.0
[[effect]]
name = "vibration"
columns = ["cosine", "sine"]
coefficients = [1.0, 2.0]
[effect.settings]
[effect.search]
frequency = 3.5
[effect.parameters.amplitude]
value = 1.0
sigma = 0.1
unit = "arcsec"
[[history]]
action = "add"
effect = "vibration"
measurement = "set"
date = "2026-01-01"
program = "arctrue"
measurement_sha256 = "00"
[history.rms_arcsec]
[history.peak_arcsec]
[history.heldout_rms_arcsec]
[history.noise_arcsec]
"""
COEFFICIENTS = """
schema = 2
title = "A rotary table"
counts_per_rev = 16777216
lanes = 2
[temperature]
reference_c = 20.0
sensor_time_constant_s = 0.0
[offset]
counts = 0.0
word = 0
[[lane]]
lane = 0
order = 0
amplitude_arcsec = 0.0
phase_deg = 0.0
phase_step = 0
phase_offset = 0
amplitude = 0
slope_arcsec_per_k = [0.0, 0.0]
slope_arcsec_per_k2 = [0.0, 0.0]
slope = [0, 0, 0, 0]
"""
SCENARIO = """
format = 1
title = "All keys"
about = "none left out"
[scale]
lines = 1024
interpolation = 1024
lanes = 4
samples = 1200
clocks_per_count = 1.1
seed = 1
[table]
errors = "paper"
separation_error_arcsec = 0.0
noise_arcsec = 0.2
[motion]
speed_deg_s = 30.0
ripple_deg = 0.0
ripple_order = 7
legs = [{turns = 3}, {pause_s = 600.0, run_s = 0.5}]
[[temperature]]
celsius = 20.0
at_turn = 0.0
after_s = 0.0
[[cause]]
name = "shaft_wind_up"
arcsec = 1.0
[[fault]]
what = "pins"
pins = ["head2.a"]
act = "low"
probability = 0.5
at_turn = 1.0
for_turns = 0.5
for_s = 0.0
text = "head 2 is cut off"
[firmware]
recalibrate = "every_turn"
orders = 32
calculation_s = 0.25
thermometer = "none"
keep = 0
filter_length = 3
[record]
orders = [1.0, 2.0]
faces = 24
"""
MEASUREMENT = """
schema = 1
title = "A rotary table"
[table]
counts_per_rev = 16777216
head_separation_deg = 33.0
index_detection_arcsec = 10.0
grating_lines = 16384
disc_diameter_mm = 107.95
drive_gear_teeth = 180
faces = 24
index_repeatability_counts = 0.5
[reference]
file = "reference.csv"
instrument = "polygon"
faces = 24
standard_uncertainty_arcsec = 0.15
clock_offset_s = 0.0
[origin]
command = "arctrue import"
program = "arctrue 0.1.0"
"""
NAMED_BY_THE_EFFECT = ("amplitude", "frequency")
"""Names of a fitted parameter and of a search parameter, which are not keys of the format; only the
effect defines them."""


def _wrong(key: str) -> str:
    return key[:2] + key[1:]


def _misspelt(content: Any) -> Iterator[tuple[str, Any]]:
    """Yield each key of the content, with a copy of the content in which one letter of the key is
    doubled."""
    if isinstance(content, list):
        for place, item in enumerate(content):
            for key, changed in _misspelt(item):
                yield key, [*content[:place], changed, *content[place + 1 :]]
    if isinstance(content, dict):
        for key, value in content.items():
            if key not in NAMED_BY_THE_EFFECT:
                yield (
                    key,
                    {(_wrong(key) if name == key else name): content[name] for name in content},
                )
            for inner, changed in _misspelt(value):
                yield inner, {**content, key: changed}


def _refusal(
    read: Callable[[Path], object], error: type[Exception], file: str
) -> Callable[[Path, str], str]:
    """Return a function that writes a text to a file of this name and returns the message of
    ``read``.

    The message is empty if ``read`` accepts the text.
    """

    def said(folder: Path, text: str) -> str:
        path = folder / file
        path.write_text(text, encoding="utf-8")
        try:
            read(path)
        except error as raised:
            return str(raised)
        return ""

    return said


def _measurement(folder: Path, text: str) -> str:
    """Read a set; return the message or the warning about an unknown key."""
    (folder / "reference.csv").write_text("target_deg,error_arcsec\n0.0,0.0\n15.0,1.0\n")
    warnings: list[str] = []
    refused = _refusal(
        lambda path: warnings.extend(read_measurement_set(path.parent).warnings),
        MeasurementError,
        "measurement.toml",
    )(folder, text)
    return refused or "\n".join(warnings)


FILES: dict[str, tuple[str, Callable[[Path, str], str]]] = {
    "model": (MODEL, _refusal(read_model, ModelFileError, "model.toml")),
    "coefficients": (
        COEFFICIENTS,
        _refusal(read_coefficient_file, CoefficientFileError, "coefficients.toml"),
    ),
    "scenario": (SCENARIO, _refusal(read_scenario, ScenarioError, "scenario.toml")),
    "measurement": (MEASUREMENT, _measurement),
}


@pytest.mark.parametrize("kind", FILES)
def test_every_misspelt_key_is_reported(tmp_path: Path, kind: str) -> None:
    text, said_of = FILES[kind]
    assert said_of(tmp_path, text) == ""
    keys = list(_misspelt(tomllib.loads(text)))
    assert len(keys) > 15
    for key, content in keys:
        said, wrong = said_of(tmp_path, tomli_w.dumps(content)), _wrong(key)
        assert str(tmp_path) in said, key
        # If the key is required, the message says first that the key is missing.
        assert f"{key}: is missing" in said or (wrong in said and key in said), (key, said)
