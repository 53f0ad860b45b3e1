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

from arctrue.gateware.lane_words import ORDER_MAX
from arctrue.report.taken_away_table import TAKEN, stored
from arctrue.workbench.effects.base import Effect
from arctrue.workbench.effects.registry import built_in

ROOT = Path(__file__).resolve().parents[1]
PAGE = Path("docs/effects.md")

COMPENSATED = {
    "lanes": "by lanes",
    "offset": "by the offset",
    "modulators": "by lanes of a bitstream with `MODULATORS`",
    "local_table": "by the table of a bitstream with `LOCAL_TABLE`",
    "none": "no",
    "reference": "nothing to correct",
}

HEAD = """\
<!-- Made by scripts/make_effects_page.py from the catalogue of effects. Do not edit: make docs -->

# Physical effects

This page lists the physical effects that a model of a rotary table with two heads on one disc may
have to contain. Each effect is one file in
[the catalogue](../sim/arctrue/workbench/effects/catalogue). A script makes this page from these
files, and `arctrue effects show NAME` prints them. You can add your own effect with the same
interface: [how to write an effect](own-effect.md).

θ is the angle of the table, and θ *unwrapped* counts on over several turns. α is the angle between
the heads, and ψ is the angle of the disc under a head: θ for head 1, θ + α for head 2
([head geometry](architecture.md#head-geometry)). ω is the speed, d the direction (±1), T the
temperature, T₀ the reference temperature of the set. R₁ and R₂ are the readings of the heads.
ε(ψ) is the error of the disc at ψ, ε or ε₁ the error of head 1 (R₁ − θ), and ε_h the error of head
h. δ₂₁ = R₂ − R₁ − α is the difference of the heads without its nominal value. A harmonic of
*order* n has n periods per turn; N is the highest order of `graduation_harmonics`.

A *capture* records both heads over time; it shows R₂ − R₁. A *reference run* compares head 1 with a
polygon or another reference at some angles (*stations*); it shows ε. "Reference only" means that
only reference runs show the error. 1 µm at the disc (radius 54 mm) is 3.82″.

A *lane* is a circuit of the gateware that adds one harmonic to the correction. A *bitstream* is a
build of the gateware; `MODULATORS`, `REAL_ORDERS` and `LOCAL_TABLE` are options with which a
bitstream is built ([extensions of the map](map-extensions.md)). With `MODULATORS`, the amplitudes
of lanes follow direction or speed; with `REAL_ORDERS`, lanes accept orders that are not integers;
`LOCAL_TABLE` adds a table of corrections over the turn or parts of it. The default bitstream has
none of these options.

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
    faces = measured["effects"]["polygon_face_error"]
    lines = [
        "",
        "## Which part of the gateware corrects it",
        "",
        "A lane adds one harmonic a·cos(nR + φ) to the correction of head 1; R is the reading of",
        f"head 1, and n is at most {ORDER_MAX:,}. A register, the offset, adds a constant. The",
        "firmware calculates the coefficients of some lanes from the temperature of the table. The",
        "default bitstream can correct an error of head 1 that is a function of the reading, or of",
        "the reading and the temperature, and no other error. `arctrue export` states for every",
        "effect of a fitted model which part of the gateware corrects it.",
        "",
        "`python -m scripts.measure_taken_away` measures the figures below. It simulates a rotary",
        "table with an eccentric disc and the effect, records a set with noise, fits one model",
        "without and one model with the effect, and exports the lanes. It then compares the lanes'",
        "correction with the true error of head 1 on a turn up and a turn down at "
        f"{measured['temperature_c']:g} °C, a",
        "temperature at which the set has no run. The figures are RMS values in arcseconds.",
        "*Remains* refers to the whole error, which contains the eccentricity of the disc.",
        "Direction and speed are constant in each of the two turns; for `MODULATORS` the script",
        "therefore uses one value of direction and speed per turn. For effects that move axis or",
        "disc, it also calibrates the weighted mean of four heads ([heads](heads.md)).",
        "",
        "| Effect | Simulated | Adds to the error of head 1 | Remains, effect not in the model "
        "| Remains, effect in the model | Corrected by |",
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
        if "left_in_mean_arcsec" in row:
            if words == TAKEN["nothing"]:
                words = f"two heads: {words}"
            words += f"; four heads: the weighted mean, {row['left_in_mean_arcsec']:.3f}″ remain"
        figures = " | ".join(
            f"{row[key]:.3f}" for key in ("part_arcsec", "left_without_arcsec", "left_with_arcsec")
        )
        lines.append(f"| [`{name}`](#{name}) | {row['simulated']} | {figures} | {words} |")
    lines += [
        "",
        "The model must also contain an effect that no part of the gateware corrects. Otherwise",
        "the fit may attribute the effect to orders of the turn, and lanes then add a wrong",
        "correction: for `polygon_face_error` "
        f"{faces['left_without_arcsec']:.3f}″ remain in place of",
        f"{faces['left_with_arcsec']:.3f}″. "
        "The figures do not contain errors of the reference; for such an",
        "effect `arctrue export` states that the reference has the error. The simulated gear of",
        "`drive_gear_error` is eccentric and also causes the two orders next to its tooth count.",
        "The fitted model contains them (settings `below` and `above`).",
        "The effect `periodic_error` was measured with a gear of the same kind. Its search finds",
        "the order as a real number, so a lane of a bitstream with `REAL_ORDERS` corrects it. The",
        "model has one such line; the two lines next to it remain.",
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
        print(f"{PAGE} differs from its sources: run make docs", file=sys.stderr)
        return 1
    page.write_text(text, encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
