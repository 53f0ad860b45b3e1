"""Takes captures of a device in the background, because a turn of a slow table lasts minutes."""

from __future__ import annotations

import shutil
import threading
from pathlib import Path

from arctrue.measurement.description import read_description
from arctrue.page.analyses import Analyses
from arctrue.page.live_device import LiveDevice
from arctrue.page.people import failure
from arctrue.page.session import SET, Opened, now


class DeviceCaptures:
    """Takes one capture at a time; each successful capture becomes a session that has the capture's
    name."""

    def __init__(self, device: LiveDevice, analyses: Analyses) -> None:
        """Store the device, and the ``analyses`` that make a session from each capture."""
        self._device, self._analyses = device, analyses
        self._running = ""
        self._ended: dict[str, int | str] = {}
        self._lock = threading.Lock()

    @property
    def running(self) -> str:
        """Name of the capture that is in progress, or "" if there is none."""
        return self._running

    def start(self) -> str:
        """Start a capture unless one is running, and return the name of the running capture."""
        with self._lock:
            if not self._running:
                place = self._analyses.sessions.make()
                self._running = place.name
                threading.Thread(target=self._take, args=(place,), daemon=True).start()
            return self._running

    def result(self, name: str) -> int | str | None:
        """Return the step that shows a finished capture, the reason for the failure of a failed
        one, or None if the capture is in progress or unknown."""
        with self._lock:
            return self._ended.get(name)

    def _take(self, place: Path) -> None:
        try:
            ended: int | str = self._step_of_capture(place)
        except Exception as error:
            ended = failure(error, place)
        if isinstance(ended, str):
            shutil.rmtree(place, ignore_errors=True)
        with self._lock:
            self._ended[place.name] = ended
            self._running = ""

    def _step_of_capture(self, place: Path) -> int:
        """Take a capture, copy it into a session and return its step; the copy is needed because
        the daemon deletes its oldest captures."""
        path = self._device.capture()
        shutil.copytree(path, place / SET)
        title = read_description(place / SET).keys.title or path.name
        opened = Opened(title, str(place / SET), str(path), "", generated=False, date=now())
        return self._analyses.first(place, opened)[1].number
