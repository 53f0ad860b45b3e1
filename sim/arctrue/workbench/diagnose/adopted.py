"""A product of parts that a user has adopted as an effect under a name of its own."""

from __future__ import annotations

import keyword
import re
from pathlib import Path
from typing import ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined

from arctrue.whole_file import write_whole_text
from arctrue.workbench.effects.product_of_parts import (
    Frame,
    ProductOfParts,
    column_condition,
    condition_named,
)
from arctrue.workbench.effects.registry import built_in
from arctrue.workbench.observations import Observations


class AdoptedProduct(ProductOfParts):
    """The parts as class attributes, so that an effect file can say them."""

    condition_words: ClassVar[str] = ""
    time_constant_s: ClassVar[float | None] = None
    each_run: ClassVar[bool] = False
    column: ClassVar[str | None] = None
    column_zero: ClassVar[float] = 0.0
    wave_orders: ClassVar[tuple[float, ...]] = ()
    fixed_to: ClassVar[Frame] = "disc"
    electrical: ClassVar[int | None] = None

    def __init__(self) -> None:
        """Raises ValueError for parts that do not exist."""
        super().__init__(
            condition_named(self.condition_words, self.time_constant_s, self.each_run)
            if self.column is None
            else column_condition(self.column, self.column_zero),
            self.wave_orders,
            self.fixed_to,
            self.electrical,
        )

    def missing(self, observations: Observations) -> list[str]:
        for rows in (observations.capture, observations.reference):
            if rows is not None and self.condition.values(rows) is not None:
                return []
        what = "condition" if self.column is None else "column"
        return [f"the {what} {self.condition.part}"]


def adopt(product: ProductOfParts, name: str, description: str, folder: Path) -> Path:
    """Write the effect file of a product; returns its path.

    Raises ValueError for a name that is taken or cannot be one, FileExistsError for a file that
    is there already.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise ValueError(f"{name!r} cannot name an effect: small letters, digits, underscores")
    if name in built_in():
        raise ValueError(f"the effect name {name} is taken already")
    path = folder / f"{name}.py"
    if path.exists():
        raise FileExistsError(f"{path}: is there already; it was not touched")
    templates = Environment(
        loader=PackageLoader("arctrue.workbench.effects", "templates"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
    # A column's name may hold anything: it goes into the file as a quoted text only.
    templates.filters["quoted"] = _quoted
    text = templates.get_template("adopted.py.j2").render(
        name=name,
        class_name="".join(part.capitalize() for part in name.split("_")),
        description=description,
        product=product,
    )
    write_whole_text(path, text)
    return path


def _quoted(text: str) -> str:
    return f'"{text}"' if text.isprintable() and not set(text) & {'"', "\\"} else repr(text)
