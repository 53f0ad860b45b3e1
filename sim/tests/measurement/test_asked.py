"""Tests the check whether a further measurement is the requested one; the check states every
difference."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from sim.tests.command_line import arctrue as run

from arctrue.cli._guide import commands
from arctrue.measurement import Capture, MeasurementSet, Reference, read_measurement_set
from arctrue.measurement import write_measurement_set as write
from arctrue.measurement.asked import KINDS, at_the_table, by_device, came, runs_of
from arctrue.studies.simulate.experiment import FURTHER, lean, short
from arctrue.studies.simulate.simulated_set import simulate_set
from arctrue.workbench.diagnose.planned import PLANS

OF_THE_CAPTURE = ("speed", "direction", "warm", "again", "turns", "samples")


@pytest.fixture(scope="module")
def plain() -> MeasurementSet:
    return simulate_set([], short(), seed=1).measurement


def first_run(measured: MeasurementSet) -> MeasurementSet:
    assert measured.capture is not None
    return replace(measured, capture=measured.capture.where(measured.capture.run == 0))


def last_part(kind: str) -> MeasurementSet:
    """Return only the further measurement of this kind, from a simulated table."""
    made = simulate_set([], short(), seed=1, further=[kind]).measurement
    capture, reference = made.capture, made.reference
    assert capture is not None
    assert reference is not None
    if kind in OF_THE_CAPTURE:
        return replace(made, capture=capture.where(capture.run == capture.run.max()))
    if kind == "polygon_turned":
        assert reference.run is not None
        return replace(made, reference=reference.where(reference.run == reference.run.max()))
    return made


def test_every_measurement_that_is_asked_for_is_known() -> None:
    assert {plan.kind for plan in PLANS if plan.kind is not None} <= set(KINDS)
    assert set(FURTHER) <= set(KINDS)


@pytest.mark.parametrize("kind", FURTHER)
def test_what_was_asked_for_is_recognised(kind: str, plain: MeasurementSet) -> None:
    """Each kind of further measurement that the simulation can make is recognised."""
    assert came(kind, plain, last_part(kind)).faults == []


@pytest.mark.parametrize("kind", sorted(set(FURTHER) - {"again", "reference", "polygon_reindexed"}))
def test_the_same_measurement_again_is_not_it(kind: str, plain: MeasurementSet) -> None:
    assert came(kind, plain, first_run(plain)).faults != []


def test_the_steps_have_the_figures_of_the_first_run(plain: MeasurementSet) -> None:
    """The instructions follow from the first run's direction, speed and temperature."""
    assert plain.capture is not None
    assert plain.table.counts_per_rev is not None
    (first, *_) = runs_of(plain.capture, plain.table.counts_per_rev)
    assert first.speed_deg_s == pytest.approx(np.degrees(short().runs[0].speed_rad_s), rel=1e-3)
    assert at_the_table("speed", plain) == [
        f"turn the table up at {3.0 * first.speed_deg_s:.3g}°/s "
        f"(first run: {first.speed_deg_s:.3g}°/s)"
    ]
    assert "down" in at_the_table("direction", plain)[0]
    assert first.temperature_c is not None
    assert f"to {first.temperature_c + 4.0:.1f} °C" in at_the_table("warm", plain)[0]
    assert "turn the polygon on the table by 5°" in at_the_table("polygon_turned", plain)[0]


def changed(capture: Capture, **values: object) -> Capture:
    return replace(capture, **values)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("kind", "change", "said"),
    [
        ("speed", lambda c: changed(c, head1_counts=-c.head1_counts, time_s=c.time_s / 3), "down"),
        ("speed", lambda c: changed(c, time_s=c.time_s / 1.9), "expected 60°/s or more"),
        ("speed", lambda c: c.where(np.arange(c.run.size) < 500), "of a turn, expected a whole"),
        ("direction", lambda c: changed(c, head1_counts=-2 * c.head1_counts), "expected the 30°/s"),
        ("warm", lambda c: changed(c, temperature_c=c.temperature_c + 2.0), "°C or more"),
        ("warm", lambda c: changed(c, temperature_c=None), "it has no temperature_c"),
        ("turns", lambda c: c, "turns, expected 20 or more"),
        ("samples", lambda c: c, "samples a turn, expected"),
    ],
)
def test_what_is_lacking_is_said(
    kind: str, change: object, said: str, plain: MeasurementSet
) -> None:
    run = first_run(plain)
    taken = replace(run, capture=change(run.capture))  # type: ignore[operator]
    assert any(said in fault for fault in came(kind, plain, taken).faults), came(kind, plain, taken)


def test_a_second_condition_that_changed_is_remarked(plain: MeasurementSet) -> None:
    run = last_part("direction")
    assert run.capture is not None
    assert run.capture.temperature_c is not None
    warm = replace(run.capture, temperature_c=run.capture.temperature_c + 3.0)
    found = came("direction", plain, replace(run, capture=warm))
    assert found.faults == []
    assert "warmer than the first run" in found.remarks[0]


@pytest.mark.parametrize(
    ("kind", "change", "said"),
    [
        ("reference", lambda r: r.where(r.direction > 0), "from one direction only"),
        ("reference", lambda r: replace(r, direction=None), "no column direction"),
        ("reference", lambda r: r.where(r.target_deg < 100.0), "targets, expected 16 or more"),
        ("reference_back", lambda r: r, "from the same side"),
        ("polygon_turned", lambda r: replace(r, target_deg=r.target_deg + 7.5), "0.50 of a face"),
        ("polygon_reindexed", lambda r: r.where(r.target_deg < 100.0), "targets are not the 24"),
        ("moving_reference", lambda r: replace(r, time_s=None), "no column time_s"),
    ],
)
def test_what_a_reference_run_lacks_is_said(
    kind: str, change: object, said: str, plain: MeasurementSet
) -> None:
    reference: Reference = change(plain.reference)  # type: ignore[operator]
    found = came(kind, plain, replace(plain, capture=None, reference=reference)).faults
    assert any(said in fault for fault in found), found


def test_a_set_without_the_part_is_refused(plain: MeasurementSet) -> None:
    assert came("speed", plain, replace(plain, capture=None)).faults == [
        "it has no capture of both heads"
    ]
    assert came("reference", plain, replace(plain, reference=None)).faults == [
        "it has no reference run"
    ]
    with pytest.raises(ValueError, match="the set has no such run"):
        at_the_table("speed", replace(plain, capture=None))
    with pytest.raises(ValueError, match="no measurement is called"):
        at_the_table("faster", plain)


def test_join_takes_what_was_asked_for_and_refuses_the_rest(tmp_path: Path) -> None:
    made = simulate_set([], lean(), seed=1, further=["direction"]).measurement
    assert made.capture is not None
    write(tmp_path / "first", replace(made, capture=made.capture.where(made.capture.run == 0)))
    back = replace(made, reference=None, capture=made.capture.where(made.capture.run == 1))
    write(tmp_path / "back", back)
    sets = ("join", tmp_path / "first", tmp_path / "back")
    refused = run(*sets, tmp_path / "all", "--next", "speed")
    assert refused.exit_code == 1
    assert "error: refused: not the requested measurement (speed): it turns down" in refused.stderr
    assert not (tmp_path / "all").exists()
    forced = run(*sets, tmp_path / "forced", "--next", "speed", "--force")
    assert forced.exit_code == 0
    assert "warning: not the requested measurement (speed)" in forced.stderr
    assert run(*sets, tmp_path / "all", "--next", "direction").exit_code == 0
    joined = read_measurement_set(tmp_path / "all")
    assert "--next direction" in (joined.origin.command or "")


def test_the_commands_can_be_typed(tmp_path: Path) -> None:
    """Each command that the program suggests exists and has the suggested options."""
    for kind in KINDS:
        for line in commands(kind, tmp_path / "my set"):
            words = line.split()
            assert words[0] == "arctrue"
            help_text = run(words[1], "-h").output
            for option in (word for word in words if word.startswith("--")):
                assert option in help_text
            assert by_device(kind) == ("capture" in commands(kind, tmp_path)[0])
