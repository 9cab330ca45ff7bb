"""Actions: what to do so that one cause leaves readings that another cannot, where no configuration would.

One table, tried from the top: an action serves a pair of causes by the words of their cells, their places,
variables and shapes.
"""

from dataclasses import dataclass
from typing import Final

from truepose.domain.results.causes import Cause
from truepose.domain.sentences import Sentence, said
from truepose.effects.cells import named_cell, words_of


@dataclass(frozen=True, slots=True)
class Action:
    """Something to do."""

    one: frozenset[str]  # words of which one of the two causes has some
    do: Sentence  # an imperative
    each: str = ""  # a word that both have; "": none is needed
    again: bool = False  # the first configurations are measured once more

    def serves(self, one: frozenset[str], other: frozenset[str]) -> bool:
        """Return whether it tells two causes of these words apart."""
        return bool(self.one & (one | other)) and (not self.each or self.each in one & other)


BOTH_SIDES: Final = said("do.both_sides")
REMOUNT: Final = said("do.remount")
ALL_NESTS: Final = said("do.all_nests")
AT_THE_END: Final = said("do.at_the_end")
IN_ANOTHER_ORDER: Final = said("do.in_another_order")
WARM_AND_COLD: Final = said("do.warm_and_cold")

_ACTIONS: Final = (
    Action(frozenset({"tool"}), said("do.with_and_without_load"), each="load"),
    Action(
        frozenset({"placement"}),
        said("do.first_poses_again"),
    ),
    Action(
        frozenset({"ballbar constant"}),
        said("do.initialise"),
    ),
    Action(
        frozenset({"tracker time"}),
        said("do.fixed_nests"),
    ),
    Action(frozenset({"mounting"}), REMOUNT, again=True),
    Action(frozenset({"nest constant"}), ALL_NESTS),
    Action(frozenset({"direction", "sign"}), BOTH_SIDES),
    Action(frozenset({"last move"}), IN_ANOTHER_ORDER),
    Action(frozenset({"temperature"}), WARM_AND_COLD, again=True),
    Action(frozenset({"time"}), AT_THE_END, again=True),
)


def action_for(cause: Cause, rival: Cause) -> Action | None:
    """Return what tells two causes apart; None where configurations do."""
    pair = [words_of(named_cell(one.effect, one.subject)) for one in (cause, rival)]
    return next((action for action in _ACTIONS if action.serves(*pair)), None)
