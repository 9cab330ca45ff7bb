"""Actions: what to do so that one cause leaves readings that another cannot, where no configuration would.

One table, tried from the top: an action serves a pair of causes by the words of their cells, their places,
variables and shapes.
"""

from dataclasses import dataclass
from typing import Final

from truepose.domain.diagnosis import Cause
from truepose.effects.cells import named_cell, words_of


@dataclass(frozen=True, slots=True)
class Action:
    """Something to do."""

    one: frozenset[str]  # words of which one of the two causes has some
    do: str  # an imperative, without full stop
    each: str = ""  # a word that both have; "": none is needed
    again: bool = False  # the first configurations are measured once more

    def serves(self, one: frozenset[str], other: frozenset[str]) -> bool:
        """Return whether it tells two causes of these words apart."""
        return bool(self.one & (one | other)) and (not self.each or self.each in one & other)


BOTH_SIDES: Final = (
    "Approach each configuration twice, once with all joints coming from below and once from above"
)
REMOUNT: Final = (
    "Take the tool off, mount it again and measure these configurations again, without measuring anew "
    "where its nests are"
)
ALL_NESTS: Final = "Read every nest of the tool in the same configurations"
AT_THE_END: Final = "Measure the first configurations again at the end"
IN_ANOTHER_ORDER: Final = (
    "Measure the same configurations again in another order, so that each is reached from elsewhere"
)
WARM_AND_COLD: Final = (
    "Measure these configurations again once the robot has warmed up, and again when it has cooled down"
)

_ACTIONS: Final = (
    Action(frozenset({"tool"}), "Measure the same configurations with the load and without it", each="load"),
    Action(
        frozenset({"placement"}),
        "Measure the first poses of each placement again before the base fixture is moved, and check how it "
        "is fastened",
    ),
    Action(
        frozenset({"ballbar constant"}),
        "Initialise the ballbar on its calibrator before and after each placement, and measure the first "
        "legs again",
    ),
    Action(
        frozenset({"tracker time"}),
        "Read the fixed nests at least at every tenth configuration, and at the very beginning and end",
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
