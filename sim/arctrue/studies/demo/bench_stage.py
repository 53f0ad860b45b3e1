"""Stores the present stage of the test bench in a file, which the demo reads during simulation."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.base.typed_content import read_json
from arctrue.base.whole_file import write_whole_text


@dataclass(frozen=True, slots=True)
class BenchStage:
    """Activity of the test bench, and the clock of the gateware at which the activity began."""

    stage: str
    clock: int

    def write(self, file: Path) -> None:
        """Replace ``file`` in one step, so that no program reads a half-written file."""
        write_whole_text(file, json.dumps(asdict(self)))

    @classmethod
    def read(cls, file: Path) -> BenchStage | None:
        """Read the stage that was written last; None if no stage has been written."""
        if not file.exists():
            return None
        return read_json(file, cls)
