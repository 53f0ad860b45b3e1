"""Writes an effect file that defines a product of parts as an effect with its own name."""

from __future__ import annotations

import keyword
import re
from pathlib import Path
from typing import Any, ClassVar

from jinja2 import Environment, PackageLoader, StrictUndefined

from arctrue.base.whole_file import write_whole_text
from arctrue.workbench.effects.product_of_parts import Frame, ProductOfParts
from arctrue.workbench.effects.registry import built_in


class AdoptedProduct(ProductOfParts):
    """A product of parts whose parts are class attributes, so that an effect file can state
    them."""

    condition_words: ClassVar[str] = ""
    time_constant_s: ClassVar[float | None] = None
    each_run: ClassVar[bool] = False
    column: ClassVar[str | None] = None
    column_zero: ClassVar[float] = 0.0
    from_run: ClassVar[int | None] = None
    wave_orders: ClassVar[tuple[float, ...]] = ()
    fixed_to: ClassVar[Frame] = "disc"
    electrical: ClassVar[int | None] = None
    turned: ClassVar[str] = ""

    needs_settings = False
    defaults: ClassVar[dict[str, object]] = {}

    def __init_subclass__(cls, **keywords: Any) -> None:
        """Use the class attributes as the defaults of the settings."""
        super().__init_subclass__(**keywords)
        if "defaults" not in vars(cls):
            cls.defaults = {
                "condition": cls.condition_words,
                "time_constant_s": cls.time_constant_s or 0.0,
                "each_run": cls.each_run,
                "column": cls.column or "",
                "column_zero": cls.column_zero,
                "from_run": cls.from_run or 0,
                "orders": list(cls.wave_orders),
                "fixed_to": cls.fixed_to,
                "electrical_head": cls.electrical or 0,
                "turned_by": cls.turned,
            }


def adopt(product: ProductOfParts, name: str, description: str, folder: Path) -> Path:
    """Write the effect file of a product and return its path.

    Raises ValueError for the name of a built-in effect or a name that is not allowed,
    FileExistsError for an existing file.
    """
    if not re.fullmatch(r"[a-z][a-z0-9_]*", name) or keyword.iskeyword(name):
        raise ValueError(f"{name!r} cannot name an effect: use small letters, digits, underscores")
    if name in built_in():
        raise ValueError(f"the effect name {name} is in use already")
    path = folder / f"{name}.py"
    if path.exists():
        raise FileExistsError(f"{path}: exists already; it was not changed")
    templates = Environment(
        loader=PackageLoader("arctrue.workbench.effects", "templates"),
        undefined=StrictUndefined,
        keep_trailing_newline=True,
        autoescape=False,
    )
    # A column's name may be any text: it is written to the file as a quoted string only.
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
