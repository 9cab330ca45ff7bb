"""The map of a diagnosis: at which places something was found or described, over which variables."""

import re
from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass

from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch, Rectangle

from truepose.domain.diagnosis import Diagnosis, EffectSize, Finding
from truepose.effects.signatures import place_of
from truepose.messages.catalogue import IN_ENGLISH, Catalogue
from truepose.reports.figures.svg_rendering import (
    AFTER,
    GRID,
    INK,
    MUTED,
    label,
    new_figure,
    no_spines,
    page_style,
    to_svg,
)

Place = tuple[str, str]  # where, over what

# From the instrument along the arm to the tool; then from the arm's own variables to those around it.
_PLACES = ("tracker", "ballbar", "placement", "base", "joint", "link", "flange", "tool", "nest")
_VARIABLES = (
    "angle",
    "torque",
    "load",
    "direction",
    "last move",
    "place",
    "azimuth",
    "elevation",
    "range",
    "time",
    "temperature",
    "mounting",
    "constant",
)


@dataclass(frozen=True, slots=True)
class MapEntry:
    """A place and a variable, and what is told there."""

    where: str
    over: str
    share: float  # of the sum of squares of all that is told; 0 where only a rival of a finding would act
    findings: tuple[int, ...]  # their numbers on the page
    rival_of: tuple[int, ...]

    @property
    def place(self) -> Place:
        """Its row and its column."""
        return self.where, self.over


@dataclass(frozen=True, slots=True)
class CauseMap:
    """Places as rows, variables as columns, and the cells where something is."""

    rows: tuple[str, ...]
    columns: tuple[str, ...]
    cells: tuple[MapEntry, ...]  # row by row
    links: tuple[tuple[Place, Place], ...]  # a finding and where its rival would act


def cause_map(diagnosis: Diagnosis) -> CauseMap | None:
    """Return the map; None where there are fewer than two cells to compare."""
    told = dict(_told(diagnosis))
    links = tuple(dict.fromkeys(_links(diagnosis)))
    places = dict.fromkeys((*told, *(rival for _, rival in links)))
    if len(places) < 2:
        return None
    numbers = _numbers(diagnosis)
    total = sum(told.values()) or 1.0
    cells = tuple(
        MapEntry(
            *place,
            share=told.get(place, 0.0) / total,
            findings=numbers.get(place, ()),
            rival_of=tuple(sorted({n for own, rival in links if rival == place for n in numbers[own]})),
        )
        for place in sorted(
            places, key=lambda place: (_order(place[0], _PLACES), _order(place[1], _VARIABLES))
        )
    )
    columns = sorted({cell.over for cell in cells}, key=lambda over: _order(over, _VARIABLES))
    return CauseMap(tuple(dict.fromkeys(cell.where for cell in cells)), tuple(columns), cells, links)


def _told(diagnosis: Diagnosis) -> Iterator[tuple[Place, float]]:
    """Yield every place with the mean square of what is told there [mm2]."""
    squares: defaultdict[Place, float] = defaultdict(float)
    for finding in _placed(diagnosis):
        squares[finding.where, finding.over] += _square(finding.worth)
    for entry in diagnosis.remaining.described:
        squares[entry.where, entry.over] += _square(entry.worth)
    yield from squares.items()


def _square(worth: EffectSize | None) -> float:
    if worth is None:
        return 0.0
    return (worth.mean_mm if worth.own_mm is None else worth.own_mm) ** 2


def _placed(diagnosis: Diagnosis) -> list[Finding]:
    """Return the findings that move the tool and say where they act."""
    return [finding for finding in diagnosis.all_findings if finding.where and finding.worth is not None]


def _numbers(diagnosis: Diagnosis) -> dict[Place, tuple[int, ...]]:
    placed = _placed(diagnosis)
    numbers: dict[Place, tuple[int, ...]] = {}
    for number, finding in enumerate(diagnosis.all_findings, 1):
        if finding in placed:
            place = finding.where, finding.over
            numbers[place] = (*numbers.get(place, ()), number)
    return numbers


def _links(diagnosis: Diagnosis) -> Iterator[tuple[Place, Place]]:
    """Yield where the rivals of findings would act instead; those of small ones would hide the others."""
    placed = _placed(diagnosis)
    for finding in diagnosis.findings:
        own = finding.where, finding.over
        rivals = map(place_of, finding.confusable_with) if finding in placed else ()
        yield from ((own, rival) for rival in rivals if rival is not None and rival != own)


def _order(name: str, known: tuple[str, ...]) -> tuple[int, list[int], str]:
    """Return a key that puts names in the order of the trade, joint 10 after joint 9."""
    rank = next((k for k, start in enumerate(known) if name.startswith(start)), len(known))
    return rank, [int(number) for number in re.findall(r"\d+", name)], name


_WIDTH_IN, _ROW_IN = 8.0, 0.42
_LABELS_IN = 1.5  # below the columns, and the legend
_FEWEST_COLUMNS = 5  # the room of; cells of fewer would be as wide as the page
_LEVEL_COLUMNS = 6  # whose names stand side by side
_SLANTED_COLUMNS = 8  # of more, slanted labels would lie on one another
_WIDEST_LABEL = 18  # letters
_HALF = (0.46, 0.42)  # of a cell, beside the lines of the grid
_DARKEST = 0.6  # opacity of a share of 1; the text on it stays readable
_FAINTEST = 0.06


def map_picture(found: CauseMap, words: Catalogue = IN_ENGLISH) -> Markup:
    """Draw the map; shares and numbers stand in the cells, so that nothing rests on a shade."""
    with page_style():
        figure = new_figure(_WIDTH_IN, _LABELS_IN + _ROW_IN * len(found.rows))
        axes = figure.add_subplot()
        _grid(axes, found, words)
        for link in found.links:
            _picture_of_link(axes, found, link)
        for cell in found.cells:
            _picture_of_cell(axes, found, cell)
        figure.legend(handles=_legend(found, words), loc="outside upper left", ncols=4)
        return to_svg(figure, "map", words.say("map"), words)


def _grid(axes: Axes, found: CauseMap, words: Catalogue) -> None:
    columns, rows = len(found.columns), len(found.rows)
    axes.set_xlim(-0.5, max(columns, _FEWEST_COLUMNS) - 0.5)
    axes.set_ylim(rows - 0.5, -0.5)
    names = [label(words.name(name), _WIDEST_LABEL) for name in found.columns]
    if columns > _SLANTED_COLUMNS:
        axes.set_xticks(range(columns), names, ha="right", va="center", rotation=90, rotation_mode="anchor")
    elif columns > _LEVEL_COLUMNS:
        axes.set_xticks(range(columns), names, rotation=40, ha="right", rotation_mode="anchor")
    else:
        axes.set_xticks(range(columns), names)
    axes.set_yticks(range(rows), [label(words.name(name), _WIDEST_LABEL) for name in found.rows])
    axes.tick_params(length=0)
    axes.grid(visible=False)
    axes.hlines([k + 0.5 for k in range(rows - 1)], -0.5, columns - 0.5, color=GRID, linewidth=0.6)
    axes.vlines([k + 0.5 for k in range(columns - 1)], -0.5, rows - 0.5, color=GRID, linewidth=0.6)
    no_spines(axes)


def _at(found: CauseMap, place: Place) -> tuple[int, int]:
    return found.columns.index(place[1]), found.rows.index(place[0])


def _picture_of_link(axes: Axes, found: CauseMap, link: tuple[Place, Place]) -> None:
    """Join two cells from edge to edge."""
    (x, y), (to_x, to_y) = (_at(found, place) for place in link)
    across, down = to_x - x, to_y - y
    inside = min(half / abs(way) for half, way in zip(_HALF, (across, down), strict=True) if way)
    ends = inside, 1.0 - inside
    axes.plot(
        [x + across * end for end in ends],
        [y + down * end for end in ends],
        color=MUTED,
        linewidth=0.9,
        linestyle=":",
        zorder=1.5,
    )


def _picture_of_cell(axes: Axes, found: CauseMap, cell: MapEntry) -> None:
    x, y = _at(found, cell.place)
    corner, size = (x - _HALF[0], y - _HALF[1]), (2.0 * _HALF[0], 2.0 * _HALF[1])
    if cell.share > 0.0:
        axes.add_patch(Rectangle(corner, *size, color=AFTER, alpha=_opacity(cell.share), linewidth=0.0))
    if cell.findings:
        axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=INK, linewidth=1.6))
    elif cell.rival_of:
        axes.add_patch(Rectangle(corner, *size, fill=False, edgecolor=MUTED, linewidth=1.0, linestyle="--"))
    axes.text(x, y, _text(cell), ha="center", va="center", fontsize=8.0 if len(found.columns) < 10 else 6.5)


def _opacity(share: float) -> float:
    """Return the shade of a share: by its root, as large as the error itself, so that small ones are seen."""
    return float(_FAINTEST + (_DARKEST - _FAINTEST) * share**0.5)


def _text(cell: MapEntry) -> str:
    numbers = f"({', '.join(map(str, cell.findings))})" if cell.findings else ""
    return " ".join(filter(None, (numbers, share_text(cell.share))))


def share_text(share: float) -> str:
    """Return a share in per cent; nothing where there is none."""
    if share == 0.0:
        return ""
    return "< 1 %" if share < 0.01 else f"{100.0 * share:.0f} %"


def _legend(found: CauseMap, words: Catalogue) -> list[Patch | Line2D]:
    handles: list[Patch | Line2D] = []
    if any(cell.findings for cell in found.cells):
        handles.append(Patch(fill=False, edgecolor=INK, linewidth=1.6, label=words.say("map.finding")))
    if any(cell.share > 0.0 and not cell.findings for cell in found.cells):
        handles.append(Patch(color=AFTER, alpha=0.3, linewidth=0.0, label=words.say("map.described")))
    if found.links:
        handles.append(
            Line2D([], [], color=MUTED, linewidth=1.0, linestyle="--", label=words.say("map.rival"))
        )
    return handles
