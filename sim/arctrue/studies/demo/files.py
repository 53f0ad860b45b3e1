"""Defines the files by which the demo and the simulator exchange data."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text


@dataclass(frozen=True, slots=True)
class DemoFiles:
    """Paths of the files in the demo's working folder."""

    folder: Path

    @property
    def settings(self) -> Path:
        """Return the file with the scale of the demo."""
        return self.folder / "settings.json"

    @property
    def played(self) -> Path:
        """Return the file with the pin changes of both heads."""
        return self.folder / "played.txt"

    @property
    def recorded(self) -> Path:
        """Return the file with the pin changes of the output."""
        return self.folder / "recorded.txt"

    @property
    def capture(self) -> Path:
        """Return the file with the counts (2, n) of both heads that the firmware read in the first
        turn."""
        return self.folder / "capture.npy"

    @property
    def run(self) -> Path:
        """Return the file in which :class:`ProcessorRun` is stored."""
        return self.folder / "run.json"

    @property
    def latency(self) -> Path:
        """Return the file with the measured latency of each unit, in clocks."""
        return self.folder / "latency.json"

    @property
    def progress(self) -> Path:
        """Return the file with the progress of the simulation."""
        return self.folder / "progress.json"


@dataclass(frozen=True, slots=True)
class ConsoleLine:
    """Line that was typed or printed on the firmware's console, with its clock."""

    clock: int
    typed: bool
    text: str


@dataclass(frozen=True, slots=True)
class ProcessorRun:
    """Actions and messages of the firmware; instants are clocks of the played edges."""

    settled_clock: int
    """Clock at which the ramp after the swap has ended; from this clock on the output is fully
    corrected."""
    end_clock: int
    words_moved: int
    """Number of words that the firmware read and wrote over AXI4-Lite."""
    console: list[ConsoleLine]

    def write(self, file: Path) -> None:
        """Write the record as JSON."""
        write_whole_text(file, json.dumps(asdict(self), indent=1))

    @classmethod
    def read(cls, file: Path) -> ProcessorRun:
        """Read the file that :meth:`write` wrote."""
        return read_json(file, cls)
