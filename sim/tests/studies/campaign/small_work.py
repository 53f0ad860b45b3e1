"""Defines the functions that the workers of a test's campaign run; a worker can import this
module."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any


def square(task: Mapping[str, Any]) -> dict[str, Any]:
    return {"square": task["number"] ** 2}


def slow_square(task: Mapping[str, Any]) -> dict[str, Any]:
    time.sleep(0.05)
    return square(task)


def killed_once(task: Mapping[str, Any]) -> dict[str, Any]:
    """Kill this worker, if it is the first one that takes task number 5; otherwise return the
    square."""
    mark = Path(task["mark"])
    if task["number"] == 5 and not mark.exists():
        mark.touch()
        os.kill(os.getpid(), signal.SIGKILL)
    return square(task)


def always_killed(task: Mapping[str, Any]) -> dict[str, Any]:
    os.kill(os.getpid(), signal.SIGKILL)
    return {}


def noted(task: Mapping[str, Any]) -> dict[str, Any]:
    """Leave a file for each call, so that the files show whether a task was repeated."""
    place = Path(task["place"])
    (place / f"{task['number']}-{os.getpid()}").touch()
    time.sleep(0.1)
    return square(task)
