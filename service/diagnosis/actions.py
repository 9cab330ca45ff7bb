"""Actions: what to do so that one cause leaves readings that another cannot, where no configuration would.

One table, tried from the top: an action serves a pair of causes when the pair has one of its effects, or
both of them where both are needed. A cause without a name counts by its place, its variable and its shape.
"""

from dataclasses import dataclass
from typing import Final

from service.domain.diagnosis import Cause
from service.effects.unnamed.cause import NAME as UNNAMED


@dataclass(frozen=True, slots=True)
class Action:
    """Something to do."""

    effects: frozenset[str]
    do: str  # an imperative, without full stop
    both: bool = False  # it tells these effects from each other, not from anything else
    again: bool = False  # the first configurations are measured once more

    def serves(self, pair: frozenset[str]) -> bool:
        """Return whether it tells the two apart."""
        return pair <= self.effects if self.both else bool(pair & self.effects)


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
    Action(
        frozenset({"payload", "link_mass"}),
        "Measure the same configurations with the load and without it",
        both=True,
    ),
    Action(
        frozenset({"fixture_shift"}),
        "Measure the first poses of each placement again before the base fixture is moved, and check how it "
        "is fastened",
    ),
    Action(
        frozenset({"ballbar_zero"}),
        "Initialise the ballbar on its calibrator before and after each placement, and measure the first "
        "legs again",
    ),
    Action(
        frozenset({"instrument_drift", "tracker"}),
        "Read the fixed nests at least at every tenth configuration, and at the very beginning and end",
    ),
    Action(frozenset({"tool_reseating"}), REMOUNT, again=True),
    Action(frozenset({"nest_offset"}), ALL_NESTS),
    Action(frozenset({"backlash", "sign"}), BOTH_SIDES),
    Action(frozenset({"last move"}), IN_ANOTHER_ORDER),
    Action(frozenset({"thermal_growth", "temperature"}), WARM_AND_COLD, again=True),
    Action(frozenset({"base_drift", "base_shift", "time"}), AT_THE_END, again=True),
)


def action_for(cause: Cause, rival: Cause) -> Action | None:
    """Return what tells two causes apart; None where configurations do."""
    pair = _words(cause) | _words(rival)
    return next((action for action in _ACTIONS if action.serves(pair)), None)


def _words(cause: Cause) -> frozenset[str]:
    """Return the words by which a table of actions knows a cause."""
    return frozenset(cause.subject.split(", ") if cause.effect == UNNAMED else (cause.effect,))
