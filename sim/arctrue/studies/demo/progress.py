"""What the process inside the simulator tells the demo while it runs."""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass
from pathlib import Path

from arctrue.whole_file import write_whole_text


@dataclass(frozen=True, slots=True)
class Progress:
    """How far the simulation is."""

    stage: str
    clock: int

    def write(self, file: Path) -> None:
        """Replace ``file`` in one step, so that a reader never sees half of it."""
        write_whole_text(file, json.dumps(asdict(self)))

    @classmethod
    def read(cls, file: Path) -> Progress | None:
        """The last progress written, or None before the first."""
        if not file.exists():
            return None
        return cls(**json.loads(file.read_text(encoding="utf-8")))
