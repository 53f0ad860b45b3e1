"""Defines fixtures: a browser, and a tab in which any error fails the test."""

from __future__ import annotations

from collections.abc import Iterator

import pytest
from playwright.sync_api import Browser, ConsoleMessage, Page, sync_playwright
from sim.tests.page.browser import arguments

from tests.page.in_browser import PATIENCE_MS, PROGRAM

EXPECTED = (
    "422",
    "ERR_CONNECTION_REFUSED",
    "ERR_CONTENT_LENGTH_MISMATCH",
    "ERR_EMPTY_RESPONSE",
    "ERR_CONNECTION_RESET",
)
"""Parts of the error messages that the browser itself prints when the server refuses a request or
has ended."""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    """Start the system's Chromium."""
    with sync_playwright() as playwright:
        found = playwright.chromium.launch(executable_path=PROGRAM, args=arguments())
        yield found
        found.close()


@pytest.fixture
def page(browser: Browser) -> Iterator[Page]:
    """Open a tab. The test fails if the browser reports an error that EXPECTED does not list."""
    context = browser.new_context(viewport={"width": 1500, "height": 1000}, color_scheme="light")
    context.set_default_timeout(PATIENCE_MS)
    found = context.new_page()
    errors: list[str] = []

    def reported(said: ConsoleMessage) -> None:
        if said.type == "error" and not any(text in said.text for text in EXPECTED):
            errors.append(said.text)

    found.on("pageerror", lambda error: errors.append(str(error)))
    found.on("console", reported)
    yield found
    context.close()
    assert errors == []
