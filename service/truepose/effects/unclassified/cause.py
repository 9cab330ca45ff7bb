"""The cause that stands for every cell without a trade name, and the table of these cells.

A library of names is never complete. Beside the named causes stand plain cells, so that a joint's zero that
jumped is not taken for the base, nor an instrument that was kicked for the robot.
"""

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from truepose.domain.diagnosis import Detail
from truepose.effects.causes import Candidate, Description, FittedCause, Scene, norm_with_uncertainty
from truepose.effects.installed import INSTALLED
from truepose.effects.ports import NOTHING, Need, ParameterSpec, Rows, Setting, Term, Trait
from truepose.effects.unclassified import angle_errors, instrument_angle_errors, load_errors, time_errors
from truepose.effects.unclassified.kinds import Key, Kind, Part, Place, Size, key_of
from truepose.messages.message import Text, message, together

OWN: dict[str, Kind] = {
    kind.name: kind
    for part in (time_errors, angle_errors, load_errors, instrument_angle_errors)
    for kind in part.KINDS
}
# A kind of truepose's own stays its own, as its effects do.
KINDS: dict[str, Kind] = OWN | {name: kind for name, kind in INSTALLED.kinds.items() if name not in OWN}


NAME = "unnamed"
_TOLD_AS = {"rad": "deg", "rad/h": "deg/h", "rad/K": "deg/K"}
_QUANTITY = {"rad": "rotation", "mm": "shift", "mm/N": "shift"}


class Unnamed:
    """Every cell of the table."""

    name = NAME
    traits = frozenset({Trait.SEARCHED})
    signature = None  # the subject of each cell is its signature
    needs: frozenset[Need] = NOTHING  # in general; `needs_of` tells those of single cells

    def specs(self, setting: Setting) -> tuple[ParameterSpec, ...]:
        """Return none: cells are looked for, not assumed."""
        return ()

    def terms(self, names: tuple[str, ...], rows: Rows) -> list[Term]:
        """Move what each cell moves, by the ports and weights of its kind."""
        return [
            Term(parameter, port, weight)
            for parameter, key in enumerate(map(key_of, names))
            for port, weight in KINDS[key.kind].moves(key, rows)
        ]

    def needs_of(self, names: tuple[str, ...]) -> frozenset[Need]:
        """Return what a row must tell so that the cells of these parameters can be predicted there.

        Parameters
        ----------
        names : tuple of str
        """
        return NOTHING.union(*(KINDS[key_of(name).kind].needs for name in names))

    def goes_on(self, names: tuple[str, ...]) -> bool:
        """Return whether one of the cells moves things ever further in time."""
        # By the shape that a kind states, so that a kind that a package brings is held as ours are.
        return any(KINDS[key_of(name).kind].shape == "drift" for name in names)

    def unseen(self, scene: Scene) -> Text | None:
        """There is always something to look at."""
        return None

    def candidates(self, scene: Scene) -> tuple[Candidate, ...]:
        """Propose every cell that these data can show."""
        return tuple(
            candidate
            for kind in KINDS.values()
            for place in kind.places(scene)
            for candidate in _of_place(kind, place, scene)
            # The first name stands for all: a cell's parts are added to a model together or not at all.
            if candidate.names[0] not in scene.present
        )

    def describe(self, subject: str, fitted: FittedCause, scene: Scene) -> Description:
        """Describe a cell; of several variants, the largest, with all of them in the details."""
        cells = _cells(fitted)
        largest = max(cells, key=lambda cell: abs(cell.sizes[0].amplitude))
        kind, first = KINDS[largest.key.kind], largest.sizes[0]
        beside = largest.sizes[1].amplitude if len(largest.sizes) > 1 else 0.0
        several = message("causes.unnamed.several", cells=len(cells), shape=kind.shape)
        more = several if len(cells) > 1 else ""
        sentence = kind.sentence(largest.key, Size(abs(first.amplitude), beside), scene)
        details = tuple(detail for cell in cells for detail in cell.details(scene, several=len(cells) > 1))
        size = first.amplitude, first.unit, first.uncertainty
        return Description(subject, *size, together(sentence, more), details, kind.limits)


class _Amplitude(NamedTuple):
    """Length of the parts of one unit, in the unit of documents; of a single part, with its sign."""

    amplitude: float
    uncertainty: float
    unit: str
    name: str


class _Cell(NamedTuple):
    """One variant of a cell as it was fitted."""

    key: Key
    sizes: tuple[_Amplitude, ...]

    def details(self, scene: Scene, *, several: bool) -> Iterator[Detail]:
        """Say which variant it is; its size where it is one of several; what it does beside."""
        kind = KINDS[self.key.kind]
        if kind.variant_is is not None:
            name, unit = kind.variant_is
            variant = float(self.key.variant)
            yield Detail(name, variant, unit, kind.variant_known_to(variant, scene))
        if several:
            yield Detail("amplitude", self.sizes[0].amplitude, self.sizes[0].unit, self.sizes[0].uncertainty)
        for size in self.sizes[1:]:
            yield Detail(size.name, size.amplitude, size.unit, size.uncertainty)


def _of_place(kind: Kind, place: Place, scene: Scene) -> Iterator[Candidate]:
    for label, number in kind.variants(scene):
        specs = tuple(_spec(Key(kind.name, place, label, part.name), part) for part in kind.parts)
        yield Candidate(NAME, kind.subject(place), specs, number)


def _spec(key: Key, part: Part) -> ParameterSpec:
    return ParameterSpec(key.name, part.unit, 0.0, part.width)


def _cells(fitted: FittedCause) -> list[_Cell]:
    """Return the variants of a cell that were fitted, by their number: moments in the order of time."""
    variants: dict[str, list[int]] = {}
    keys = [key_of(name) for name in fitted.names]
    for index, key in enumerate(keys):
        variants.setdefault(key.variant, []).append(index)
    ordered = sorted(variants.items(), key=lambda item: _number(item[0]))
    return [_Cell(keys[here[0]], _sizes(fitted, here, keys)) for _, here in ordered]


def _number(variant: str) -> float:
    try:
        return float(variant)
    # Some variants are words, such as the axes of a mount: they keep the order in which they were added.
    except ValueError:
        return 0.0


def _sizes(fitted: FittedCause, here: list[int], keys: list[Key]) -> tuple[_Amplitude, ...]:
    units = {part.name: part.unit for part in KINDS[keys[here[0]].kind].parts}
    of_unit: dict[str, list[int]] = {}
    for index in here:
        of_unit.setdefault(units[keys[index].part], []).append(index)
    return tuple(_amplitude(fitted, rows, unit) for unit, rows in of_unit.items())


def _amplitude(fitted: FittedCause, rows: list[int], unit: str) -> _Amplitude:
    """Return the size of parameters of one unit: of one its value, of several their length less noise."""
    values, covariance = fitted.values[rows], fitted.covariance[np.ix_(rows, rows)]
    if len(rows) == 1:
        length, spread = float(values[0]), float(np.sqrt(covariance[0, 0]))
    else:
        length, spread = norm_with_uncertainty(values, covariance)
    factor = float(np.rad2deg(1.0)) if unit in _TOLD_AS else 1.0
    return _Amplitude(factor * length, factor * spread, _TOLD_AS.get(unit, unit), _QUANTITY.get(unit, ""))
