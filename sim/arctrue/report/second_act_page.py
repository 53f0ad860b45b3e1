"""The page of the demo's second act: one HTML file that needs no other."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from arctrue.report import hidden_figures
from arctrue.report.demo_page import page_templates
from arctrue.studies.demo.second_act import SecondAct
from arctrue.whole_file import write_whole_text


def write_second_act_page(act: SecondAct, file: Path) -> None:
    """Render it and write it, the folder included, with the three curves beside it."""
    result = act.result
    three_curves = hidden_figures.three_curves(result)
    added = result.examined.model.effects[-1]
    page = (
        page_templates()
        .get_template("second_act.html.j2")
        .render(
            act=act,
            result=result,
            scale=result.settings.revolution,
            steps=result.examined.ladder,
            parameters=added.parameters if result.examined.effect else {},
            lanes=result.export.orders,
            curves=(
                ("head 1, raw", "before", result.raw),
                ("output, paper’s model", "paper", result.paper),
                ("output, with the effect", "after", result.corrected),
            ),
            turn_figure=Markup(three_curves),
            period_figure=Markup(hidden_figures.signal_period(result)),
            ladder_figure=Markup(hidden_figures.ladder(result)),
        )
    )
    write_whole_text(file, page)
    # The picture of docs/hidden-effect.md.
    write_whole_text(file.parent / "hidden_effect.svg", three_curves)
