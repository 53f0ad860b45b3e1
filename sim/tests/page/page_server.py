"""Starts ``arctrue serve`` as a separate process, for screenshots and tests."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

END_S = 20.0
PROGRAM = "from arctrue.cli import main; main()"


@contextmanager
def page_server(folder: Path, state: Path, *options: str, http_port: int = 0) -> Iterator[str]:
    """Run the server and yield the server's address without the path.

    Raises RuntimeError if the server does not start.
    """
    command = [sys.executable, "-c", PROGRAM, "serve", str(folder), "--state", str(state)]
    process = subprocess.Popen(
        [*command, "--http-port", str(http_port), *options],
        stdin=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, "PYTHONUNBUFFERED": "1"},
    )
    try:
        assert process.stderr is not None
        said = ""
        for line in process.stderr:
            said += line
            found = re.search(r"serving (http://[^/\s]+)", line)
            if found is not None:
                yield found[1]
                return
        raise RuntimeError(f"arctrue serve ended: {said}")
    finally:
        process.terminate()
        process.wait(END_S)
