"""Writes the documents that are made from the sources: pages of entities, registers, number
formats, commands and API, tables, and a picture.

Run ``python -m scripts.make_docs``. With ``--check`` the script writes nothing and names the
documents that differ from their sources (exit code 1). The pages are committed, so that people can
read them together with the code.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from arctrue.report.benchmark_sets_page import benchmark_sets_page
from arctrue.workbench.diagnose.rules.table import rule_table
from scripts.data_way import draw
from scripts.reference_pages import api_page, commands_page
from scripts.register_page import register_page

ROOT = Path(__file__).resolve().parents[1]
ENTITIES = Path("docs/entities")
WORKBENCH = Path("docs/workbench.md")
RULES, END_OF_RULES = "<!-- The rules: made by scripts/make_docs.py -->\n", "<!-- End -->\n"
NUMBER_FORMATS = Path("rtl/formats/number_formats_pkg.vhd")

# Folders of rtl/ that data pass through, in this order; all other folders follow them.
WAY = (
    "decoder",
    "sampler",
    "coefficients",
    "phase",
    "harmonic",
    "local_table",
    "compensation",
    "quadrature_output",
    "signals",
    "registers",
    "core",
)

DECLARATION = re.compile(r"^(?P<names>[\w\s,]+?)\s*:\s*(?P<rest>.+)$")
RECORD = re.compile(r"^  type (\w+) is record\n(.*?)^  end record", re.MULTILINE | re.DOTALL)
MODE = re.compile(r"^(?P<mode>inout|in|out|buffer)\s+(?P<type>.+)$", re.IGNORECASE)


@dataclass(frozen=True)
class Item:
    """Generic or port of an entity, or element of a record.

    ``mode`` is empty except for a port; ``heading`` is the heading of the group that begins with
    this item, or empty.
    """

    names: str
    mode: str
    type_: str
    default: str
    remark: str
    heading: str


@dataclass(frozen=True)
class Entity:
    """Entity with the content of its page."""

    name: str
    source: Path
    header: str
    generics: tuple[Item, ...]
    ports: tuple[Item, ...]
    uses: tuple[str, ...]


def read_header(lines: list[str], source: Path) -> tuple[str, str]:
    """Return name and markdown text of the comment at the head of a VHDL file.

    Raises ValueError if the comment does not have the form that CONTRIBUTING.md states.
    """
    comment: list[str] = []
    for line in lines:
        if not line.startswith("--"):
            break
        comment.append(line[2:].removeprefix(" ").rstrip())
    if not comment or not comment[0].startswith("SPDX-License-Identifier:"):
        raise ValueError(f"{source}:1: expected '-- SPDX-License-Identifier: Apache-2.0'")
    body = comment[1:]
    while body and not body[0]:
        body = body[1:]
    if not body or not body[0].startswith("# "):
        raise ValueError(f"{source}: expected a line '-- # {source.stem}' after the licence")
    name = body[0][2:].strip()
    if name != source.stem:
        raise ValueError(f"{source}: the header names '{name}', the file '{source.stem}'")
    return name, "\n".join(body[1:]).strip()


def _clause(text: str, keyword: str) -> str | None:
    """Return the text between the brackets of ``generic ( ... );`` or ``port ( ... );``."""
    start = re.search(rf"^\s*{keyword}\s*\(", text, re.IGNORECASE | re.MULTILINE)
    if not start:
        return None
    depth = 1
    position = start.end()
    while depth:
        if text.startswith("--", position):
            position = text.index("\n", position)
        depth += {"(": 1, ")": -1}.get(text[position], 0)
        position += 1
    return text[start.end() : position - 1]


def read_items(clause: str, source: Path) -> tuple[Item, ...]:
    """Return the declarations of a generic clause, port clause or record, each with its comment.

    Raises ValueError unless each declaration is on a line of its own.
    """
    items: list[Item] = []
    heading = ""
    for line in clause.splitlines():
        code, _, remark = (part.strip() for part in line.partition("--"))
        if not code:
            heading = remark.rstrip(".:") if remark else heading
            continue
        found = DECLARATION.match(code.rstrip(";").strip())
        if not found:
            raise ValueError(f"{source}: expected one declaration a line, found '{line.strip()}'")
        names = ", ".join(name.strip() for name in found["names"].split(","))
        rest, _, default = (part.strip() for part in found["rest"].partition(":="))
        moded = MODE.match(rest)
        mode = moded["mode"].lower() if moded else ""
        type_ = moded["type"].strip() if moded else rest
        items.append(Item(names, mode, type_, default, remark, heading))
        heading = ""
    return tuple(items)


def read_entity(root: Path, source: Path) -> Entity:
    """Return header, generics, ports and used entities of ``source``, a path below ``root``."""
    text = (root / source).read_text(encoding="utf-8")
    name, header = read_header(text.splitlines(), source)
    found = re.search(
        rf"^entity\s+{name}\s+is\b(.*?)^end\s+entity",
        text,
        re.MULTILINE | re.DOTALL | re.IGNORECASE,
    )
    if not found:
        raise ValueError(f"{source}: found no 'entity {name} is ... end entity'")
    generics = _clause(found[1], "generic")
    ports = _clause(found[1], "port")
    uses = sorted(set(re.findall(r"\bentity\s+work\.(\w+)", text)))
    return Entity(
        name,
        source,
        header,
        read_items(generics, source) if generics else (),
        read_items(ports, source) if ports else (),
        tuple(uses),
    )


def find_records(root: Path) -> dict[str, tuple[Item, ...]]:
    """Return the elements of each record type of the packages below rtl/."""
    return {
        name: read_items(body, path.relative_to(root))
        for path in sorted((root / "rtl").rglob("*_pkg.vhd"))
        for name, body in RECORD.findall(path.read_text(encoding="utf-8"))
    }


def find_entities(root: Path) -> list[Entity]:
    """Return all entities below rtl/: first the folders of WAY in its order, then the other
    folders; within a folder by name."""
    entities: list[Entity] = []
    for path in sorted((root / "rtl").rglob("*.vhd")):
        if re.search(
            rf"^entity\s+{path.stem}\s+is\b", path.read_text(encoding="utf-8"), re.M | re.I
        ):
            entities.append(read_entity(root, path.relative_to(root)))
    return sorted(
        entities, key=lambda entity: (_place(entity), entity.source.parts[1], entity.name)
    )


def _place(entity: Entity) -> int:
    folder = entity.source.parts[1]
    return WAY.index(folder) if folder in WAY else len(WAY)


def _code(text: str) -> str:
    return f"`{text.replace('|', chr(92) + '|')}`" if text else ""


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _generics_table(items: tuple[Item, ...]) -> list[str]:
    lines = ["| Generic | Type | Default | |", "|---|---|---|---|"]
    for item in items:
        lines.append(
            f"| {_code(item.names)} | {_code(item.type_)} | {_code(item.default)} "
            f"| {_cell(item.remark)} |"
        )
    return lines


def _ports_table(items: tuple[Item, ...], records: Mapping[str, tuple[Item, ...]]) -> list[str]:
    """Return the table of the ports; the rows of a record's elements follow the row of the record
    port."""
    lines = ["| Port | Direction | Type | |", "|---|---|---|---|"]
    for item in items:
        elements = [
            replace(element, names=f"{item.names}.{element.names}", mode=item.mode)
            for element in records.get(item.type_, ())
        ]
        for row in (item, *elements):
            if row.heading:
                lines.append(f"| **{_cell(row.heading)}** | | | |")
            lines.append(
                f"| {_code(row.names)} | {row.mode} | {_code(row.type_)} | {_cell(row.remark)} |"
            )
    return lines


def _related(root: Path, entity: Entity, entities: list[Entity]) -> list[str]:
    """Return links to source, model and test bench of an entity, and to the entities above and
    below."""

    def link(path: Path) -> str:
        return f"[{path}](../../{path})"

    known = {other.name for other in entities}
    lines = [f"- Source: {link(entity.source)}"]
    model = Path("sim/arctrue/gateware") / f"{entity.name}.py"
    if (root / model).exists():
        lines.append(f"- Bit-true model: {link(model)}")
    tests = [
        path.relative_to(root)
        for folder in ("tb", "sim/tests")
        for path in sorted((root / folder).rglob(f"test_{entity.name}.py"))
    ]
    lines += [f"- Tests: {', '.join(link(path) for path in tests)}"] if tests else []
    below = [f"[{name}]({name}.md)" if name in known else f"`{name}`" for name in entity.uses]
    lines += [f"- Built of: {', '.join(below)}"] if below else []
    above = [f"[{other.name}]({other.name}.md)" for other in entities if entity.name in other.uses]
    lines += [f"- Part of: {', '.join(above)}"] if above else []
    return lines


def entity_page(root: Path, entity: Entity, entities: list[Entity]) -> str:
    """Return the markdown page of one entity."""
    lines = [
        f"<!-- Made by scripts/make_docs.py from {entity.source}. Do not edit: make docs -->",
        "",
        f"# {entity.name}",
        "",
        entity.header,
        "",
    ]
    if entity.generics:
        lines += ["## Generics", "", *_generics_table(entity.generics), ""]
    if entity.ports:
        lines += ["## Ports", "", *_ports_table(entity.ports, find_records(root)), ""]
    lines += ["## See also", "", *_related(root, entity, entities)]
    return "\n".join(lines) + "\n"


def first_sentence(text: str) -> str:
    """Return the first sentence of an entity's header, for the list of entities."""
    paragraph = " ".join(text.split("\n\n", 1)[0].split())
    found = re.match(r"(.+?[.:])(?:\s+[A-Z`*(]|$)", paragraph)
    return (found[1] if found else paragraph).rstrip(":.") + "."


def entities_index(entities: list[Entity]) -> str:
    """Return the page that lists all entities."""
    lines = [
        "<!-- Made by scripts/make_docs.py. Do not edit: make docs -->",
        "",
        "# Entities",
        "",
        "Each entity has one page, which is made from the header of its source. The folders stand",
        "in the order in which data pass through them ([architecture](../architecture.md)), then",
        "the other folders. The page [number formats](../number-formats.md) lists the formats of",
        "the numbers.",
    ]
    folder = ""
    for entity in entities:
        if entity.source.parts[1] != folder:
            folder = entity.source.parts[1]
            lines += ["", f"## rtl/{folder}", ""]
        lines.append(f"- [{entity.name}]({entity.name}.md): {first_sentence(entity.header)}")
    return "\n".join(lines) + "\n"


FORMAT_LINE = re.compile(
    r"^--   (?P<name>\w[^ ]*(?: [^ ]+)*?)\s{2,}(?P<format>[us]\d+\.\d+)\s+(?P<meaning>.+)$"
)
CONSTANT_LINE = re.compile(
    r"^\s*constant\s+(\w+)\s*:\s*\w+\s*:=\s*(\d+)\s*;\s*(?:--\s*(.*))?$", re.I
)
CONTINUED_LINE = re.compile(r"^--\s{10,}(?P<more>\S.*)$")


def number_formats_page(package: str) -> str:
    """Return the page of the number formats, from the text of the VHDL package."""
    formats: list[list[str]] = []
    for line in package.splitlines():
        if found := FORMAT_LINE.match(line):
            formats.append([found["name"], found["format"], found["meaning"]])
        elif formats and (more := CONTINUED_LINE.match(line)):
            formats[-1][2] += " " + more["more"]
    constants: list[tuple[str, str, str]] = []
    remark: list[str] = []
    for line in package[package.index("\npackage ") :].splitlines():
        if found := CONSTANT_LINE.match(line):
            constants.append((found[1], found[2], found[3] or " ".join(remark)))
            remark = []
        elif line.strip().startswith("--"):
            remark.append(line.strip().removeprefix("--").strip())
        elif not line.strip():
            remark = []
    lines = [
        f"<!-- Made by scripts/make_docs.py from {NUMBER_FORMATS}. Do not edit: make docs -->",
        "",
        "# Number formats",
        "",
        f"The number formats are defined in one place, [{NUMBER_FORMATS}](../{NUMBER_FORMATS}).",
        "`make generate` makes from this file the Python module "
        "`arctrue.generated.number_formats` and the",
        "C header `build/generated/c/arctrue_number_formats.h`.",
        "",
        "uI.F is unsigned with I integer and F fraction bits (I + F bits); sI.F is signed:",
        "a sign, I integer and F fraction bits (1 + I + F bits).",
        "",
        "| Quantity | Format | Bits | Meaning |",
        "|---|---|---|---|",
    ]
    for name, form, meaning in formats:
        integer, fraction = (int(part) for part in form[1:].split("."))
        bits = integer + fraction + (form[0] == "s")
        lines.append(f"| {name} | {form} | {bits} | {_cell(meaning.replace('**', '^'))} |")
    lines += ["", "## Constants", "", "| Constant | Value | |", "|---|---|---|"]
    lines += [f"| `{name}` | {value} | {_cell(words)} |" for name, value, words in constants]
    return "\n".join(lines) + "\n"


def with_rules(page: str) -> str:
    """Return the page of the workbench with the rules by which the program reaches a verdict."""
    before, _, rest = page.partition(RULES)
    after = rest.partition(END_OF_RULES)[2]
    return "".join(
        [before, RULES, "\n", *(f"{line}\n" for line in rule_table()), "\n", END_OF_RULES, after]
    )


def documents(root: Path) -> dict[Path, str]:
    """Return every generated document: its text by its path below ``root``."""
    entities = find_entities(root)
    made = {
        ENTITIES / f"{entity.name}.md": entity_page(root, entity, entities) for entity in entities
    }
    made[ENTITIES / "README.md"] = entities_index(entities)
    package = (root / NUMBER_FORMATS).read_text(encoding="utf-8")
    made[Path("docs/number-formats.md")] = number_formats_page(package)
    made[Path("docs/registers.md")] = register_page(root)
    made[Path("docs/commands.md")] = commands_page()
    made[Path("docs/api.md")] = api_page()
    made[Path("docs/benchmark-sets.md")] = benchmark_sets_page()
    made[Path("docs/images/data_way.svg")] = draw()
    if (root / WORKBENCH).exists():
        made[WORKBENCH] = with_rules((root / WORKBENCH).read_text(encoding="utf-8"))
    return made


def stale_documents(root: Path) -> list[Path]:
    """Return the generated documents that differ from their sources, are missing, or have no source
    any more."""
    made = documents(root)
    stale = [
        path
        for path, text in made.items()
        if not (root / path).exists() or (root / path).read_text(encoding="utf-8") != text
    ]
    pages = ((root / ENTITIES).glob("*.md")) if (root / ENTITIES).exists() else ()
    return stale + [page.relative_to(root) for page in pages if page.relative_to(root) not in made]


def main(arguments: Sequence[str] | None = None) -> int:
    """Write or check all generated documents; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; name what differs")
    given = parser.parse_args(arguments)
    stale = stale_documents(ROOT)
    if given.check:
        for path in stale:
            print(f"{path}: differs from its source; run 'make docs'", file=sys.stderr)
        return 1 if stale else 0
    made = documents(ROOT)
    for path in stale:
        print(f"{path}")
        if path in made:
            (ROOT / path).parent.mkdir(parents=True, exist_ok=True)
            (ROOT / path).write_text(made[path], encoding="utf-8")
        else:
            (ROOT / path).unlink()
    return 0


if __name__ == "__main__":
    sys.exit(main())
