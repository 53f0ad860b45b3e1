"""Runs once more all inputs that fuzzing has kept, with gcc's sanitizers."""

from __future__ import annotations

import subprocess

from sim.tests.firmware.library import FIRMWARE

CORPUS = FIRMWARE / "fuzz" / "corpus"
FILES_MOST = 200
BYTES_MOST = 200_000
TARGETS = ("console", "capture", "record")


def test_no_kept_input_harms() -> None:
    command = ["make", "-s", "-C", str(FIRMWARE), "fuzz-replay"]
    done = subprocess.run(command, capture_output=True, text=True, check=False, timeout=600)
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    kept = [len(list((CORPUS / target).iterdir())) for target in TARGETS]
    assert done.stdout.splitlines()[-len(TARGETS) :] == [f"{number} inputs" for number in kept]
    assert min(kept) > 10


def test_the_corpus_stays_small() -> None:
    files = [path for path in CORPUS.rglob("*") if path.is_file()]
    assert len(files) <= FILES_MOST
    assert sum(path.stat().st_size for path in files) <= BYTES_MOST
