"""Questions that are given up, and questions that meet."""

import asyncio
import contextlib
from typing import Final

from truepose_drivers.contract import spoiling
from truepose_drivers.contract.case import case
from truepose_drivers.contract.trial import Trial
from truepose_drivers.errors import DriverError

_AT_ONCE: Final = 5
_LATEST_S: Final = 0.1  # at which a question is given up


@case(
    times=12,
    remedy="hold the conversation in Turns.turn(), which closes the link of a question that was given up",
)
async def a_question_given_up_leaves_nothing_behind(trial: Trial) -> None:
    """A reading that is cancelled in the middle leaves no answer for the next one to take."""
    await trial.read()
    trial.bench.move(trial.rng)
    trial.spoil(spoiling.split)
    asking = asyncio.create_task(trial.bench.ask(trial.device))
    await asyncio.sleep(float(trial.rng.uniform(0.0, _LATEST_S)))
    asking.cancel()
    with contextlib.suppress(asyncio.CancelledError, DriverError):
        await asking
    trial.mend()
    await trial.recover()


@case(
    times=4,
    remedy="let one exchange wait for the other: Conversation.ask does, Turns.turn() where you need more",
)
async def questions_at_once_get_their_own_answers(trial: Trial) -> None:
    """Several tasks that ask at once each get a right reading, or an error, never each other's answer."""
    await trial.read()
    trial.bench.move(trial.rng)
    await asyncio.gather(*(trial.take() for _ in range(_AT_ONCE)))
    await trial.recover()
