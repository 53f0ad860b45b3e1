"""Serves the page that guides an operator through the commissioning of the heads."""

from __future__ import annotations

from math import degrees
from typing import Any

from flask import Blueprint, redirect, render_template, request, url_for
from werkzeug.wrappers import Response

from arctrue.base.head_places import places_from_text
from arctrue.device.commissioning import (
    CONNECTION_COLUMNS,
    STEPS,
    TABLE_COLUMNS,
    TURNED_COLUMNS,
    connection_rows,
    turned_rows,
)
from arctrue.page.device_commissioning import DeviceCommissioning


def commissioning_pages(port: str) -> Blueprint:
    """Return the routes for commissioning the device at ``port``."""
    pages = Blueprint("commissioning", __name__, url_prefix="/device/commissioning")
    work = DeviceCommissioning(port)

    def shown(problem: str = "", places: str = "") -> str:
        found = work.completed
        return render_template(
            "commissioning.html.j2",
            port=port,
            steps=STEPS,
            running=work.running,
            problem=problem or work.problem,
            places=places or ",".join(f"{place:g}" for place in found.plan_deg),
            found=found,
            forward_deg_s=found.forward and degrees(found.forward.speed_rad_s),
            next_step=found.next_step(),
            connection=found.connection and (CONNECTION_COLUMNS, connection_rows(found.connection)),
            table_of_heads=work.table and ([title for _, title in TABLE_COLUMNS], work.table),
            turned=found.turned and (TURNED_COLUMNS, turned_rows(found.turned)),
        )

    @pages.get("/")
    def page() -> str:
        return shown()

    @pages.get("/state")
    def state() -> dict[str, Any]:
        return {"running": work.running}

    @pages.post("/<step>")
    def take(step: str) -> Response | tuple[str, int]:
        """Start a step of the commissioning, and redirect to the page, which waits for the end of
        the step."""
        places = request.form.get("places", "").strip()
        try:
            work.start(step, places_from_text(places) if places else None)
        except ValueError as error:
            return shown(str(error), places), 422
        return redirect(url_for("commissioning.page"), 303)

    return pages
