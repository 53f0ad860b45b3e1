"""Serves the page of a running device, which shows its state and takes a capture for the
diagnosis."""

from __future__ import annotations

from typing import Any

from flask import Blueprint, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from arctrue.page.addresses import to_step
from arctrue.page.analyses import Analyses
from arctrue.page.device_captures import DeviceCaptures
from arctrue.page.live_device import LiveDevice


def device_pages(device: LiveDevice, analyses: Analyses) -> Blueprint:
    """Add the routes of the device's page to the application."""
    pages = Blueprint("device", __name__, url_prefix="/device")
    captures = DeviceCaptures(device, analyses)

    @pages.get("/")
    def page() -> tuple[str, int] | Response:
        """Render the page of the device, or the result of the capture that the address names."""
        name = request.args.get("capture", "")
        result = captures.result(name)
        if isinstance(result, int):
            return to_step(analyses.sessions[name], result)
        return render_template(
            "device.html.j2",
            port=device.port,
            problem=result or "",
            capture=name if name == captures.running else "",
        ), 422 if result else 200

    @pages.get("/state")
    def state() -> dict[str, Any]:
        return {**device.shown(), "capture": captures.running}

    @pages.post("/capture")
    def capture() -> Response:
        """Start a capture, and redirect to the page, which waits for the end of the capture."""
        return redirect(url_for("device.page", capture=captures.start()), 303)

    return pages
