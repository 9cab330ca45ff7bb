"""Tasks done in this process instead of one of their own, which takes longer to start than most tasks take.

What a task is given and what it gives travels as through the pipe, and what it refuses is refused as there.
That a process can be started, bounded, ended and told of is tested in `tests/integration/analysis`.
"""

import asyncio

from truepose.analysis.job_queue.pipe import LENGTH_BYTES, TaskAnswer, packed, unpacked
from truepose.analysis.job_queue.supervisor import TaskRefusedError
from truepose.domain.errors import TrueposeError
from truepose.messages.error_codes import code_of


async def perform_here(task, told):
    """Perform a task in a thread; nobody hears of its progress."""
    return await asyncio.to_thread(_performed, _travelled(task))


def _performed(task):
    try:
        return _travelled(TaskAnswer(task.perform(lambda fraction, doing: None))).answer
    except TrueposeError as error:
        raise TaskRefusedError(str(error), code_of(error)) from error


def _travelled(message):
    return unpacked(packed(message)[LENGTH_BYTES:])
