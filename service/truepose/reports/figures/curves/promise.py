"""The promised accuracy against the number of configurations."""

from functools import partial
from typing import Final

from markupsafe import Markup

from truepose.planning.promise.plan import PromisedPlan
from truepose.reports.figures.canvas import Colours, Drawing, marked_in, new_figure, on_page, plain
from truepose.words.catalogue import IN_ENGLISH, Catalogue

_STEEP: Final = 20.0  # times the error at the end: what follows would lie on the axis


def promise_curve(plan: PromisedPlan, words: Catalogue = IN_ENGLISH) -> Markup:
    """Return the curve of a plan, its band and the number that is planned, for a page."""
    return on_page(partial(_drawn, plan, words), "promise", words.say("plans.figure"))


def plain_promise_curve(plan: PromisedPlan) -> Drawing:
    """Return the same in ordinary colours, for a program."""
    return plain(partial(_drawn, plan, IN_ENGLISH))


def _drawn(plan: PromisedPlan, words: Catalogue, colours: Colours) -> Drawing:
    say = words.say
    figure = new_figure(7.0, 3.6)
    axes = figure.add_subplot()
    numbers = [point.n for point in plan.curve]
    low, high = zip(*(point.interval_90_mm for point in plan.curve), strict=True)
    axes.fill_between(
        numbers, low, high, color=colours.after, alpha=0.2, linewidth=0.0, label=say("plans.head.interval")
    )
    means = [point.mean_mm for point in plan.curve]
    axes.plot(numbers, means, "o-", color=colours.after, markersize=3.5, label=say("plans.head.mean"))
    worst = [point.worst_mm for point in plan.curve]
    axes.plot(numbers, worst, "--", color=colours.before, label=say("plans.head.worst"))
    axes.axvline(plan.total, color=colours.ink, linewidth=1.0, label=say("plans.figure.planned"))
    if plan.advised != plan.total:
        axes.axvline(
            plan.advised, color=colours.ink, linewidth=1.0, linestyle=":", label=say("plans.figure.knee")
        )
    axes.set_xlabel(say("plans.head.n"))
    axes.set_ylabel(words.units.conversion("mm").symbol)
    if means[0] > _STEEP * means[-1]:
        axes.set_yscale("log")
    else:
        axes.set_ylim(bottom=0.0)
    marked_in(axes.yaxis, words.units.conversion("mm"))
    axes.legend()
    return figure
