"""Shapes of an SVG that lie side by side and look the same, as one path each.

Matplotlib writes an element for each dot and each arrow; a cloud of a thousand is a thousand elements that a
page holds and a printer walks through. One path of a thousand pieces looks the same.
"""

import re
from collections.abc import Iterator, Mapping
from itertools import groupby
from typing import Final, TypeAlias

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
