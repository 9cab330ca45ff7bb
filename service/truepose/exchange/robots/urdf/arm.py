"""The arm in a URDF: from one link to another, in series, all its joints revolute."""

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Final, NoReturn

from truepose.exchange.errors import BadValueError
from truepose.exchange.robots.urdf.description import FIXED, Description, Joint

_TOOL_FRAME: Final = "tool0"  # what the tool frame of a controller is called in ROS-Industrial


@dataclass(frozen=True, slots=True)
class Arm:
    """The joints from a base to a tip, fixed ones among them, in order."""

    base: str
    tip: str
    joints: tuple[Joint, ...]


def arm_of(description: Description, base: str | None = None, tip: str | None = None) -> Arm:
    """Return the serial arm of a description.

    Parameters
    ----------
    description : Description
    base : str, optional
        Link that the arm stands on; by default the one that no joint holds.
    tip : str, optional
        Link at its end; by default `tool0`, else the only link at the end of what the last joint turns, else
        the link of the last joint.

    Raises
    ------
    BadValueError
        Links hang in a circle or on two others, the arm branches, a joint slides or follows another one.
    """
    tree = _Tree(description)
    base = tree.root if base is None else tree.known(base)
    tip = tree.tip(base) if tip is None else tree.known(tip)
    joints = tree.between(base, tip)
    _require_turning(joints, description)
    return Arm(base, tip, joints)


def fixed_to(description: Description, link: str) -> Iterator[tuple[Joint, ...]]:
    """Yield the ways along fixed joints from a link to every link that moves with it, the empty one first."""
    held = _held(description)
    ways: list[tuple[Joint, ...]] = [()]
    while ways:
        way = ways.pop()
        yield way
        end = way[-1].child if way else link
        ways += [(*way, joint) for joint in held[end] if joint.kind == FIXED]


def _held(description: Description) -> Mapping[str, list[Joint]]:
    held: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in description.joints:
        held[joint.parent].append(joint)
    return held


class _Tree:
    """Who holds whom."""

    def __init__(self, description: Description) -> None:
        self._description = description
        self._holder = self._holders()
        self._held = _held(description)
        self.root = self._only_root()
        self._require_one_piece()

    def _holders(self) -> dict[str, Joint]:
        holders: dict[str, Joint] = {}
        for joint in self._description.joints:
            other = holders.setdefault(joint.child, joint)
            if other is not joint:
                joint.element.fail(
                    f"link {joint.child!r} hangs on two joints, {other.name!r} and {joint.name!r}: a loop, "
                    "which no URDF can have"
                )
        return holders

    def _only_root(self) -> str:
        """Return the link that no joint holds."""
        roots = [name for name in self._description.links if name not in self._holder]
        if not roots:
            self._refuse("every link hangs on another one: the joints go round in a circle")
        if len(roots) > 1:
            self._refuse(f"links {roots[0]!r} and {roots[1]!r} hang on nothing: these are two robots")
        return roots[0]

    def _require_one_piece(self) -> None:
        """Refuse joints that go round in a circle beside the arm."""
        found, waiting = {self.root}, [self.root]
        while waiting:
            children = [joint.child for joint in self._held[waiting.pop()]]
            found.update(children)
            waiting += children
        astray = next((name for name in self._description.links if name not in found), None)
        if astray is not None:
            self._refuse(f"link {astray!r} hangs in a circle of joints, not on link {self.root!r}")

    def known(self, name: str) -> str:
        """Return the name of a link that is there."""
        if name not in self._description.links:
            self._refuse(f"there is no link {name!r}; it has {', '.join(self._description.links)}")
        return name

    def between(self, base: str, tip: str) -> tuple[Joint, ...]:
        """Return the joints from a link to one that hangs on it, in order."""
        joints: list[Joint] = []
        link = tip
        while link != base:
            joint = self._holder.get(link)
            if joint is None:
                self._refuse(f"link {tip!r} does not hang on link {base!r}")
            joints.append(joint)
            link = joint.parent
        return tuple(reversed(joints))

    def tip(self, base: str) -> str:
        """Return the end of the only arm on a link."""
        link, following = base, self._moving_on(base)
        while following:
            if len(following) > 1:
                one, other = following[:2]
                other.element.fail(
                    f"the arm branches into joints {one.name!r} and {other.name!r}; name the link at its "
                    f"tip, as in {other.element.file}#{other.child}"
                )
            link = following[0].child
            following = self._moving_on(link)
        ends = [way[-1].child if way else link for way in fixed_to(self._description, link)]
        leaves = [end for end in ends if not self._held[end]]
        if _TOOL_FRAME in ends:
            return _TOOL_FRAME
        return leaves[0] if len(leaves) == 1 else link

    def _moving_on(self, link: str) -> list[Joint]:
        """Return the joints that move against a link and hang on it, directly or behind fixed joints."""
        ends = [way[-1].child if way else link for way in fixed_to(self._description, link)]
        return [joint for end in ends for joint in self._held[end] if joint.kind != FIXED]

    def _refuse(self, sentence: str) -> NoReturn:
        raise BadValueError(sentence, file=self._description.element.file)


def _require_turning(joints: Sequence[Joint], description: Description) -> None:
    for joint in joints:
        if joint.kind != FIXED and not joint.turns:
            joint.element.fail(f"joint {joint.name!r} is {joint.kind}; only arms of revolute joints are read")
        if joint.follows is not None:
            joint.element.fail(
                f"joint {joint.name!r} follows joint {joint.follows!r}; only arms whose joints turn by "
                "themselves are read"
            )
    if not any(joint.turns for joint in joints):
        description.element.fail("there is no joint that turns between base and tip")
