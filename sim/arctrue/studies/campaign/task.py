"""Computes the key of a campaign's task, finds the function that does the task, and runs it."""

from __future__ import annotations

import hashlib
import importlib
import json
import time
from collections.abc import Callable, Mapping, Sequence
from functools import cache
from typing import Any

from arctrue.studies.campaign.code_state import Sources

Task = Mapping[str, Any]
Work = Callable[[Task], Mapping[str, Any]]


def canonical(value: object) -> str:
    """Return ``value`` as JSON with sorted keys and no spaces; equal values give equal texts.

    Raises ValueError for a number that is not finite.
    """
    return json.dumps(
        value, sort_keys=True, separators=(",", ":"), ensure_ascii=False, allow_nan=False
    )


def digest(value: object) -> str:
    """Return the SHA-256 digest of the canonical JSON of ``value``, in hex."""
    return hashlib.sha256(canonical(value).encode()).hexdigest()


def task_key(task: Task) -> str:
    """Return the key of a task: the first 24 hex digits of the digest of its content.

    Parameters
    ----------
    task : mapping
        The task.

    Returns
    -------
    str
        The key.
    """
    return digest(task)[:24]


def find_work(name: str) -> Work:
    """Import the module of ``module:function`` and return the function."""
    module, _, function = name.partition(":")
    found: Work = getattr(importlib.import_module(module), function)
    return found


class CampaignError(RuntimeError):
    """Raised if the campaign cannot continue; finished results are on the disk."""


class OtherCodeError(RuntimeError):
    """Raised if the code of a worker differs from the code of the campaign."""


def do_batch(
    work: str, tasks: Sequence[Task], sources: Sources, code: Mapping[str, str]
) -> list[tuple[Mapping[str, Any], float]]:
    """Do the tasks one after the other in a worker; return the result of each task and the seconds
    that it took.

    Raises OtherCodeError if the state of the worker's code is not ``code``.
    """
    if _state(sources) != code:
        raise OtherCodeError(
            f"a worker has source {_state(sources)}, the campaign began with {dict(code)}: "
            "results of two states are not mixed"
        )
    function = find_work(work)
    found = []
    for task in tasks:
        begin = time.perf_counter()
        found.append((function(task), time.perf_counter() - begin))
    return found


@cache
def _state(sources: Sources) -> dict[str, str]:
    """Return the state of the worker's code; it is computed once, before the work is imported."""
    return sources.state()
