"""The first page of a circle test and of a sphere test: within a limit or not, or that none was set."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

from truepose.domain.results.validation import Decision, DecisionRule
from truepose.domain.sentences import Text, said, together
from truepose.judgement.circle.judged import CircleTest
from truepose.judgement.decision import decide_figures
from truepose.judgement.figure import Figure
from truepose.judgement.sphere.judged import Sphere, SphereTest
from truepose.reports.circles.sentences import withheld_sentences
from truepose.reports.front.figure_bars import figure_bars
from truepose.reports.front.kinds import DECIDED, applied_rule
from truepose.reports.front.page import Front, OneFigure, graded
from truepose.reports.spheres.sentences import model_name
from truepose.reports.wording.rounding import rounded, uncertainty_mm
from truepose.words.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Limit:
    """What the figures of a test are held against; None: nobody set it."""

    limit_mm: float | None = None
    rule: DecisionRule = "guard band"


NO_LIMIT: Final = Limit()


@dataclass(frozen=True, slots=True)
class _Figures:
    """What the figures of a kind of test are called; keys of the catalogue."""

    name: str
    largest: str
    bars: str


_CIRCLES: Final = _Figures("front.circles", "front.circles.largest", "front.circles.bars")
_SPHERE: Final = _Figures("front.sphere", "front.sphere.largest", "front.sphere.bars")


@dataclass(frozen=True, slots=True)
class _Tested:
    """A test as its first page tells it."""

    title: str
    robot: str
    of: _Figures
    named: Sequence[tuple[str, Figure]]  # of each joint or ball
    lacks: Text = ""  # why it says less than was asked for


def circles_front(test: CircleTest, robot: str, limit: Limit, words: Catalogue) -> Front:
    """Return whether the joints' tangential errors stay within a limit from end to end."""
    named = [
        (words.say("front.of_joint", joint=one.joint, nest=one.nest), one.tangential_range_mm)
        for one in test.circles
    ]
    lacks = together(*withheld_sentences(test))
    title = words.say("circles.title", robot=robot)
    return _front(_Tested(title, robot, _CIRCLES, named, lacks), limit, words)


def sphere_front(test: SphereTest, robot: str, model: str, limit: Limit, words: Catalogue) -> Front:
    """Return whether the radial errors of a model stay within a limit.

    They are about the taught centre, which is how the arm is used; about the best one where none was taught.
    """
    found = [(ball, ball.of(model, taught=True) or ball.of(model, taught=False)) for ball in test.spheres]
    named = [(_ball(ball, words), one.whole.max_mm) for ball, one in found if one is not None]
    missing = dict.fromkeys(why for ball, one in found if one is None for why in ball.withheld)
    skipped = said("sphere.skipped", stops=test.skipped) if test.skipped else ""
    title = words.say("front.sphere.title", robot=robot, model=model_name(model, words))
    return _front(_Tested(title, robot, _SPHERE, named, together(skipped, *missing)), limit, words)


def _ball(ball: Sphere, words: Catalogue) -> str:
    return words.say("front.of_ball", placement=ball.placement, base_point=ball.base_point)


def _front(tested: _Tested, limit: Limit, words: Catalogue) -> Front:
    decision = _decided(tested, limit)
    key, good = _verdict(tested, decision)
    name, worst = max(tested.named, key=lambda one: abs(one[1].value), default=("", None))
    return Front(
        title=tested.title,
        look=graded(good),
        word=words.say(key),
        sentence=words.spoken(_sentence(tested, decision, name, worst)),
        robot=tested.robot,
        figure=None if worst is None else _figure(tested, name, worst, words),
        picture=figure_bars(tested.named, limit.limit_mm, words) if tested.named else None,
        caption=words.say(tested.of.bars) if tested.named else "",
        rule=words.say("front.set_limit") if decision is None else applied_rule(decision, words),
    )


def _decided(tested: _Tested, limit: Limit) -> Decision | None:
    if limit.limit_mm is None or not tested.named:
        return None
    return decide_figures([figure for _, figure in tested.named], limit.limit_mm, limit.rule)


def _verdict(tested: _Tested, decision: Decision | None) -> tuple[str, bool | None]:
    """Return the word and whether it is good; what was not measured cannot pass."""
    if not tested.named:
        return "front.nothing", None
    if decision is None:
        return "front.no_limit_set", None
    key, good = DECIDED[decision.verdict]
    return DECIDED["cannot be decided"] if good and tested.lacks else (key, good)


def _sentence(tested: _Tested, decision: Decision | None, name: str, worst: Figure | None) -> Text:
    if worst is None:
        return tested.lacks
    size = rounded(abs(worst.value), worst.standard_uncertainty, "mm")
    largest = said(tested.of.largest, value=size, u=uncertainty_mm(worst.standard_uncertainty), where=name)
    return together(largest, "" if decision is None else _judged(decision), tested.lacks)


def _judged(decision: Decision) -> Text:
    return said("front.guard", guard=uncertainty_mm(decision.guard_mm)) if decision.guard_mm else ""


def _figure(tested: _Tested, name: str, worst: Figure, words: Catalogue) -> OneFigure:
    expanded = 2.0 * worst.standard_uncertainty
    value = rounded(abs(worst.value), expanded, "mm")
    return OneFigure(
        words.say(tested.of.name),
        words.units.quantity(value, "mm"),
        words.say("front.at_with", where=name, u=uncertainty_mm(expanded)),
    )
