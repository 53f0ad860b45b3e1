"""Takes the picture of the page of ``arctrue serve`` for README.md and docs/page.md:
docs/images/page.png.

Run ``python -m scripts.page_screenshot``. The script generates a table with a hidden effect in the
page and waits for the diagnosis. It needs Chromium.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from playwright.sync_api import Page, sync_playwright
from sim.tests.page.browser import INSTALL, chromium
from sim.tests.page.browser import arguments as browser_arguments
from sim.tests.page.page_server import page_server

IMAGE = Path(__file__).resolve().parents[1] / "docs" / "images" / "page.png"
SEED = 12
"""Seed of the tutorial's table, in which heat moves the disc on its hub."""
PATIENCE_MS = 600_000
WIDTH, HEIGHT = 1440, 1000


def all_drawn(page: Page) -> None:
    """Wait until the page shows the diagnosis and every figure."""
    page.wait_for_selector("main[data-state=done]")
    page.locator(".plot:not([data-drawn])").first.wait_for(state="detached")


def take(page: Page, address: str) -> None:
    """Open the page, generate the table, wait for the diagnosis, and save the picture."""
    page.goto(address)
    page.get_by_label("Measured").select_option("short")
    page.get_by_label("Seed", exact=True).fill(str(SEED))
    page.get_by_role("button", name="Generate").click()
    all_drawn(page)
    page.evaluate("document.getElementById('finding').scrollIntoView()")
    page.wait_for_timeout(500)
    page.screenshot(path=IMAGE)


def main(arguments: Sequence[str] | None = None) -> None:
    """Write the picture; if there is no browser, keep the existing picture."""
    argparse.ArgumentParser(description=__doc__).parse_args(arguments)
    program = chromium()
    if program is None:
        print(f"{IMAGE} stays as it is: no browser: {INSTALL}", file=sys.stderr)
        return
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=browser_arguments())
        page = browser.new_page(viewport={"width": WIDTH, "height": HEIGHT}, color_scheme="light")
        page.set_default_timeout(PATIENCE_MS)
        with page_server(Path(folder), Path(folder) / "state") as address:
            take(page, address)
        browser.close()
    print(f"wrote {IMAGE}")


if __name__ == "__main__":
    main()
