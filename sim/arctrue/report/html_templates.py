"""How every HTML page is made of its template: the live page, reports, the demo's pages."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

HTML_OPTIONS: dict[str, Any] = {
    "autoescape": True,
    "undefined": StrictUndefined,
    "trim_blocks": True,
    "lstrip_blocks": True,
}
"""A title, a name or a sentence is text: whatever its template is called, no markup of it is
obeyed. What is markup is a ``Markup``."""


def html_environment() -> Environment:
    """The templates of this package."""
    return Environment(loader=PackageLoader("arctrue.report"), **HTML_OPTIONS)
