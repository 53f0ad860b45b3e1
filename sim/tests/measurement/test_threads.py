"""Tests that sets can be read in threads that end, as in the page's server and in the daemon."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

from arctrue.measurement import write_measurement_set
from tests.workbench.small_sets import measurement_set

PROGRAM = """
import sys
import threading
from arctrue.measurement import read_measurement_set

rows = []
def read():
    rows.append(read_measurement_set(sys.argv[1]).reference.error_arcsec.size)

for together in (1, 1, 4):
    threads = [threading.Thread(target=read) for _ in range(together)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()

import pyarrow
print(len(rows), *set(rows), pyarrow.default_memory_pool().backend_name)
"""


def test_the_first_thread_that_reads_may_end(tmp_path: Path) -> None:
    """Sets can be read after the first thread that read one has ended. pyarrow allocates from the
    system, because mimalloc could crash then."""
    measurement = measurement_set(runs=1, cycles=1, turns=1)
    write_measurement_set(tmp_path / "set", measurement)
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM, str(tmp_path / "set")],
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stderr
    assert measurement.reference is not None
    rows = measurement.reference.error_arcsec.size
    assert done.stdout.split() == ["6", str(rows), "system"]
