"""Defines settings and checks that the browser tests of the page share."""

from __future__ import annotations

from pathlib import Path

import pytest
from playwright.sync_api import Page, expect
from sim.tests.page.browser import INSTALL, chromium

PICTURES = Path(__file__).resolve().parents[3] / "build" / "page"
PATIENCE_MS = 240_000
"""Longest time in milliseconds for which a test waits for the page. It is longer than any step
takes on a busy machine, because no test judges the page's speed."""
expect.set_options(timeout=PATIENCE_MS)
PROGRAM = chromium()
needs_browser = pytest.mark.skipif(
    PROGRAM is None, reason=f"no browser for the page's tests: {INSTALL}"
)


def picture(page: Page, name: str, *, whole: bool = True) -> None:
    """Save a screenshot in build/page, for people to look at."""
    PICTURES.mkdir(parents=True, exist_ok=True)
    page.screenshot(path=PICTURES / f"{name}.png", full_page=whole)


def all_drawn(page: Page) -> None:
    """Expect that every figure has been drawn, and that none shows a message instead."""
    expect(page.locator(".plot:not([data-drawn])")).to_have_count(0)
