"""Tests which values the reader takes from scenario files, which files it refuses, and with which
messages."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from arctrue.gateware.coefficient_file import write_coefficient_file
from arctrue.gateware.coefficients import Coefficients
from arctrue.instrument import HEAD1_A, HEAD2_Z
from arctrue.studies.scenario import ScenarioError, read_scenario
from arctrue.studies.scenario.reader import NAMES
from arctrue.table.causes.thermal_centre import ThermalCentre
from arctrue.table.registry import CAUSES, REGISTRY
from arctrue.workbench.effects.registry import ORDER, built_in

SHIPPED = sorted((Path(__file__).resolve().parents[3] / "scenarios").glob("*.toml"))

LEAST = """
format = 1
title = "least"
[motion]
legs = [{ turns = 2 }]
"""


def _file(folder: Path, text: str) -> Path:
    file = folder / "some.toml"
    file.write_text(text, encoding="utf-8")
    return file


def test_the_least_that_a_file_says(tmp_path: Path) -> None:
    scenario = read_scenario(_file(tmp_path, LEAST))
    assert scenario.scale.counts_per_rev == 1 << 20
    assert scenario.legs[0].speed_rad_s == pytest.approx(np.deg2rad(30))
    assert scenario.causes == ()


def test_values_reach_the_scenario(tmp_path: Path) -> None:
    text = (
        LEAST
        + """
[[cause]]
name = "thermal_centre"
um_per_k = 2
direction_deg = 90
[[fault]]
what = "pins"
pins = ["head1.a", "head2.z"]
act = "high"
at_turn = 1.5
for_turns = 0.25
"""
    )
    scenario = read_scenario(_file(tmp_path, text))
    (cause,) = scenario.causes
    assert isinstance(cause.physical, ThermalCentre)
    assert cause.physical.rate_m_per_k == pytest.approx(2e-6j)
    (fault,) = scenario.faults
    assert fault.pins == HEAD1_A | HEAD2_Z
    begin, end = fault.span_s(scenario.course())
    # The fault lasts for a quarter of a turn at 30°/s.
    assert end - begin == pytest.approx(3.0)


def test_coefficients_are_read_next_to_the_scenario(tmp_path: Path) -> None:
    """The reader finds coefficients next to the scenario: a relative path starts at the folder of
    the scenario. The message about a bad file names its key."""
    bank = Coefficients.from_harmonics([3], [2.5], [0.4], 1 << 20, 4)
    write_coefficient_file(tmp_path / "lanes.toml", bank)
    text = LEAST + '[firmware]\ncoefficients = "lanes.toml"\nthermometer = "table"\nheal = 1\n'
    firmware = read_scenario(_file(tmp_path, text)).firmware
    assert firmware.loaded == bank
    assert firmware.thermometer
    assert firmware.parameters == (("heal", 1),)
    (tmp_path / "lanes.toml").unlink()
    with pytest.raises(ScenarioError, match=r"some\.toml: firmware\.coefficients: .*no such file"):
        read_scenario(_file(tmp_path, text))


def test_a_long_motion_keeps_no_more_edges_than_fit(tmp_path: Path) -> None:
    """The scenario records every 17th edge with 2²⁰ counts; for 1,000 turns it omits more edges, so
    that it records at most 4 million edges in total."""
    short = read_scenario(_file(tmp_path, LEAST))
    assert short.kept_every == 17
    long = read_scenario(_file(tmp_path, LEAST.replace("turns = 2 ", "turns = 1000 ")))
    assert long.kept_every % 2 == 1
    kept = 1000 * (1 << 20) / long.kept_every
    assert 0.9 * (1 << 22) < kept <= 1 << 22


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("format = 2", ["format", "expected 1", "found 2"]),
        ("format = [", ["is not TOML"]),
        (LEAST.replace('title = "least"', ""), ["title: is missing", "expected a text"]),
        (LEAST + "[scale]\nline = 5", ["scale.line: is not known", "did you mean lines or lanes?"]),
        (
            LEAST + "[scale]\nlines = 8",
            ["scale.lines", "a whole number from 16 to 16384", "found 8"],
        ),
        (LEAST + "[scale]\nlines = true", ["scale.lines", "found true"]),
        (LEAST + "[scale]\nlines = 64\ninterpolation = 5.5", ["scale.interpolation", "5.5"]),
        (LEAST + "[table]\nnoise_arcsec = nan", ["table.noise_arcsec", "found nan"]),
        (
            LEAST + '[[cause]]\nname = "thermal_center"',
            ["cause[1].name", 'found "thermal_center"; did you mean "thermal_centre"?'],
        ),
        (
            LEAST + '[[cause]]\nname = "thermal_centre"\num = 3',
            ["cause[1].um: is not known", "there are: name, um_per_k"],
        ),
        (
            LEAST + '[[cause]]\nname = "shaft_wind_up"\narcsec = 1\nteeth = 3',
            ["cause[1].teeth: is not known", "name, arcsec, stroke_deg"],
        ),
        (LEAST + "[[temperature]]\nat_turn = 3\ncelsius = 20", ["temperature[1].at_turn", "2"]),
        (
            LEAST + '[[fault]]\nwhat = "hung_processor"\nat_turn = 2.5\nfor_s = 1',
            ["fault[1].at_turn", "less than the 2 turns", "2.5"],
        ),
        (LEAST + '[[fault]]\nwhat = "hung_processor"\nat_turn = 1', ["for_turns or for_s above 0"]),
        (
            LEAST + '[[fault]]\nwhat = "pins"\npins = ["head3.a"]\nat_turn = 1\nfor_s = 1',
            ["fault[1].pins", '"head1.a"', "head3.a"],
        ),
        (LEAST.replace("turns = 2", "pause_s = 5"), ["motion.legs", "must turn the table"]),
        (LEAST.replace("turns = 2", "turns = 2, pause_s = 5"), ["either turns or pause_s"]),
        (LEAST.replace("{ turns = 2 }", ""), ["motion.legs", "a list of legs"]),
        (
            LEAST.replace("{ turns = 2 }", "{ turns = 2 }, { turns = 1, speed_deg_s = 3000 }"),
            ["samples", "32 orders need 66"],
        ),
        (LEAST.replace("[motion]", "[motion]\nripple_deg = 10"), ["motion.ripple_deg", "8.1"]),
        (LEAST + "[limits]\ncorrected_rms_arcsec = 1\nfrom_turn = 4", ["limits.from_turn", "4"]),
        (LEAST + '[limits]\nflags_wanted = ["head1.bad"]', ["limits.flags_wanted", "head1.bad"]),
        (LEAST + '[firmware]\nrecalibrate = "often"', ["firmware.recalibrate", '"every_turn"']),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, said: list[str]) -> None:
    file = _file(tmp_path, text)
    with pytest.raises(ScenarioError) as error:
        read_scenario(file)
    assert str(error.value).startswith(str(file))
    assert [part for part in said if part not in str(error.value)] == [], str(error.value)


def test_a_file_that_is_not_there(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="no such file"):
        read_scenario(tmp_path / "none.toml")


@pytest.mark.parametrize("file", SHIPPED, ids=lambda file: file.stem)
def test_every_shipped_file_can_be_read(file: Path) -> None:
    scenario = read_scenario(file)
    assert scenario.about
    # Every shipped scenario states limits.
    assert scenario.limits.without_arcsec() != scenario.limits or scenario.limits.flags_wanted
    assert scenario.table().reading_rad(0, scenario.course().state(np.array([1.0]))).shape == (1,)


def test_the_former_spelling_of_a_cause_is_still_read(tmp_path: Path) -> None:
    now = LEAST + '[[cause]]\nname = "thermal_centre"\num_per_k = 2\n'
    former = now.replace("[[cause]]", "[[effect]]").replace("name =", "cause =")
    assert former != now
    first, second = (read_scenario(_file(tmp_path, text)) for text in (now, former))
    assert first.causes == second.causes != ()


def test_every_effect_of_the_catalogue_has_a_file() -> None:
    names = {file.stem for file in SHIPPED}
    # An effect that only describes an observation has no cause that could be simulated.
    causeless = {name for name, effect in built_in().items() if effect.unspecific}
    assert causeless == {"periodic_error"}
    # A mount's pointing error needs a second axis, which the table does not have.
    assert set(ORDER) - names == causeless | {"pointing_geometry"}
    for file in SHIPPED:
        causes = {cause.name for cause in read_scenario(file).causes}
        named = {recipe.name for recipe in REGISTRY.values() if recipe.cause in causes}
        # In the simulator a single cause covers graduation errors of any order, and lost counts are
        # a fault.
        if file.stem in ORDER and file.stem not in ("graduation_harmonics", "count_slip"):
            assert file.stem in named


@pytest.mark.parametrize("name", sorted(set(CAUSES) - set(NAMES)))
def test_a_cause_that_the_instrument_cannot_honour_is_refused(tmp_path: Path, name: str) -> None:
    with pytest.raises(ScenarioError, match=f"can simulate \\({name} acts on"):
        read_scenario(_file(tmp_path, LEAST + f'[[cause]]\nname = "{name}"\n'))


def test_every_physical_cause_can_stand_in_a_scenario() -> None:
    # A scenario cannot contain noise, sampling faults and lost counts; it can contain every other
    # cause.
    left = set(CAUSES) - set(NAMES)
    assert left == {recipe.cause for recipe in REGISTRY.values() if recipe.kind == "noise"} | {
        "lost_counts"
    }


def test_the_example_of_the_documentation(tmp_path: Path) -> None:
    text = (SHIPPED[0].parents[2] / "docs" / "scenarios.md").read_text(encoding="utf-8")
    example = text.split("```toml\n")[1].split("```")[0]
    scenario = read_scenario(_file(tmp_path, example))
    assert len(scenario.legs) == 4
    # The table on the page contains the name of each cause.
    assert [name for name in NAMES if f"| `{name}` |" not in text] == []
    # The page also names every shipped scenario file.
    names = {file.stem for file in SHIPPED} - set(ORDER)
    assert [name for name in names if f"`{name}`" not in text] == []
