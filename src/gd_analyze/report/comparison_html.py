"""The comparison of formulations as one HTML file that opens offline."""

from __future__ import annotations

from markupsafe import Markup

from gd_analyze.report.comparison import SHORT, ComparisonContext
from gd_analyze.report.comparison_chart import SCREEN, growth_chart
from gd_analyze.report.html import environment, style


def render_comparison_html(context: ComparisonContext) -> str:
    """Write the page of one comparison; styles, charts and the theme switch are inside it."""
    largest = max(max(row) for row in context.torque_differences)
    return (
        environment()
        .get_template("comparison.html.j2")
        .render(
            c=context,
            short=SHORT,
            charts={which: Markup(growth_chart(context, which, SCREEN)) for which in ("executed", "folded")},
            largest=largest,
            slowest=max(context.seconds_pinocchio, *(row.seconds for row in context.methods)),
            style=style("report.css", "comparison.css"),
        )
    )
