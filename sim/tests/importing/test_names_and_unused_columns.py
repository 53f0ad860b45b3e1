"""Tests that common column names are recognised, and that unused columns are reported with their
use."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner, Result

from arctrue.cli import main
from arctrue.importing.known_names import quantity_meant
from arctrue.measurement import Reference, read_measurement_set
from arctrue.workbench.effects.registry import catalogue
from arctrue.workbench.observations.build import observations_of

DELAY_S = 0.034


def arctrue(*words: str | Path) -> Result:
    return CliRunner().invoke(main, ["import", *map(str, words)], catch_exceptions=False)


def _late_reading(path: Path, header: str) -> np.ndarray:
    """Write a set in both directions and at two speeds, with a reading that is late by DELAY_S;
    return the times of the rows."""
    time_s = np.arange(0.0, 300.0, 0.25)
    speed = np.where(time_s < 100, 3.6, np.where(time_s < 200, -3.6, 1.8))  # °/s
    angle = np.concatenate(([0.0], np.cumsum(speed[:-1] * 0.25)))
    rows = zip(time_s, angle, angle - DELAY_S * speed, strict=True)
    lines = [f"{t:.3f};{a:.6f};{b:.6f}".replace(".", ",") for t, a, b in rows]
    path.write_text(header + "\n" + "\n".join(lines) + "\n", encoding="utf-8")
    return time_s


def reference_of(folder: Path) -> Reference:
    found = read_measurement_set(folder).reference
    assert found is not None
    return found


@pytest.mark.parametrize(
    "header",
    [
        "Zeit [s];Soll [°];Ist [°]",
        "Zeit / s;Sollwinkel / °;Istwinkel / °",
        "t (s);Set point (deg);Actual (deg)",
        "Temps [s];Consigne [deg];Mesure [deg]",
        "Tiempo [s];Referencia [deg];Medido [deg]",
        "Tempo [s];Riferimento [deg];Encoder [deg]",
    ],
)
def test_common_names_keep_the_time(tmp_path: Path, header: str) -> None:
    time_s = _late_reading(tmp_path / "log.csv", header)
    done = arctrue(tmp_path / "log.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    found = reference_of(tmp_path / "out")
    assert found.time_s is not None
    np.testing.assert_allclose(found.time_s, time_s)
    # Because the set has times, the workbench can test the effect of a delay.
    observations = observations_of(read_measurement_set(tmp_path / "out"))
    latency = catalogue([])["latency"]()
    assert latency.missing(observations) == []


@pytest.mark.parametrize(
    ("column", "quantity"),
    [
        ("Zeitstempel", "time"),
        ("timestamp", "time"),
        ("Encoder 2", "head2"),
        ("Lesekopf_1", "head1"),
        ("Temperatur", "temperature"),
        ("Température", "temperature"),
        ("Abweichung", "error"),
        ("Drehrichtung", "direction"),
        ("Zyklus", "cycle"),
        ("t", None),  # without a unit it may be a temperature
        ("Position", None),  # unclear: position of a head or of the reference
        ("Periode", None),
        ("A", None),
    ],
)
def test_the_quantity_that_a_name_means(column: str, quantity: str | None) -> None:
    assert quantity_meant(column) == quantity


def test_a_column_with_the_sets_own_name_comes_first(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "target_deg,head1_deg,Soll [deg]\n" + "".join(f"{i},{i + 0.01},7\n" for i in range(60))
    )
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert reference_of(tmp_path / "out").target_deg[5] == 5.0
    assert "3 Soll [deg]" in done.output, "the other column is not used"


def test_two_columns_of_one_meaning_are_asked_for(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "Soll [deg];Referenz [deg];Ist [deg]\n" + "".join(f"{i};{i};{i}\n" for i in range(60))
    )
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 2
    assert "Which column is the angle by the reference" in done.output


def test_unused_columns_are_listed_with_what_they_would_unlock(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "Uhr,target_deg,head1_deg,Drehmoment,Bemerkung\n"
        + "".join(f"{i * 0.1},{i},{i + 0.01},{i % 7},ok\n" for i in range(60))
    )
    done = arctrue(tmp_path / "a.csv", tmp_path / "out")
    assert done.exit_code == 0, done.output
    said = " ".join(done.output.split())
    assert "a.csv: not used: 1 Uhr, 4 Drehmoment, 5 Bemerkung (text)" in said
    assert "--column time=COLUMN" in said
    assert "latency" in said
    assert "--column NAME=COLUMN makes a column a condition" in said
    kept = read_measurement_set(tmp_path / "out").origin.notes
    assert any("not used: 1 Uhr, 4 Drehmoment, 5 Bemerkung (text)" in note for note in kept)
    # If every column is used, the output does not mention unused columns.
    (tmp_path / "b.csv").write_text(
        "time_s,target_deg,head1_deg\n" + "".join(f"{i},{i},{i + 0.01}\n" for i in range(60))
    )
    assert "not used" not in arctrue(tmp_path / "b.csv", tmp_path / "second").output


def test_a_column_left_out_by_hand_is_not_suggested(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text(
        "time_s,target_deg,head1_deg\n" + "".join(f"{i},{i},{i + 0.01}\n" for i in range(60))
    )
    done = arctrue(tmp_path / "a.csv", "--column", "time=none", tmp_path / "out")
    assert done.exit_code == 0, done.output
    assert "not used: 1 time_s" in done.output
    assert reference_of(tmp_path / "out").time_s is None


def _direction_files(tmp_path: Path, reversal_deg: float) -> list[Path]:
    """Write a forward and a backward run to separate files. The readings differ from the target by
    12.5° plus (forward) or minus (backward) half of ``reversal_deg``."""
    up = np.arange(0.0, 361.0, 5.0)
    paths = []
    for name, angle, sign in (("up", up, 1.0), ("down", up[::-1], -1.0)):
        reading = angle + 12.5 + sign * reversal_deg / 2.0
        path = tmp_path / f"{name}.csv"
        path.write_text(
            "target_deg,head1_deg\n"
            + "".join(f"{a:.9f},{b:.9f}\n" for a, b in zip(angle, reading, strict=True))
        )
        paths.append(path)
    return paths


def test_one_shift_for_what_was_measured_together(tmp_path: Path) -> None:
    paths = _direction_files(tmp_path, reversal_deg=1.2)
    done = arctrue(*paths, "--zero", "shift", tmp_path / "out")
    assert done.exit_code == 0, done.output
    found = reference_of(tmp_path / "out")
    assert found.direction is not None
    up = found.error_arcsec[found.direction == 1].mean()
    down = found.error_arcsec[found.direction == -1].mean()
    assert up - down == pytest.approx(4320.0, abs=1e-3)  # 1.2°; the files have 1e-9 °
    assert up + down == pytest.approx(0.0, abs=1e-3)
    assert "12.500000° are added to target" in done.output


def test_different_zeros_in_the_files_are_refused(tmp_path: Path) -> None:
    first, second = _direction_files(tmp_path, reversal_deg=0.0)
    lines = second.read_text().splitlines()
    moved = [f"{a},{float(b) + 30.0}" for a, b in (line.split(",") for line in lines[1:])]
    second.write_text("\n".join([lines[0], *moved]) + "\n")
    done = arctrue(first, second, "--zero", "shift", tmp_path / "out")
    assert done.exit_code == 2
    assert "12.5000° in up.csv, 42.5000° in down.csv" in " ".join(done.output.split())
    assert "arctrue join" in done.output
