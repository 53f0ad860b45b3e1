"""Makes the environment that renders the templates of all HTML pages: the pages of the server,
reports and the demo's pages."""

from __future__ import annotations

from typing import Any

from jinja2 import Environment, PackageLoader, StrictUndefined

HTML_OPTIONS: dict[str, Any] = {
    "autoescape": True,
    "undefined": StrictUndefined,
    "trim_blocks": True,
    "lstrip_blocks": True,
}
"""Options of all templates. All text is escaped, whatever the template's name, because titles,
names and sentences contain no markup. Only a ``Markup`` value is inserted without escaping."""


def html_environment() -> Environment:
    """Return the environment for the templates of this package."""
    return Environment(loader=PackageLoader("arctrue.report"), **HTML_OPTIONS)
