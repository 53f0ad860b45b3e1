"""Writes docs/effects.md, the catalogue of physical effects, from the declarations of the effects.

docs/data/taken_away.json contains the error that remains after the lanes
(scripts/measure_taken_away.py). Run ``python -m scripts.make_effects_page``. With ``--check`` the
script writes nothing and names a page that differs from the declarations (exit code 1).
"""

from __future__ import annotations

import argparse
import inspect
import sys
from collections.abc import Sequence
from pathlib import Path

from arctrue.gateware.coefficients import ORDER_MAX
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import built_in
from scripts.measure_taken_away import stored

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path("docs/effects.md")

COMPENSATED = {
    "lanes": "by lanes",
    "offset": "by the offset",
    "modulators": "by lanes of a bitstream with `MODULATORS`",
    "local_table": "by the table of a bitstream with `LOCAL_TABLE`",
    "none": "no",
    "reference": "nothing to take away",
}

TAKEN = {
    "lanes": "lanes",
    "firmware's model": "the firmware's model: lanes at the table's temperature",
    "lanes by condition": "lanes of a bitstream with `MODULATORS`",
    "lanes of real orders": "lanes of a bitstream with `REAL_ORDERS`",
    "local table": "the table of a bitstream with `LOCAL_TABLE`",
    "nothing": "nothing",
    "not in the output": "not in the output: head 2 alone has it",
    "reference": "no error of the table, but of the reference",
}

HEAD = """\
<!-- Made by scripts/make_effects_page.py from the catalogue of effects. Do not edit: make docs -->

# Physical effects

This page lists what can be missing from a model of a rotary table with two heads on one disc. Each
effect is one file in [the catalogue](../sim/arctrue/workbench/effects/catalogue). This page and
`arctrue effects show NAME` are made from these files. An effect of your own uses the same
interface: [how to write one](own-effect.md).

θ is the angle of the table, ψ the angle of the disc under a head (θ for head 1, θ + α for
head 2: [head geometry](architecture.md#head-geometry)), ω the speed, d the direction (±1), T the
temperature, R the reading of a head. *Capture*: both heads over time, which shows R₂ − R₁.
*Reference run*: head 1 against a polygon or another reference, which shows ε. 1 µm at the disc
is 3.82″.

"""


def compensation_words(effect: type[Effect]) -> str:
    """Return a text that states which part of the gateware can correct the effect, if any."""
    words = COMPENSATED[effect.compensation]
    return f"{words}; {effect.compensation_note}" if effect.compensation_note else words


def _cell(text: str) -> str:
    return text.replace("|", "\\|")


def _summary(effects: dict[str, type[Effect]]) -> list[str]:
    lines = [
        "| Effect | Equation | Compensated by the gateware |",
        "|---|---|---|",
    ]
    for name, effect in effects.items():
        equation, words = _cell(effect.equation), _cell(compensation_words(effect))
        lines.append(f"| [`{name}`](#{name}) | {equation} | {words} |")
    return lines


def _compensation(effects: dict[str, type[Effect]]) -> list[str]:
    """Return a table: the part that corrects each effect on a simulated table, and the remaining
    error."""
    measured = stored()
    lines = [
        "",
        "## Who takes it away",
        "",
        "A lane adds one harmonic a·cos(nR + φ) of the reading R of head 1, "
        f"n up to {ORDER_MAX:,};",
        "the offset adds a constant. The firmware calculates some lanes for the temperature of the",
        "table. An error of head 1 that is a function of its reading, or of that and the",
        "temperature, can be taken away; any other error cannot. `arctrue export` states the same",
        "for every effect of a fitted model.",
        "",
        "Measured by `python -m scripts.measure_taken_away`: a table with an eccentric disc and",
        "the effect, a recorded set with noise, a model without and with it, and the exported",
        "lanes against the true error of head 1 on a turn up and a turn down at "
        f"{measured['temperature_c']:g} °C, which is in",
        "no run of the set. RMS, arcseconds; *left* is of the whole error, with the disc's own.",
        "With `MODULATORS`, direction and speed are settled in either turn.",
        "",
        "| Effect | Simulated | Adds to the error of head 1 | Left, not in the model "
        "| Left, in the model | Taken away by |",
        "|---|---|---:|---:|---:|---|",
    ]
    for name in effects:
        row = measured["effects"].get(name)
        if row is None:
            lines.append(
                f"| [`{name}`](#{name}) | no: a table has no second axis | | | | nothing |"
            )
            continue
        words = TAKEN[row["taken_away_by"]]
        figures = " | ".join(
            f"{row[key]:.3f}" for key in ("part_arcsec", "left_without_arcsec", "left_with_arcsec")
        )
        lines.append(f"| [`{name}`](#{name}) | {row['simulated']} | {figures} | {words} |")
    lines += [
        "",
        "An effect that nothing takes away still belongs in the model: without it, the fit",
        "attributes it to orders, which lanes would then correct wrongly. Every judgement of the",
        "table excludes an error of the reference, and the export states this. The gear of",
        "`drive_gear_error` is off its centre: its lines next to the tooth count need the",
        "settings `below` and `above`. The same gear as `periodic_error` is one line at an order",
        "that is not whole, which has a lane in a bitstream with `REAL_ORDERS`.",
        "",
    ]
    return lines


def _section(name: str, effect: type[Effect]) -> list[str]:
    source = Path(inspect.getfile(effect)).resolve().relative_to(ROOT)
    lines = [
        "",
        f"## {name}",
        "",
        effect.physics,
        "",
        f"    {effect.equation}",
        "",
        "| | |",
        "|---|---|",
        f"| Capture sees | {_cell(effect.capture_sees)} |",
        f"| Reference run sees | {_cell(effect.reference_sees)} |",
        f"| Separated by | {_cell(effect.separated_by)} |",
        f"| Next measurement | {_cell(effect.next_measurement)} |",
        f"| Sizes seen | {_cell(effect.plausible)} |",
        f"| Compensated | {_cell(compensation_words(effect))} |",
    ]
    units = [
        f"`{key}`" if unit == "1" else f"`{key}` ({unit})"
        for key, unit in effect.parameter_units.items()
    ]
    lines.append(f"| Parameters | {', '.join(units)} |")
    for item in effect.search:
        unit = "" if item.unit == "1" else f" {item.unit}"
        lines.append(
            f"| Searched | `{item.name}`, {item.low:g} to {item.high:g}{unit}: "
            f"{_cell(item.meaning)} |"
        )
    for key, value in effect.defaults.items():
        lines.append(f"| Setting | `{key}`, {_setting(value)} unless set |")
    lines.append(f"| Source | {_cell(effect.source)}; [{source.name}](../{source}) |")
    return lines


def _setting(value: object) -> str:
    """Format the default value of a setting as in a model file; shorten a long sequence of
    numbers."""
    if isinstance(value, list | tuple) and len(value) > 6:
        return f"`{value[0]}` … `{value[-1]}`"
    return f"`{list(value)}`" if isinstance(value, tuple) else f"`{value}`"


def effects_page() -> str:
    """Return the page docs/effects.md in Markdown."""
    effects = built_in()
    lines = [*_summary(effects), *_compensation(effects)]
    for name, effect in effects.items():
        lines += _section(name, effect)
    return HEAD + "\n".join(lines).replace("\n\n\n", "\n\n").rstrip() + "\n"


def main(arguments: Sequence[str] | None = None) -> int:
    """Write docs/effects.md, or compare it with the declarations; return the exit code."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--check", action="store_true", help="write nothing; compare the page")
    given = parser.parse_args(arguments)
    page = ROOT / PAGE
    text = effects_page()
    if given.check:
        if page.exists() and page.read_text(encoding="utf-8") == text:
            return 0
        print(f"{PAGE} is not what its sources say: run make docs", file=sys.stderr)
        return 1
    page.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
