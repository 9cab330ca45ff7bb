"""Two results of one robot: which parameters changed, and by how much the tool goes elsewhere."""

from dataclasses import dataclass
from typing import Final

from markupsafe import Markup

from truepose.exchange.models.document import file_factor, file_unit
from truepose.judgement.two_models import Moved, ParameterChange, TwoModels
from truepose.reports.figures.maps.work_space import exaggeration, views
from truepose.reports.parameters.meanings import meaning
from truepose.reports.wording.rounding import millimetres, p_value, rounded, with_uncertainty
from truepose.words.catalogue import Catalogue

_MOST_ARROWS: Final = 250
_NAMED: Final = 3  # parameters in the sentence; the table has all


@dataclass(frozen=True, slots=True)
class ChangeRow:
    """A parameter in both results, as text."""

    name: str
    meaning: str
    earlier: str
    later: str
    difference: str
    unit: str
    chance: str
    significant: bool


def change_rows(found: TwoModels, words: Catalogue) -> tuple[ChangeRow, ...]:
    """Return a row per common parameter, the least likely by chance first."""
    ordered = sorted(found.changes, key=lambda one: 2.0 if one.p_value is None else one.p_value)
    return tuple(_row(change, words) for change in ordered)


def verdict_sentence(found: TwoModels, words: Catalogue) -> str:
    """Return whether the robot changed, and which of its parameters did, in a sentence."""
    if found.p_value is None:
        return words.say("side.not_comparable")
    changed = [change for change in found.changes if change.significant]
    if changed:
        first = sorted(changed, key=_deviation, reverse=True)[:_NAMED]
        names = words.between.join(change.name for change in first)
        counts = {"number": len(changed), "total": len(found.changes)}
        return words.say("side.changed", **counts, names=names, p=p_value(found.p_value))
    key = "side.together" if found.p_value < 0.05 else "side.unchanged"
    return words.say(key, p=p_value(found.p_value))


def _deviation(change: ParameterChange) -> float:
    return abs(change.difference) / change.standard_uncertainty


def space_sentences(found: TwoModels, words: Catalogue) -> tuple[str, ...]:
    """Return what the change is at the tool, and what the earlier model is worth today."""
    told = []
    if found.moved is not None:
        moved = found.moved
        told.append(words.say("side.moved", mean=millimetres(moved.mean_mm), most=millimetres(moved.max_mm)))
    if found.earlier_now is not None and found.later_now is not None:
        told.append(
            words.say(
                "side.worth",
                earlier=millimetres(found.earlier_now.mean_mm),
                later=millimetres(found.later_now.mean_mm),
                noise=millimetres(found.later_now.noise_mm),
            )
        )
    return tuple(told)


def moved_views(moved: Moved, words: Catalogue) -> tuple[Markup, float]:
    """Return where the tool goes now, as arrows in three views, and how many times longer they are."""
    shown = slice(None, None, -(-len(moved.places_mm) // _MOST_ARROWS))
    times = exaggeration(moved.places_mm, moved.moved_mm)
    return views(moved.places_mm[shown], times * moved.moved_mm[shown], "moved", words), times


def _row(change: ParameterChange, words: Catalogue) -> ChangeRow:
    unit = file_unit(change.unit)
    factor, u = file_factor(change.unit), change.standard_uncertainty * file_factor(change.unit)
    return ChangeRow(
        change.name,
        meaning(change.name, change.effect, words),
        rounded(change.earlier * factor, u, unit),
        rounded(change.later * factor, u, unit),
        with_uncertainty(change.difference * factor, u, unit),
        words.units.conversion(unit).symbol,
        "" if change.p_value is None else p_value(change.p_value),
        change.significant,
    )
