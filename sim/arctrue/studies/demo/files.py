"""The files through which the demo and the simulator talk to each other."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text


@dataclass(frozen=True, slots=True)
class DemoFiles:
    """Names inside the demo's working folder."""

    folder: Path

    @property
    def settings(self) -> Path:
        """The scale of the demo."""
        return self.folder / "settings.json"

    @property
    def played(self) -> Path:
        """Pin changes of both heads."""
        return self.folder / "played.txt"

    @property
    def recorded(self) -> Path:
        """Pin changes of the output."""
        return self.folder / "recorded.txt"

    @property
    def capture(self) -> Path:
        """The first turn that the firmware read, counts (2, n)."""
        return self.folder / "capture.npy"

    @property
    def run(self) -> Path:
        """What the firmware did: :class:`ProcessorRun`."""
        return self.folder / "run.json"

    @property
    def latency(self) -> Path:
        """Clocks of each unit."""
        return self.folder / "latency.json"

    @property
    def progress(self) -> Path:
        """How far the simulation is."""
        return self.folder / "progress.json"


@dataclass(frozen=True, slots=True)
class ConsoleLine:
    """A line of the firmware's console, at the clock at which it was typed or told."""

    clock: int
    typed: bool
    text: str


@dataclass(frozen=True, slots=True)
class ProcessorRun:
    """What the firmware did and said. Clocks count as those of the played edges."""

    settled_clock: int
    """The swap's remainder has decayed: from here the output is fully corrected."""
    end_clock: int
    words_moved: int
    """Words that the firmware read and wrote over AXI4-Lite."""
    console: list[ConsoleLine]

    def write(self, file: Path) -> None:
        """Write as JSON."""
        write_whole_text(file, json.dumps(asdict(self), indent=1))

    @classmethod
    def read(cls, file: Path) -> ProcessorRun:
        """Read what :meth:`write` wrote."""
        return read_json(file, cls)
