"""Gives a set's folder a name that does not reveal the hidden causes, and computes a digest of its
files."""

from __future__ import annotations

import hashlib
from pathlib import Path

from arctrue.studies.campaign.task import Task, digest
from arctrue.studies.simulate.truth import fingerprint


def set_name(task: Task) -> str:
    """Return the name of a set's folder; the name reveals nothing about the hidden causes."""
    return digest({name: value for name, value in task.items() if name != "subject"})[:12]


def folder_digest(folder: Path) -> str:
    """Return the first 16 hex digits of SHA-256 over the names and digests of a set's files."""
    files = sorted(fingerprint(folder).items())
    return hashlib.sha256(
        "".join(f"{name} {found}\n" for name, found in files).encode()
    ).hexdigest()[:16]
