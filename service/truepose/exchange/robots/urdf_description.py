"""A URDF as it is written: XML that knows its lines, links and joints in mm and rad, not yet an arm."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Final, NoReturn, TypeVar
from xml.parsers import expat

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.domain.robot import JointRange
from truepose.exchange.errors import BadValueError, InputFileError, MissingEntryError, UnreadableFileError
from truepose.exchange.quantities import limits_of
from truepose.exchange.tables.table_reader import is_number
from truepose.exchange.xml_text import read_xml
from truepose.kinematics.frames import rotation_x, rotation_y, rotation_z

_DEEPEST: Final = 100  # no description of a robot nests deeper than ten


@dataclass(frozen=True, slots=True)
class Element:
    """An element with its place in the file."""

    file: str
    tag: str
    attributes: dict[str, str]
    line: int
    children: list["Element"] = field(default_factory=list)

    def fail(self, sentence: str, kind: type[InputFileError] = BadValueError) -> NoReturn:
        """Raise `kind` at this place."""
        raise kind(sentence, file=self.file, line=self.line)

    def text(self, name: str) -> str:
        """Return an attribute that must be there."""
        if not self.attributes.get(name, "").strip():
            self.fail(f"<{self.tag}> needs the attribute {name}", MissingEntryError)
        return self.attributes[name]

    def all(self, tag: str) -> Iterator["Element"]:
        """Yield the children of a tag."""
        return (child for child in self.children if child.tag == tag)

    def optional(self, tag: str) -> "Element | None":
        """Return the only child of a tag, None where there is none."""
        found = list(self.all(tag))
        if len(found) > 1:
            found[1].fail(f"<{self.tag}> has a second <{tag}>")
        return found[0] if found else None


def parse_xml(file: str, data: bytes) -> Element:
    """Return the root of an XML document.

    Raises
    ------
    UnreadableFileError
        It is no XML, is cut off, nests without end, or declares a document type.
    """
    tree = _Tree(file)
    read_xml(tree.parser, file, data, "this is not XML")
    return tree.root


class _Tree:
    """What the parser calls while it reads."""

    def __init__(self, file: str) -> None:
        self._file = file
        self._open = [Element(file, "", {}, 1)]
        self.parser = expat.ParserCreate()
        self.parser.StartElementHandler = self._start
        self.parser.EndElementHandler = self._end

    @property
    def root(self) -> Element:
        return self._open[0].children[0]

    def _start(self, tag: str, attributes: dict[str, str]) -> None:
        element = Element(self._file, tag, attributes, self.parser.CurrentLineNumber)
        if len(self._open) > _DEEPEST:
            element.fail("elements are nested too deeply", UnreadableFileError)
        self._open[-1].children.append(element)
        self._open.append(element)

    def _end(self, _tag: str) -> None:
        self._open.pop()


_MM_PER_M: Final = 1000.0
_MOST_ELEMENTS: Final = 4000
_ORIGIN: Final = (0.0, 0.0, 0.0)
_ABOUT_X: Final = (1.0, 0.0, 0.0)  # what the format means where no axis is given
_TURNING: Final = ("revolute", "continuous")
FIXED: Final = "fixed"

T = TypeVar("T", "Link", "Joint")


@dataclass(frozen=True, slots=True)
class Link:
    """A body, and its mass where one is given."""

    name: str
    element: Element
    mass_kg: float = 0.0
    centre_of_gravity_mm: tuple[float, float, float] = (0.0, 0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Joint:
    """What holds a link on another one."""

    name: str
    kind: str
    parent: str
    child: str
    origin: FloatArray  # (4, 4) of the child in the parent while the joint reads zero
    axis: FloatArray  # (3,) unit vector in the child
    limits: JointRange | None
    follows: str | None  # the joint that it mimics
    element: Element

    @property
    def turns(self) -> bool:
        """Whether it is a joint of an arm of revolute joints."""
        return self.kind in _TURNING


@dataclass(frozen=True, slots=True)
class Description:
    """All links and joints of a file."""

    name: str
    links: dict[str, Link]
    joints: tuple[Joint, ...]
    element: Element


def read_description(file: str, data: bytes) -> Description:
    """Read a URDF.

    Raises
    ------
    InputFileError
        With file and line: it is no URDF, names a link that is not there, or a number cannot be meant.
    """
    root = parse_xml(file, data)
    if root.tag != "robot":
        root.fail(f"this is not a URDF: it begins with <{root.tag}>, not <robot>", UnreadableFileError)
    _refuse_xacro(root)
    if len(root.children) > _MOST_ELEMENTS:
        root.fail(f"it has more than {_MOST_ELEMENTS} links and joints, more than any robot")
    links = _named([_link(element) for element in root.all("link")])
    joints = tuple(_named([_joint(element) for element in root.all("joint")]).values())
    for joint in joints:
        _require_links(joint, links)
    return Description(root.text("name"), links, joints, root)


def _refuse_xacro(root: Element) -> None:
    macro = next((child for child in root.children if child.tag.startswith("xacro:")), None)
    if macro is not None:
        macro.fail(
            "this is a xacro file, from which a URDF is made: run `xacro` first and use its output",
            UnreadableFileError,
        )


def _named(found: Sequence[T]) -> dict[str, T]:
    named: dict[str, T] = {}
    for one in found:
        if one.name in named:
            one.element.fail(f"a second {one.element.tag} is called {one.name!r}")
        named[one.name] = one
    return named


def _require_links(joint: Joint, links: dict[str, Link]) -> None:
    for name in (joint.parent, joint.child):
        if name not in links:
            joint.element.fail(f"joint {joint.name!r} names the link {name!r}, which does not exist")


def _link(element: Element) -> Link:
    inertial = element.optional("inertial")
    mass = None if inertial is None else inertial.optional("mass")
    if inertial is None or mass is None:
        return Link(element.text("name"), element)
    kilograms = _numbers(mass, "value", (0.0,))[0]
    _require_plausible(mass, kilograms, "mass_kg")
    if kilograms < 0.0:
        mass.fail(f"a mass of {kilograms:g} kg is not plausible")
    x, y, z = _origin(inertial)[:3, 3].tolist()
    return Link(element.text("name"), element, kilograms, (x, y, z))


def _joint(element: Element) -> Joint:
    follows = element.optional("mimic")
    kind = element.text("type")
    return Joint(
        name=element.text("name"),
        kind=kind,
        parent=_end(element, "parent"),
        child=_end(element, "child"),
        origin=_origin(element),
        axis=_axis(element),
        limits=_limits(element) if kind == "revolute" else None,
        follows=None if follows is None else follows.text("joint"),
        element=element,
    )


def _end(joint: Element, which: str) -> str:
    end = joint.optional(which)
    if end is None:
        joint.fail(f"<joint> needs a <{which}>")
    return end.text("link")


def _origin(element: Element) -> FloatArray:
    """Return the frame that <origin> of an element places, shape (4, 4)."""
    frame, origin = np.eye(4), element.optional("origin")
    if origin is None:
        return frame
    roll, pitch, yaw = _numbers(origin, "rpy", _ORIGIN)
    # Roll, pitch and yaw turn about fixed axes, in this order: the first stands last.
    frame[:3, :3] = rotation_z(yaw) @ rotation_y(pitch) @ rotation_x(roll)
    frame[:3, 3] = _MM_PER_M * np.array(_numbers(origin, "xyz", _ORIGIN))
    for value in frame[:3, 3].tolist():
        _require_plausible(origin, value, "x_mm")
    return frame


def _axis(element: Element) -> FloatArray:
    axis = element.optional("axis")
    direction = np.array(_ABOUT_X if axis is None else _numbers(axis, "xyz", _ABOUT_X))
    length = float(np.linalg.norm(direction))
    if axis is not None and not length > 0.0:
        axis.fail("the axis has no direction")
    return np.asarray(direction / length)


def _limits(element: Element) -> JointRange | None:
    limit = element.optional("limit")
    # By the format an end that is not there is 0. Where one is missing nobody meant a joint that stands
    # still: its limits are unknown.
    if limit is None or not {"lower", "upper"} <= set(limit.attributes):
        return None
    (lower,), (upper,) = _numbers(limit, "lower", (0.0,)), _numbers(limit, "upper", (0.0,))
    if lower >= upper:
        limit.fail(f"the lower limit {lower:g} is not below the upper limit {upper:g}")
    return JointRange(lower, upper)


def _numbers(element: Element, name: str, absent: tuple[float, ...]) -> tuple[float, ...]:
    """Return the numbers of an attribute, as many as stand for an absent one."""
    if name not in element.attributes:
        return absent
    words = element.attributes[name].split()
    numbers = tuple(_number(element, word) for word in words)
    if len(numbers) != len(absent):
        element.fail(f"{len(numbers)} numbers found under {name} where {len(absent)} are required")
    return numbers


def _number(element: Element, word: str) -> float:
    number = float(word) if is_number(word) else math.nan
    if not math.isfinite(number):
        element.fail(f"{word[:40]!r} is not a number")
    _require_plausible(element, number, "")
    return number


def _require_plausible(element: Element, number: float, name: str) -> None:
    """Refuse what cannot be the quantity of a name."""
    limits = limits_of(name)
    if not limits.accepts(number):
        element.fail(limits.fault(number, f"{number:g}"))
