"""Makes the page of the demo's second act: one self-contained HTML file."""

from __future__ import annotations

from pathlib import Path

from markupsafe import Markup

from arctrue.base.whole_file import write_whole_text
from arctrue.report.charts.hidden_charts import signal_period, three_curves
from arctrue.report.charts.ladder import ladder
from arctrue.report.charts.matplotlib_chart import chart_svg, save_chart
from arctrue.report.demo_page import page_templates
from arctrue.report.taken_away_table import taken_away_table
from arctrue.studies.demo.second_act import SecondAct
from arctrue.workbench.model.noise_floor import with_one_floor


def write_second_act_page(act: SecondAct, file: Path, first_act: str = "") -> None:
    """Render the page and write it with its three curves; make the folder if it does not exist.

    ``first_act``: the name of the first act's page, if there is one.
    """
    result = act.result
    turn_figure = three_curves(result)
    added = result.diagnosed.model.effects[-1]
    page = (
        page_templates()
        .get_template("second_act.html.j2")
        .render(
            act=act,
            first_act=first_act,
            result=result,
            scale=result.settings.revolution,
            steps=with_one_floor(result.diagnosed.ladder),
            parameters=added.parameters if result.diagnosed.effect else {},
            lanes=result.export.orders,
            taken_away=taken_away_table(),
            curves=(
                ("head 1, raw", "before", result.raw, result.raw_period),
                ("output, paper’s model", "paper", result.paper, result.paper_period),
                (
                    "output, with the effect",
                    "after",
                    result.corrected,
                    result.corrected_period,
                ),
            ),
            turn_figure=Markup(chart_svg(turn_figure)),
            period_figure=Markup(chart_svg(signal_period(result))),
            ladder_figure=Markup(chart_svg(ladder(result.diagnosed.ladder))),
        )
    )
    write_whole_text(file, page)
    # docs/hidden-effect.md shows this picture.
    save_chart(turn_figure, file.parent / "hidden_effect.svg")
