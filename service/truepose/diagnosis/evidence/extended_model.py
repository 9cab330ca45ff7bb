"""The model with everything that the data ask for: the findings, and functions without a name beside them."""

from collections.abc import Iterator
from dataclasses import dataclass, replace

from truepose.diagnosis.evidence.sensitivities import worth_of
from truepose.diagnosis.screening.groups import names_of
from truepose.diagnosis.screening.selection import Selected
from truepose.domain.results.diagnosis import Described
from truepose.effects.causes import Candidate
from truepose.effects.cells import cell_of
from truepose.identification.fit.robust import RobustFit


@dataclass(frozen=True, slots=True)
class Whole:
    """The model with every cell that the data ask for: what is left, described without a name."""

    fit: RobustFit
    cells: tuple[Candidate, ...]

    def beside(self, selected: Selected) -> tuple[Described, ...]:
        """Return what it describes beside the picks, which are told by their findings; largest first."""
        seen = replace(selected, fit=self.fit)
        found = (Described(*place, worth_of(seen, names)) for place, names in self._places(selected))
        return tuple(sorted(found, key=lambda one: -(one.worth.own_mm or 0.0)))

    def _places(self, selected: Selected) -> Iterator[tuple[tuple[str, str], tuple[str, ...]]]:
        picked = set(names_of(selected.picks))
        names: dict[tuple[str, str], tuple[str, ...]] = {}
        for cell in self.cells:
            where, over, _ = cell_of(cell)
            if picked.isdisjoint(cell.names):
                names[where, over] = (*names.get((where, over), ()), *cell.names)
        yield from names.items()
