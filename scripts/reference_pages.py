"""Makes the pages of the command line and of the Python interface from the help texts and
docstrings."""

from __future__ import annotations

import dataclasses
import inspect
import re
from collections.abc import Iterator
from typing import Any, get_type_hints

import click

from arctrue.base.typed_content import bound_words

COMMANDS_HEAD = """# Commands

`make docs` makes this page from the sources. Every command has `-h`; results are on stdout, errors
and progress on stderr. The exit code is 0 after success, 2 for bad usage or bad input, and 130
after Ctrl-C, unless the text of a command names another one.
"""
API_HEAD = """# Python interface

`make docs` makes this page from the sources. [From Python](python.md) shows how to use it.
"""


def commands_page() -> str:
    """Return ``docs/commands.md``: usage, description and options of every command."""
    from arctrue.cli import SECTIONS, main

    context = click.Context(main, info_name="arctrue", **main.context_settings)
    parts = [COMMANDS_HEAD]
    for title, names in SECTIONS.items():
        parts.append(f"\n## {title}\n")
        for name in names:
            command = main.get_command(context, name)
            assert command is not None, name
            parts += _command(command, ("arctrue", name), context)
    return "".join(parts)


def _command(
    command: click.Command, words: tuple[str, ...], parent: click.Context
) -> Iterator[str]:
    context = click.Context(command, info_name=words[-1], parent=parent, **command.context_settings)
    yield f"\n{'#' * (len(words) + 1)} {' '.join(words)}\n\n"
    yield f"`{' '.join([' '.join(words), *command.collect_usage_pieces(context)])}`\n\n"
    yield f"{_paragraphs(command.help or '')}\n"
    rows = [row for param in command.params if (row := _option(param, context))]
    if rows:
        yield "\n| Option | | Default |\n|---|---|---|\n" + "".join(rows)
    if isinstance(command, click.Group):
        for name in command.list_commands(context):
            below = command.get_command(context, name)
            assert below is not None, name
            yield from _command(below, (*words, name), context)


def _paragraphs(text: str) -> str:
    """Return the paragraphs of a help text, each in one line."""
    blocks = re.split(r"\n\s*\n", inspect.cleandoc(text))
    return "\n\n".join(" ".join(block.split()) for block in blocks)


def _option(param: click.Parameter, context: click.Context) -> str:
    if not isinstance(param, click.Option) or param.hidden:
        return ""
    names = ", ".join(f"`{name}`" for name in [*param.opts, *param.secondary_opts])
    value = "" if param.is_flag else f" `{_cell(param.make_metavar(context))}`"
    many = " (again for more)" if param.multiple else ""
    described, default = _default(param)
    return f"| {names}{value} | {_cell(described)}{many} | {_cell(default)} |\n"


def _default(param: click.Option) -> tuple[str, str]:
    """Return the help text of an option without the default value, and the default value."""
    described = param.help or ""
    found = re.search(r"\s*\[default: (.*)\]$", described)
    if found:
        return described[: found.start()], found[1]
    if param.required:
        return described, "required"
    if isinstance(param.show_default, str):
        return described, param.show_default
    return described, str(param.default) if param.show_default else ""


def _cell(text: str) -> str:
    return " ".join(text.split()).replace("|", "\\|")


def api_page() -> str:
    """Return ``docs/api.md``: the public names, with their arguments and results."""
    from arctrue import api
    from arctrue.importing import FileContent
    from arctrue.instrument import Instrument
    from arctrue.measurement import Capture, MeasurementSet, Reference, Table
    from arctrue.workbench.effects.base import Effect

    parts = [API_HEAD, "\n## arctrue\n"]
    parts += [_described(getattr(api, name), f"at.{name}") for name in sorted(api.__all__)]
    parts.append("\n## arctrue.measurement\n")
    parts += [
        _described(kind, kind.__name__) for kind in (MeasurementSet, Table, Capture, Reference)
    ]
    parts.append("\n## Own effects, readers and the instrument\n")
    for kind in (Effect, FileContent, Instrument):
        parts.append(_described(kind, f"{kind.__module__}.{kind.__name__}"))
    return "".join(parts)


def _described(what: Any, name: str) -> str:
    """Return the description of one public name: its purpose, its fields or arguments, its public
    methods."""
    if not inspect.isclass(what):
        return f"\n### {name}\n\n```python\n{name}{_signature(what)}\n```\n\n{_words(what)}\n"
    text = f"\n### {name}\n\n{_words(what)}\n"
    fields = list(_fields(what))
    # The table has a column of bounds if any field has bounds.
    columns = 3 if any(bounds for *_, bounds in fields) else 2
    if fields:
        text += "\n| Field | Type |" + " |" * (columns - 2) + "\n|" + "---|" * columns + "\n"
        text += "".join(f"| {' | '.join(row[:columns])} |\n" for row in fields)
    for key, member in _methods(what):
        static = isinstance(member, classmethod | staticmethod)
        method = member.__func__ if static else member
        if isinstance(member, property):
            text += f"\n**`{key}`** {_words(member)}\n"
        else:
            text += f"\n**`{key}{_signature(method)}`** {_words(method)}\n"
    return text


def _fields(kind: type) -> Iterator[tuple[str, str, str]]:
    """Yield each field with its plain type and, if the type has bounds, the bounds in words."""
    if not dataclasses.is_dataclass(kind):
        return
    for item in dataclasses.fields(kind):
        if item.name.startswith("_"):
            continue
        text, bounds = str(item.type), ""
        declared = get_type_hints(kind, include_extras=True)[item.name]
        if "Annotated[" in str(declared):
            plain = inspect.formatannotation(get_type_hints(kind)[item.name])
            text, bounds = re.sub(r"Optional\[(.*)\]", r"\1 | None", plain), bound_words(declared)
        yield f"`{item.name}`", f"`{_cell(text)}`", bounds


def _methods(kind: type) -> Iterator[tuple[str, Any]]:
    """Yield the public methods and properties of a class and of its bases in the same package, if
    they have docstrings; those of a base first, in the order of the source."""
    package = kind.__module__.rpartition(".")[0]
    bases = [one for one in reversed(kind.__mro__) if one.__module__.rpartition(".")[0] == package]
    for key, member in {key: one for base in bases for key, one in vars(base).items()}.items():
        function = member.__func__ if isinstance(member, classmethod | staticmethod) else member
        callable_ = inspect.isfunction(function) or isinstance(function, property)
        if not key.startswith("_") and callable_ and function.__doc__:
            yield key, member


def _signature(function: Any) -> str:
    """Return the arguments of a function with their types, in the form of the source."""
    shown = []
    before: Any = None
    for item in inspect.signature(function).parameters.values():
        if item.name in ("self", "cls"):
            continue
        if item.kind is item.KEYWORD_ONLY and before not in (
            item.KEYWORD_ONLY,
            item.VAR_POSITIONAL,
        ):
            shown.append("*")
        before = item.kind
        star = "*" if item.kind is item.VAR_POSITIONAL else ""
        star = "**" if item.kind is item.VAR_KEYWORD else star
        default = "" if item.default is item.empty else f" = {item.default!r}"
        kind = "" if item.annotation is item.empty else f": {item.annotation}"
        shown.append(f"{star}{item.name}{kind}{default}")
    result = inspect.signature(function).return_annotation
    return f"({', '.join(shown)})" + ("" if result is inspect.Signature.empty else f" -> {result}")


SECTION = re.compile(r"^(\w[\w ]*)\n-{3,}$", re.MULTILINE)
"""Pattern of the heading of a numpydoc section, which is underlined."""


def _words(what: Any) -> str:
    """Return a docstring as Markdown: ``code`` and Sphinx roles as code, numpydoc sections as
    lists."""
    text = inspect.cleandoc(what.__doc__ or "")
    headings = list(SECTION.finditer(text))
    ends = [*(item.start() for item in headings[1:]), len(text)][: len(headings)]
    parts = [_plain(_paragraphs(text[: headings[0].start()] if headings else text))]
    for heading, end in zip(headings, ends, strict=True):
        body = text[heading.end() : end].strip("\n")
        if heading[1] == "Examples":
            parts.append(f"```python\n{body}\n```")
            continue
        listed = "".join(map(_entry, re.split(r"\n(?=\S)", body)))
        parts.append(f"{heading[1]}:\n\n{listed}".rstrip())
    return "\n\n".join(parts)


def _entry(text: str) -> str:
    """Format one parameter, result or exception: name and type, then its description."""
    head, _, words = text.partition("\n")
    name, colon, kind = head.partition(" : ")
    stars = name.replace("*", "\\*") if not colon and name.startswith("*") else f"`{name}`"
    typed = f" ({_plain(kind)})" if colon else ""
    return f"- {stars}{typed}: {_plain(' '.join(words.split()))}\n"


def _plain(text: str) -> str:
    """Convert ``code`` and Sphinx roles to code of Markdown."""
    return re.sub(r":\w+:`~?([^`]+)`", r"`\1`", text).replace("``", "`")
