"""What the effects of a model do to the ports of its chain, row by row."""

from collections import defaultdict
from collections.abc import Callable, Iterable, Sequence
from functools import cached_property
from typing import TypeAlias

import numpy as np

from truepose.domain.arrays import FloatArray
from truepose.effects.ports import Port, PortKind, Rows, Term, Trait
from truepose.effects.registry import effect_named, effects_with, summed_effects
from truepose.identification.model.parameters.structure import Structure

Moved: TypeAlias = dict[Port, FloatArray | float]
Told: TypeAlias = Callable[[], tuple[Term, ...]]


class Acting:
    """The effects at the rows of one evaluation; those that no load changes are asked once."""

    def __init__(self, structure: Structure, values: FloatArray, rows: Rows) -> None:
        self.structure, self.values = structure, values
        self._rows = rows

    def under_load(self, rows: Rows) -> tuple[Told, Moved]:
        """Return terms and moved ports, gearboxes loaded by what effects add to the torque too."""
        told, moved = self._at(rows)
        loads = [load for port, load in moved.items() if port.kind is PortKind.TORQUE]
        if rows.torque_n_mm is None or not any(np.any(load) for load in loads):
            return told, moved
        return self._at(rows._replace(torque_n_mm=with_added_loads(rows.torque_n_mm, moved)))

    def _at(self, rows: Rows) -> tuple[Told, Moved]:
        following = [name for name in self.structure.effects if name not in effects_with(Trait.STEADY)]
        steady, already = self._steady
        told, moved = self._asked(following, rows, already)
        return lambda: (*steady(), *told()), moved

    @cached_property
    def _steady(self) -> tuple[Told, Moved]:
        steady = [name for name in self.structure.effects if name in effects_with(Trait.STEADY)]
        return self._asked(steady, self._rows, {})

    def _asked(self, effects: Sequence[str], rows: Rows, already: Moved) -> tuple[Told, Moved]:
        """Return what effects move; those that add up themselves tell their terms only if somebody asks."""
        summed = [name for name in effects if name in summed_effects()]
        terms = self._collected([name for name in effects if name not in summed], rows)
        moved = _moved(terms, self.values, already)
        for name in summed:
            values = self.values[list(self.structure.indices_of(name))]
            for port, shift in (
                summed_effects()[name].sums(self.structure.names_of(name), values, rows).items()
            ):
                moved[port] = moved.get(port, 0.0) + shift
        return lambda: (*terms, *self._collected(summed, rows)), moved

    def _collected(self, effects: Sequence[str], rows: Rows) -> tuple[Term, ...]:
        """Ask effects how their parameters act; parameter indices are those of the structure."""
        terms: list[Term] = []
        for effect in effects:
            indices = self.structure.indices_of(effect)
            terms += [
                Term(indices[term.parameter], term.port, term.weight)
                for term in effect_named(effect).terms(self.structure.names_of(effect), rows)
            ]
        return tuple(terms)


def _moved(terms: Iterable[Term], values: FloatArray, already: Moved) -> Moved:
    moved: defaultdict[Port, FloatArray | float] = defaultdict(float, already)
    for term in terms:
        moved[term.port] = moved[term.port] + term.weight * float(values[term.parameter])
    return dict(moved)


def with_added_loads(torque: FloatArray, moved: Moved) -> FloatArray:
    """Return torques (n, J) with the loads on ports added [N mm]."""
    loaded = torque.copy()
    for port, load in moved.items():
        if port.kind is PortKind.TORQUE:
            loaded[:, port.number] += load
    return loaded
