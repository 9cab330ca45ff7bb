"""A test of ISO 9283: its figures, its drift, its conditions, and what it does not prove."""

from collections.abc import Iterable, Iterator
from typing import Final

from rich.console import Group
from rich.text import Text

from truepose.exchange.models.document import file_factor, file_unit
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.messages.message import Message, message
from truepose.reports.rounding import format_fixed, format_rounded, millimetres, uncertainty
from truepose.reports.tables import Remarked, Table, heads_of, on_terminal
from truepose.reports.traceability import NOT_STATED, ReportConditions, condition_rows
from truepose.validation.cautions import pose_test_caution
from truepose.validation.iso9283.performance import POSES
from truepose.validation.iso9283.pose_test import CommandedBy, PoseTest
from truepose.validation.iso9283.visits import Characteristic, CommandedPose, Component, Symbol, cube_of

_MEANINGS = {
    "AP": "pose_test.AP",
    "RP": "pose_test.RP",
    "vAP": "pose_test.vAP",
    "AD": "pose_test.AD",
    "RD": "pose_test.RD",
    "dAP": "pose_test.dAP",
    "dRP": "pose_test.dRP",
}
_WORST: Final[tuple[tuple[Symbol, Component, str], ...]] = (
    ("AP", "p", "pose_test.card.AP"),
    ("RP", "l", "pose_test.card.RP"),
    ("AD", "p", "pose_test.card.AD"),
    ("vAP", "p", "pose_test.card.vAP"),
    ("dAP", "p", "pose_test.card.dAP"),
)
_ROBOT: Final = "robot controller"
_MODELS: dict[CommandedBy, str] = {"nominal": "model.nominal", "identified": "model.identified"}


_HEADS: Final = (
    "pose_test.figure",
    "pose_test.clause",
    "pose_test.pose",
    "pose_test.commanded_by",
    "report.value",
    "u",
    "report.unit",
    "report.noise_alone",
    "pose_test.visits",
)


def pose_test_context(test: PoseTest, words: Catalogue) -> dict[str, object]:
    """Return what the template `pose_test.html` fills in."""
    from truepose.reports.figures.bands import drift_figure  # the drawing library is slow to import

    return {
        "pose_figures": pose_test_table(test, words, whole=True),
        "pose_components": pose_test_table(test, words, whole=False),
        "pose_cards": tuple(pose_test_cards(test, words)),
        "drift": None if test.drift is None else drift_figure(test.drift, words),
        "drift_sentences": tuple(map(words.spoken, drift_sentences(test))),
        "withheld": tuple(withheld_sentences(test, words)),
        "caution": words.spoken(pose_test_caution(test)),
    }


def pose_test_table(test: PoseTest, words: Catalogue = IN_ENGLISH, *, whole: bool | None = None) -> Table:
    """Return the figures, their components, or both; those of one symbol and commanding model together."""
    chosen = [one for one in test.figures() if whole in {None, one[1].component in {"p", "l"}}]
    chosen.sort(key=lambda one: _order(*one))
    rows = [_row(figure, commanded_by, words) for commanded_by, figure in chosen]
    return Table(heads_of(words, *_HEADS), rows, names=4)


def _order(commanded_by: CommandedBy | None, figure: Characteristic) -> tuple[int, bool]:
    return list(_MEANINGS).index(figure.symbol), commanded_by == "identified"


def _row(figure: Characteristic, commanded_by: CommandedBy | None, words: Catalogue) -> tuple[str, ...]:
    factor, unit = file_factor(figure.unit), file_unit(figure.unit)
    value, u = figure.value * factor, figure.standard_uncertainty * factor
    half_width = figure.symbol == "RD" or (figure.symbol == "RP" and figure.component != "l")
    return (
        Remarked(f"{figure.symbol} {figure.component}", words.say(_MEANINGS[figure.symbol])),
        figure.clause,
        figure.subject,
        words.say(_MODELS[commanded_by]) if commanded_by else "",
        f"{'±' if half_width else ''}{words.units.number(format_rounded(value, u), unit)}",
        uncertainty(u, unit),
        words.units.conversion(unit).symbol,
        format_rounded(figure.noise * factor, u, unit) if figure.noise else "",  # the scatter averages out
        str(figure.visits),
    )


def pose_test_cards(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Iterator[tuple[str, str, str]]:
    """Yield name, value and remark of the worst figures, and of what they do not prove beside them."""
    for symbol, component, name in _WORST:
        worst = test.identified.largest(symbol, component)
        if worst is not None:
            u = uncertainty(worst.standard_uncertainty, file_unit(worst.unit))
            value = format_rounded(abs(worst.value), worst.standard_uncertainty)
            yield (
                words.say(name),
                words.units.quantity(value, file_unit(worst.unit)),
                _remark(worst, u, words),
            )
    yield _beside(test, words)


def _remark(worst: Characteristic, u: str, words: Catalogue) -> str:
    if worst.symbol in {"RP", "vAP"}:  # of the attained poses alone
        return words.say("pose_test.card.remark", subject=worst.subject, u=u)
    return words.say("pose_test.card.remark.model", subject=worst.subject, u=u)


def _beside(test: PoseTest, words: Catalogue) -> tuple[str, str, str]:
    # Five poses prove little of a work space: the larger figure stands beside them (decision 0041).
    if test.work_space is None:
        claimed = words.units.quantity(millimetres(test.claimed_mm), "mm")
        return words.say("pose_test.card.claimed"), claimed, words.say("pose_test.card.claimed.remark")
    seen = test.work_space.identified
    remark = words.say("pose_test.card.space.remark", n=seen.n, mean=millimetres(seen.mean_mm))
    return words.say("pose_test.card.space"), words.units.quantity(millimetres(seen.max_mm), "mm"), remark


def _place(pose: CommandedPose, words: Catalogue) -> str:
    return f"{pose.name} ({_at(pose.position_mm, words)})"


def _at(place_mm: Iterable[float], words: Catalogue) -> str:
    return " ".join(words.units.number(format_fixed(float(x), 0, "mm"), "mm") for x in place_mm)


def withheld_sentences(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Iterator[str]:
    """Yield what the visits do not give, and why."""
    for one in test.identified.withheld:
        yield words.say("pose_test.withheld.one", symbol=one.symbol, subject=one.subject, reason=one.reason)


def drift_sentences(test: PoseTest) -> Iterator[Message]:
    """Yield how far the barycentre went, and whether the robot was warm at the end."""
    if test.drift is None or not test.drift.curve:
        return
    far = max(test.drift.curve, key=lambda point: point.moved_mm)
    way, u = format_rounded(far.moved_mm, far.moved_uncertainty_mm), uncertainty(far.moved_uncertainty_mm)
    yield message("pose_test.drift.far", far=way, u=u, hours=far.hours)
    yield message("pose_test.drift.settled" if test.drift.settled else "pose_test.drift.unsettled")


def _cycles(test: PoseTest) -> Message:
    if test.drift is not None:
        visits = sum(point.visits for point in test.drift.curve)
        return message("pose_test.cycles.drift", groups=len(test.drift.curve), visits=visits)
    return message("pose_test.cycles.value", poses=test.poses, cycles=test.cycles)


def _cube(test: PoseTest, words: Catalogue) -> Iterator[tuple[str, str]]:
    if test.poses != POSES:
        return
    cube = cube_of(test.commanded)
    centre = "" if cube is None else _at(cube.centre_mm, words)
    yield (
        words.say("pose_test.cube"),
        words.say("pose_test.cube.none")
        if cube is None
        else words.say("pose_test.cube.value", edge=format_fixed(cube.edge_mm, 0, "mm"), centre=centre),
    )


def stated_conditions(
    test: PoseTest | None, conditions: ReportConditions, words: Catalogue = IN_ENGLISH
) -> tuple[tuple[str, str], ...]:
    """Return the conditions of a test, else of any readings; "not stated" where nobody said."""
    if test is None:
        return tuple(condition_rows(conditions, words))
    say = words.say
    measuring = [device for device in conditions.instruments if device.role != _ROBOT]
    instruments = words.listed([device.model or device.role for device in measuring], "commas")
    return (
        (say("pose_test.standard"), "ISO 9283:1998"),
        (say("pose_test.cycles"), words.spoken(_cycles(test))),
        *_cube(test, words),
        (
            say("pose_test.commanded"),
            words.listed([_place(pose, words) for pose in test.commanded], "commas"),
        ),
        (say("pose_test.point"), say("pose_test.point.value", nest=test.nest)),
        (say("pose_test.instrument"), instruments or say(NOT_STATED)),
        *condition_rows(conditions, words),
    )


def pose_test_summary(test: PoseTest, words: Catalogue = IN_ENGLISH) -> Group:
    """Return the figures without their components, what is withheld, and what they do not prove."""
    figures = pose_test_table(test, words, whole=True).of_columns(*range(len(_HEADS) - 1))
    withheld = (words.say("pose_test.withheld.line", sentence=one) for one in withheld_sentences(test, words))
    told = (*withheld, *map(words.spoken, drift_sentences(test)), words.spoken(pose_test_caution(test)))
    return Group(on_terminal(figures, "ISO 9283:1998"), *map(Text, told))
