"""Tests that import and export from Python write the same files as the commands."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner

import arctrue as at
from arctrue.cli import main
from arctrue.importing import AmbiguousError

LOG = "Angle [deg];Fehler [arcsec]\n" + "".join(
    f"{15 * k};{2.0 * np.cos(np.deg2rad(15 * k)):.6f}\n" for k in range(24)
)


def command(*words: object) -> None:
    done = CliRunner().invoke(main, [str(word) for word in words], catch_exceptions=False)
    assert done.exit_code == 0, done.output


def test_an_imported_file_is_that_of_the_command(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(LOG, encoding="utf-8")
    said = ("--column", "target=Angle [deg]", "--sign", "true-reading", "--faces", "24")
    command("import", log, tmp_path / "set", *said, "--delimiter", "semicolon")
    expected = at.read_set(tmp_path / "set")
    found = at.import_files(log, columns={"target": "Angle [deg]"}, sign="true-reading", faces=24)
    assert found.reference is not None
    assert expected.reference is not None
    np.testing.assert_allclose(
        found.reference.error_arcsec, expected.reference.error_arcsec, atol=1e-6
    )
    # The file contains the true angle minus the reading, as in ISO 230-2; a set has the opposite
    # sign.
    angle = np.deg2rad(found.reference.target_deg)
    np.testing.assert_allclose(found.reference.error_arcsec, -2.0 * np.cos(angle), atol=1e-5)
    assert found.reference.faces == 24
    assert found.origin.notes == expected.origin.notes
    with pytest.raises(AmbiguousError, match="--sign true-reading"):
        at.import_files(log, columns={"target": "Angle [deg]"})


def test_date_and_clock_of_an_imported_capture_are_kept(tmp_path: Path) -> None:
    log = tmp_path / "log.csv"
    log.write_text(
        "time_s,head1_counts,head2_counts\n"
        + "".join(f"{n},{10 * n},{10 * n}\n" for n in range(40)),
        encoding="utf-8",
    )
    found = at.import_files(
        log, counts_per_rev=360, head_separation_deg=33.0, clock_hz=1e8, date="2026-03-12T09:30"
    )
    assert found.capture is not None
    assert found.capture.clock_hz == 1e8
    assert found.date is not None
    assert found.date.isoformat() == "2026-03-12T09:30:00+00:00"


def test_an_exported_file_is_that_of_the_command(tmp_path: Path) -> None:
    data = at.simulate(experiment="lean", seed=4)
    at.write_set(tmp_path / "set", data)
    command("export", tmp_path / "set", "--coefficients", tmp_path / "expected.toml")
    at.export(tmp_path / "set", None, tmp_path / "found.toml")
    assert (tmp_path / "found.toml").read_bytes() == (tmp_path / "expected.toml").read_bytes()
    command("export", tmp_path / "set", "--format", "linuxcnc",
            "--coefficients", tmp_path / "expected.comp")  # fmt: skip
    at.export(tmp_path / "set", None, tmp_path / "found.comp", table_format="linuxcnc")
    assert (tmp_path / "found.comp").read_bytes() == (tmp_path / "expected.comp").read_bytes()
    with pytest.raises(ValueError, match="table_format 'no': expected gateware, "):
        at.export(data, None, tmp_path / "x", table_format="no")


def test_a_correction_that_makes_it_worse_is_refused(tmp_path: Path) -> None:
    """The export refuses a model for a set of another table, which has the opposite error."""
    angle = np.tile(np.arange(24) * 15.0, 4)
    error = 3.0 * np.cos(np.deg2rad(angle)) + 0.1 * np.sin(np.arange(96.0) ** 2)
    keys = {"counts_per_rev": 1 << 20, "faces": 24}
    right = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": error}, **keys)
    model = at.fit(right, at.Model().having(graduation_harmonics={"orders": [1]})).model
    wrong = at.Dataset.from_arrays(reference={"target_deg": angle, "error_arcsec": -error}, **keys)
    file = tmp_path / "c.toml"
    with pytest.raises(at.ExportRefusedError, match="was not written"):
        at.export(wrong, model, file)
    assert not file.exists()
    assert at.export(wrong, model, file, force=True)
    assert file.exists()
    at.export(right, model, tmp_path / "right.toml")


def test_a_table_has_the_checks_of_the_command(tmp_path: Path) -> None:
    """The export refuses a number of steps that the controller does not accept, and names a
    reversal error that the table does not correct."""
    angle, direction = np.tile(np.arange(24) * 15.0, 2), np.repeat([1, -1], 24)
    error = 20.0 * np.cos(np.deg2rad(angle)) + 2.0 * direction + 0.1 * np.sin(np.arange(48.0) ** 2)
    columns = {"target_deg": angle, "error_arcsec": error, "direction": direction}
    data = at.Dataset.from_arrays(reference=columns, counts_per_rev=1 << 20, faces=24)
    model = at.Model().having(graduation_harmonics={"orders": [1]}, hysteresis={})
    settled, file = at.fit(data, model).model, tmp_path / "table"
    with pytest.raises(ValueError, match=r"linuxcnc takes .* steps a turn, found 100001"):
        at.export(data, settled, file, table_format="linuxcnc", points=100_001)
    assert not file.exists()
    said = at.export(data, settled, file, table_format="simplefoc")
    assert any("the table has no values by direction" in text for text in said)
