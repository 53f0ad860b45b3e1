"""Tests that ``arctrue capture`` writes the captured values although the serial line damages
rows."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from click.testing import CliRunner
from sim.tests.cli.test_monitor import COUNTS, Device
from sim.tests.firmware.emulator import PATIENCE_S
from sim.tests.firmware.library import firmware
from sim.tests.firmware.model_core import Firmware
from sim.tests.workbench.small_sets import measurement_set

from arctrue.cli import main
from arctrue.device.dump import read_head, read_row
from arctrue.measurement import JoinError, joined, read_measurement_set, write_measurement_set


class NoisyLine(Device):
    """A serial line that changes the head of the first dump and, once in a later dump, a digit of
    row 17; it loses rows 300 to 302 of this later dump."""

    head_spoiled = False
    head_right = False

    def attach(self, made: object) -> None:
        self.held = ""
        self.spoiled: set[int] = set()

    def tell(self, said: str) -> None:
        *lines, self.held = (self.held + said).split("\n")
        super().tell("".join(f"{kept}\n" for line in lines if (kept := self.changed(line))))

    def changed(self, line: str) -> str:
        if line.startswith("dump "):
            self.head_right = self.head_spoiled
            self.head_spoiled = True
            return line if self.head_right else re.sub(r"samples=\d", "samples=5", line)
        row = re.match(r"(\d+),", line)
        if row is None or not self.head_right or int(row[1]) in self.spoiled:
            return line
        number = int(row[1])
        if number in (17, 300, 301, 302):
            self.spoiled.add(number)
            return line.replace("3", "8", 1) if number == 17 else ""
        return line


class SampledFromOutside(Device):
    def attach(self, made: Firmware) -> None:
        made.application.parameters.sync_capture = 1


def test_a_turn_is_not_appended_where_columns_would_be_lost(tmp_path: Path) -> None:
    """The command refuses before it opens the port, because it would write the set without its
    column of texts."""
    out = tmp_path / "set"
    write_measurement_set(out, measurement_set(runs=1, cycles=0, reference=False))
    path = out / "capture.csv"
    head, *rows = path.read_text(encoding="utf-8").splitlines()
    path.write_text("\n".join([f"{head},who", *(f"{row},Ann" for row in rows)]) + "\n", "utf-8")
    before = path.read_bytes()
    done = CliRunner().invoke(main, ["capture", str(tmp_path / "no port"), str(out), "--append"])
    assert done.exit_code == 2
    said = " ".join(done.stderr.split())
    assert "capture.csv: --append would lose the column who" in said
    assert path.read_bytes() == before


def test_a_column_that_the_turn_lacks_names_a_remedy_that_exists() -> None:
    made = measurement_set(runs=1, cycles=0, reference=False)
    assert made.capture is not None
    loaded = replace(made.capture, conditions={"load_nm": np.ones(made.capture.run.size)})
    later = replace(
        made.capture,
        head1_counts=made.capture.head1_counts + 1,
        head2_counts=made.capture.head2_counts + 1,
    )
    with pytest.raises(JoinError, match="arctrue join --common-columns leaves it out"):
        joined([replace(made, capture=loaded), replace(made, capture=later)], times="after")


def test_a_file_of_the_user_is_not_replaced_by_a_turn(tmp_path: Path) -> None:
    (tmp_path / "capture.csv").write_text("raw\n", encoding="utf-8")
    done = CliRunner().invoke(main, ["capture", str(tmp_path / "no port"), str(tmp_path)])
    assert done.exit_code == 2
    assert "already holds a capture.csv" in " ".join(done.stderr.split())


@pytest.fixture
def device(monkeypatch: pytest.MonkeyPatch) -> Iterator[NoisyLine]:
    made = NoisyLine()
    with made.running(monkeypatch):
        yield made


@pytest.mark.large
def test_changed_and_lost_rows_are_asked_for_again(device: NoisyLine, tmp_path: Path) -> None:
    arguments = [device.port, str(tmp_path / "set"), "--timeout", str(PATIENCE_S)]
    done = CliRunner().invoke(main, ["capture", *arguments])
    assert done.exit_code == 0, done.output
    assert device.spoiled == {17, 300, 301, 302}
    taken = read_measurement_set(tmp_path / "set").capture
    assert taken is not None
    np.testing.assert_array_equal(taken.head1_counts, COUNTS[0])
    np.testing.assert_array_equal(taken.head2_counts, COUNTS[1])
    np.testing.assert_allclose(np.diff(taken.time_s), 1e-3, atol=1e-12)


def test_samples_without_times_are_no_set(tmp_path: Path) -> None:
    firmware()
    device = SampledFromOutside()
    device.start()
    arguments = [device.port, str(tmp_path / "set"), "--timeout", str(PATIENCE_S)]
    done = CliRunner().invoke(main, ["capture", *arguments])
    device.ended = True
    device.join(PATIENCE_S)
    assert done.exit_code == 2
    assert "sync capture 0" in done.output
    assert not (tmp_path / "set").exists()


ROW = "17,123456,-7,"


def test_no_changed_character_makes_another_row() -> None:
    import struct
    import zlib

    line = f"{ROW}{zlib.crc32(struct.pack('<Iqq', 17, 123456, -7)):08X}"
    assert read_row(line) == (17, 123456, -7)
    for place in range(len(line)):
        for other in "0123456789ABCDEF,-. ":
            changed = line[:place] + other + line[place + 1 :]
            assert changed == line or read_row(changed) is None
    assert read_row(line[:-1]) is None


def test_what_is_no_head() -> None:
    assert read_head("dump sequence=1 samples=2") is None
    line = (
        "dump sequence=1 samples=2 counts_per_rev=4 clock_hz=5 period_clocks=6 start_time=7 "
        "separation_deg=33.000000 crc=00000000"
    )
    assert read_head(line) is None
