"""Defines the subjects of the test: programs that give an answer to a measurement set."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

Answer = dict[str, Any]
Answering = Callable[[Path], Answer]
PEERS = "arctrue.studies.benchmark.peers"


@dataclass(frozen=True, slots=True)
class Subject:
    """Subject: a program that answers, and the code on which its answers depend."""

    module: str
    """Module with the subject's function; it is imported only when the subject runs."""
    function: str
    whole_package: bool = False
    """Whether the answers depend on modules of the package that import statements do not show; then
    all modules count."""
    libraries: tuple[str, ...] = ()
    """Numerical libraries that the subject uses, in addition to the libraries that every result
    records."""


SUBJECTS = {
    "arctrue": Subject(
        # The catalogue of effects is found by a scan of files, so that imports alone do not show
        # it.
        "arctrue.studies.benchmark.diagnosis",
        "arctrue",
        whole_package=True,
    ),
    "stepwise_bic": Subject(f"{PEERS}.stepwise_bic", "stepwise_bic"),
    "periodogram_rule": Subject(f"{PEERS}.periodogram_rule", "periodogram_rule"),
    "gaussian_process": Subject(
        f"{PEERS}.gaussian_process", "gaussian_process", libraries=("scikit-learn",)
    ),
}


def find_subject(name: str) -> Answering:
    """Return the function of a subject.

    Raises KeyError for an unknown name, ValueError if a library that the subject needs is missing.
    """
    subject = SUBJECTS[name]
    found: Answering = getattr(importlib.import_module(subject.module), subject.function)
    return found
