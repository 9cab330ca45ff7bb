"""Covers of tests whose figures are held against a limit: within it or not, or that none was set."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

from markupsafe import Markup

from truepose.domain.validation import Decision, DecisionRule
from truepose.messages.catalogue import Catalogue
from truepose.messages.message import Message, Text, message, together
from truepose.reports.cover_page import DECIDED, Front, OneFigure, applied_rule, graded
from truepose.reports.pages import rendered
from truepose.reports.rounding import format_rounded, uncertainty_mm
from truepose.validation.outcome import judgement
from truepose.validation.uncertainty import Figure
from truepose.validation.validate import decide_figures

_WIDTH: Final = 330.0  # of the longest bar with its uncertainty, in units of the picture
_ROW: Final = 34
_TOP: Final = 14


@dataclass(frozen=True, slots=True)
class FigureBar:
    """A figure; lengths in units of the picture."""

    name: str
    y: int
    length: float
    low: float  # ends of the 95 % interval
    high: float
    text: str


def figure_bars(named: Sequence[tuple[str, Figure]], limit_mm: float | None, words: Catalogue) -> Markup:
    """Draw figures [mm] on one scale from 0, largest first; the limit is a line across all."""
    longest = max([abs(one.value) + 2.0 * one.standard_uncertainty for _, one in named] + [limit_mm or 0.0])
    scale = _WIDTH / (longest or 1.0)
    ranked = sorted(named, key=lambda one: abs(one[1].value), reverse=True)
    bars = [_bar(name, one, _TOP + _ROW * row, scale, words) for row, (name, one) in enumerate(ranked)]
    return rendered(
        "figure_bars.html",
        bars=bars,
        bottom=_TOP + _ROW * len(bars),
        limit=None if limit_mm is None else limit_mm * scale,
        limit_mm=limit_mm,
        say=words.say,
        words=words,
    )


def _bar(name: str, figure: Figure, y: int, scale: float, words: Catalogue) -> FigureBar:
    size, u = abs(figure.value), figure.standard_uncertainty
    ends = (max(size - 2.0 * u, 0.0) * scale, (size + 2.0 * u) * scale)
    text = words.units.quantity(format_rounded(size, 2.0 * u, "mm"), "mm")
    return FigureBar(name, y, size * scale, *ends, text)


@dataclass(frozen=True, slots=True)
class Limit:
    """What the figures of a test are held against; None: nobody set it."""

    limit_mm: float | None = None
    rule: DecisionRule = "guard band"


NO_LIMIT: Final = Limit()


@dataclass(frozen=True, slots=True)
class FigureNames:
    """What the figures of a kind of test are called; keys of the catalogue."""

    name: str
    largest: str
    bars: str


@dataclass(frozen=True, slots=True)
class LimitedTest:
    """A test whose figures, each of a joint or a ball, are held against a limit."""

    title: str
    robot: str
    of: FigureNames
    named: Sequence[tuple[str, Figure]]
    lacks: Text = ""  # why it says less than was asked for

    def front(self, limit: Limit, words: Catalogue) -> Front:
        """Return whether its largest figure stays within the limit."""
        decision = self._decision(limit)
        key, good = self._verdict(decision)
        name, worst = max(self.named, key=lambda one: abs(one[1].value), default=("", None))
        return Front(
            title=self.title,
            look=graded(good),
            word=words.say(key),
            outcome=words.spoken(self._outcome(decision, worst)),
            sentence=words.spoken(self._sentence(decision, name, worst)),
            robot=self.robot,
            figure=None if worst is None else self._figure(name, worst, words),
            picture=figure_bars(self.named, limit.limit_mm, words) if self.named else None,
            caption=words.say(self.of.bars) if self.named else "",
            rule=words.say("front.set_limit") if decision is None else applied_rule(decision, words),
        )

    def _decision(self, limit: Limit) -> Decision | None:
        if limit.limit_mm is None or not self.named:
            return None
        decision = decide_figures([figure for _, figure in self.named], limit.limit_mm, limit.rule)
        # What was withheld or skipped may have been beyond the limit; a failure stays one (commit b4587e21).
        if self.lacks and decision.verdict == "conforms":
            return replace(decision, verdict="cannot be decided")
        return decision

    def _verdict(self, decision: Decision | None) -> tuple[str, bool | None]:
        """Return the word and whether it is good; what was not measured cannot pass."""
        if not self.named:
            return "front.nothing", None
        if decision is None:
            return "front.no_limit_set", None
        return DECIDED[decision.verdict]

    def _outcome(self, decision: Decision | None, worst: Figure | None) -> Message:
        if worst is None:
            return message("outcome.nothing")
        size = format_rounded(abs(worst.value), worst.standard_uncertainty, "mm")
        judged = judgement(decision)
        return message("outcome.figure", name=message(self.of.name), size=size, judged=judged)

    def _sentence(self, decision: Decision | None, name: str, worst: Figure | None) -> Text:
        if worst is None:
            return self.lacks
        u = worst.standard_uncertainty
        size = format_rounded(abs(worst.value), u, "mm")
        largest = message(self.of.largest, value=size, u=uncertainty_mm(u), where=name)
        guard = 0.0 if decision is None else decision.guard_mm
        judged = message("front.guard", guard=uncertainty_mm(guard)) if guard else ""
        return together(largest, judged, self.lacks)

    def _figure(self, name: str, worst: Figure, words: Catalogue) -> OneFigure:
        expanded = 2.0 * worst.standard_uncertainty
        value = words.units.quantity(format_rounded(abs(worst.value), expanded, "mm"), "mm")
        return OneFigure(
            words.say(self.of.name), value, words.say("front.at_with", where=name, u=uncertainty_mm(expanded))
        )
