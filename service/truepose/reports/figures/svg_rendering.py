"""Matplotlib figures as inline SVG without a file, a script or a colour of their own, or for a program.

Matplotlib knows no CSS variable: figures of pages are drawn in stand-in colours that nothing else uses, and
the stand-ins are replaced by the page's variables in the finished SVG. Plain figures have ordinary colours.

Matplotlib writes an element for each dot and each arrow; a cloud of a thousand is a thousand elements that a
page holds and a printer walks through. One path of a thousand pieces looks the same: shapes are joined.
"""

import io
import re
import threading
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import cache, partial
from itertools import groupby
from textwrap import shorten, wrap
from typing import Any, Final, TypeAlias

import matplotlib as mpl
from markupsafe import Markup
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_svg import FigureCanvasSVG
from matplotlib.figure import Figure
from matplotlib.font_manager import fontManager
from matplotlib.ticker import FuncFormatter, Locator, LogLocator, MaxNLocator, NullLocator

from truepose.messages.catalogue import Catalogue
from truepose.messages.units import Conversion

_Said: TypeAlias = dict[str, str]  # attributes by name
_SHAPE: Final = re.compile(r"<(path|use) ([^<]*?)/>")
_RUN: Final = re.compile(r"(?:<(?:path|use) [^<]*?/>\s*){2,}")
_ATTRIBUTE: Final = re.compile(r'([\w:-]+)="([^"]*)"')
_MARKERS: Final = re.compile(r"<path ([^<]*?)/>\s*</defs>")
_PAIR: Final = re.compile(r"(-?[\d.]+(?:e-?\d+)?) (-?[\d.]+(?:e-?\d+)?)")
_CIRCLE: Final = re.compile(r"M 0 ([\d.]+) \nC")  # as matplotlib begins one round 0, 0


def joined_shapes(svg: str) -> str:
    """Return the SVG with neighbours that look the same joined; dots are ends of lines without a length."""
    said = (dict(_ATTRIBUTE.findall(one)) for one in _MARKERS.findall(svg))
    markers = {one["id"]: one for one in said}
    return _RUN.sub(lambda run: "\n".join(_joined(run[0], markers)), svg)


def _joined(run: str, markers: Mapping[str, _Said]) -> Iterator[str]:
    shapes = (_shape(kind, dict(_ATTRIBUTE.findall(said)), markers) for kind, said in _SHAPE.findall(run))
    for look, alike in groupby(shapes, key=lambda shape: shape[0]):
        yield f'<path d="{" ".join(outline for _, outline in alike)}" {look}/>'


def _shape(kind: str, said: _Said, markers: Mapping[str, _Said]) -> tuple[str, str]:
    """Return what a shape looks like, and its outline."""
    if kind == "path":
        outline = " ".join(said.pop("d", "").split())  # one outside the picture has none
        return _written(said), outline
    said = markers[said.pop("xlink:href").removeprefix("#")] | said
    x, y, marker = float(said.pop("x")), float(said.pop("y")), said.pop("d")
    del said["id"]
    circle = _CIRCLE.match(marker)
    if circle is not None and said.get("stroke", said.get("fill")) == said.get("fill"):
        return _written(_dot(said, 2.0 * float(circle[1]))), f"M{x:.2f} {y:.2f}h0"
    return _written(said), _moved(marker, x, y)


def _dot(said: _Said, across: float) -> _Said:
    """Return the look of round ends of a line that are as wide as a dot with its edge."""
    edge = float(said.get("stroke-width", 1.0)) if "stroke" in said else 0.0
    look = {"fill": "none", "stroke": said.get("fill", "#000"), "stroke-linecap": "round"}
    opacity = {"stroke-opacity": said["fill-opacity"]} if "fill-opacity" in said else {}
    return look | {"stroke-width": f"{across + edge:.4g}"} | opacity


def _moved(outline: str, x: float, y: float) -> str:
    def shifted(pair: re.Match[str]) -> str:
        return f"{float(pair[1]) + x:.2f} {float(pair[2]) + y:.2f}"

    return " ".join(_PAIR.sub(shifted, outline).split())


def _written(said: Mapping[str, str]) -> str:
    return " ".join(f'{name}="{value}"' for name, value in said.items())


INK, MUTED, GRID = "#010203", "#020304", "#030405"
BEFORE, AFTER, NOISE = "#040506", "#050607", "#060708"
X, Y, Z = "#070809", "#08090a", "#090a0b"
_VARIABLES = {
    INK: "ink",
    MUTED: "muted",
    GRID: "grid",
    BEFORE: "before",
    AFTER: "after",
    NOISE: "noise",
    X: "axis-x",
    Y: "axis-y",
    Z: "axis-z",
}


@dataclass(frozen=True, slots=True)
class Colours:
    """What a figure is drawn in."""

    ink: str
    muted: str
    grid: str
    before: str
    after: str
    noise: str
    paper: str


PAGE: Final = Colours(INK, MUTED, GRID, BEFORE, AFTER, NOISE, paper="none")
# As `tokens.css` has them on white.
PLAIN: Final = Colours("#16202b", "#434e59", "#dde3e8", "#d9822b", "#1f7a8c", "#6b4fa0", paper="#ffffff")
# Matplotlib's settings belong to the process: a second thread would draw in a style half put back.
_SETTINGS: Final = threading.Lock()
_MARKS: Final = 5  # of an axis in another unit, at most
_MARKS_OF_DECADES: Final = 18
_LONGEST_UNIT = 16  # letters
_NUMBER_ALONE: Final = r"(>[-\N{MINUS SIGN}]?\d+)\.(\d+</text>)"  # what an axis is marked with
_PIXELS_PER_IN: Final = 150  # of a matrix, which is drawn as pixels within the SVG
_EAST_ASIAN: Final = (
    "Noto Sans CJK SC",
    "Noto Sans CJK JP",
    "Noto Sans SC",
    "WenQuanYi Micro Hei",
    "IPAGothic",
)
_STYLE = {
    "svg.fonttype": "none",  # text stays text: readable by machines, and in the font of the page
    "svg.hashsalt": "truepose",  # the same figure gives the same ids
    "font.size": 9.0,
    "axes.grid": True,
    "axes.axisbelow": True,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.titlesize": 9.0,
    "grid.linewidth": 0.6,
    "legend.frameon": False,
}


@cache
def _families() -> list[str]:
    """Return the fonts that text is measured in: the first has no Chinese and no Japanese letters."""
    there = {font.name for font in fontManager.ttflist}
    return ["DejaVu Sans", *(name for name in _EAST_ASIAN if name in there)]


@contextmanager
def page_style() -> Iterator[None]:
    """Draw in the style of the page within this block; one thread at a time."""
    with _style(PAGE):
        yield


@contextmanager
def _style(colours: Colours) -> Iterator[None]:
    settings = _STYLE | {"font.family": _families()} | _coloured(colours)
    with _SETTINGS, mpl.rc_context(settings):  # type: ignore[arg-type]  # its stub wants literal keys
        yield


def _coloured(colours: Colours) -> dict[str, object]:
    return {
        "text.color": colours.ink,
        "axes.edgecolor": colours.muted,
        "axes.labelcolor": colours.ink,
        "axes.facecolor": colours.paper,
        "axes.titlecolor": colours.ink,
        "grid.color": colours.grid,
        "xtick.color": colours.muted,
        "ytick.color": colours.muted,
        "xtick.labelcolor": colours.ink,
        "ytick.labelcolor": colours.ink,
        "figure.facecolor": colours.paper,
    }


class Drawing(Figure):
    """A figure that belongs to no window and no global state; a notebook shows it by itself."""

    def _repr_png_(self) -> bytes:
        buffer = io.BytesIO()
        self.savefig(buffer, format="png")
        return buffer.getvalue()


def new_figure(width_in: float, height_in: float) -> Drawing:
    """Return an empty figure."""
    return Drawing(figsize=(width_in, height_in), layout="constrained")


def to_svg(figure: Figure, prefix: str, description: str, words: Catalogue) -> Markup:
    """Return the figure as an inline `<svg>`; `prefix` keeps its ids apart from other figures'."""
    buffer = io.StringIO()
    _write_svg(figure, buffer)
    text = buffer.getvalue()
    text = text[text.index("<svg") :]
    for colour, variable in _VARIABLES.items():
        text = text.replace(colour, f"var(--{variable})")
    text = re.sub(r"<style.*?</style>", "", text, flags=re.DOTALL)
    # The Content-Security-Policy of the service forbids style attributes (decision 0022).
    text = re.sub(r'style="([^"]*)"', _as_attributes, text)
    text = re.sub(r'(\bid="|href="#|url\(#)', rf"\g<1>{prefix}-", text)
    text = re.sub(r"<metadata>.*?</metadata>", "", text, flags=re.DOTALL)
    text = joined_shapes(text)
    text = re.sub(_NUMBER_ALONE, rf"\g<1>{words.units.decimal}\g<2>", text)
    # Fixed sizes would overflow a phone: the page decides the width, the view box the proportions.
    text = re.sub(r'<svg ([^>]*?)height="[^"]*"', r"<svg \1", text, count=1)
    text = re.sub(r'<svg ([^>]*?)width="[^"]*"', r'<svg \1role="img" stroke-linejoin="round"', text, count=1)
    text = text.replace(">", f' aria-label="{Markup.escape(description)}">', 1)
    return Markup(text)


def on_page(draw: Callable[[Colours], Drawing], prefix: str, description: str, words: Catalogue) -> Markup:
    """Return what is drawn in the colours of the page, as `to_svg` does."""
    with page_style():
        return to_svg(draw(PAGE), prefix, description, words)


def plain(draw: Callable[[Colours], Drawing]) -> Drawing:
    """Return what is drawn in ordinary colours: a figure that a program may change."""
    with _style(PLAIN):
        return draw(PLAIN)


def _write_svg(figure: Figure, buffer: io.StringIO) -> None:
    # `savefig` draws all of it twice. Only axes in space need that: their titles have no room the first time.
    figure.set_dpi(_PIXELS_PER_IN)
    in_space = any(axes.name == "3d" for axes in figure.axes)
    canvas: Any = FigureCanvasSVG(figure)  # its stub has no types
    write = partial(canvas.print_figure, format="svg") if in_space else canvas.print_svg
    with warnings.catch_warnings():
        # The text is drawn with the reader's fonts; the one here is for measuring it, and knows no Chinese.
        warnings.filterwarnings("ignore", message="Glyph .* missing from font", category=UserWarning)
        write(buffer, metadata={"Date": None, "Creator": None})


def _as_attributes(style: re.Match[str]) -> str:
    """Return what a style attribute says as attributes: the service's pages allow no style within them."""
    said = dict(declaration.split(":", 1) for declaration in style[1].split(";") if ":" in declaration)
    told = {name.strip(): value.strip() for name, value in said.items()}
    told.pop("font-family", None)  # the font is the page's
    short = re.search(r"[\d.]+px", told.pop("font", ""))
    if short is not None:
        told["font-size"] = short[0]
    return " ".join(f'{name}="{value}"' for name, value in told.items())


def label(text: str, most: int, unit: str = "") -> str:
    """Return text of others as a label of two lines at most, never a formula; the unit is kept."""
    unit = shorten(unit, _LONGEST_UNIT, placeholder="...")
    lines = wrap(shorten(text, 2 * most - _LONGEST_UNIT, placeholder=" ..."), most)
    if unit:
        room = bool(lines) and len(lines[-1]) + len(unit) + 3 <= most
        lines[-1:] = [f"{lines[-1]} [{unit}]"] if room else [*lines[-1:], f"[{unit}]"]
    return "\n".join(lines).replace("$", r"\$")


def mark_axis(axis: Axis, conversion: Conversion) -> None:
    """Mark an axis of kept values, once its scale is set, at round numbers of the shown unit."""
    if conversion.factor == 1.0:
        return
    inner: Locator = (
        LogLocator(subs=(1.0, 2.0, 5.0), numticks=_MARKS_OF_DECADES)
        if axis.get_scale() == "log"
        else MaxNLocator(_MARKS)
    )
    axis.set_major_locator(_Shown(inner, conversion))
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{conversion.of(value):.4g}"))


def name_axes(axes: Axes, words: Catalogue, across: str, up: str) -> None:
    """Name the axes of a view in space, with their unit."""
    conversion = words.units.conversion("mm")
    axes.set_xlabel(f"{across} [{conversion.symbol}]")
    axes.set_ylabel(f"{up} [{conversion.symbol}]")
    mark_axis(axes.xaxis, conversion)
    mark_axis(axes.yaxis, conversion)


class _Shown(Locator):
    """Marks where another locator has them in the shown unit."""

    def __init__(self, inner: Locator, conversion: Conversion) -> None:
        self._inner, self._conversion = inner, conversion

    def __call__(self) -> list[float]:
        low, high = (0.0, 1.0) if self.axis is None else self.axis.get_view_interval()
        return self.tick_values(low, high)

    def tick_values(self, vmin: float, vmax: float) -> list[float]:
        shown = self._conversion
        marks = self._inner.tick_values(shown.of(vmin), shown.of(vmax))
        return [(float(mark) - shown.offset) / shown.factor for mark in marks]


def no_spines(axes: Axes) -> None:
    """Take the frame away; for pictures that need no scale."""
    for spine in axes.spines.values():
        spine.set_visible(False)
