"""The worker process (`python -m` this module, then BYTES): a task comes in, an answer goes out.

It may take so many bytes of memory: what needs more is refused here, where it costs nobody else anything.
"""

import os
import sys
import threading
import traceback
from typing import BinaryIO, Final

from truepose.analysis.job_queue.pipe import (
    TaskAnswer,
    TaskProgress,
    TaskRefusal,
    claimed_output,
    packed,
    receive,
)
from truepose.analysis.job_queue.tasks import Report, Task
from truepose.domain.errors import TrueposeError
from truepose.messages.error_codes import code_of
from truepose.messages.message import message

_POLITENESS: Final = 5  # of the processor: a session under way comes first


def main() -> int:
    """Perform the task that the service sends."""
    # Before the task imports anything that might print.
    answers = claimed_output()
    _keep_within(int(sys.argv[1]))
    task = receive(sys.stdin.buffer)
    # Both read the same input: the task first, then only whether it is still open.
    threading.Thread(target=_end_with_the_service, daemon=True).start()
    _send(answers, _performed(task, lambda *told: _send(answers, packed(TaskProgress(*told)))))
    return 0


def _performed(task: Task, report: Report) -> bytes:
    """Return the message that ends the conversation."""
    try:
        # Packed here: an answer that cannot be packed, or not in this memory, is refused as any failure is.
        return packed(TaskAnswer(task.perform(report)))
    except TrueposeError as error:
        return packed(TaskRefusal(error.text, code_of(error)))
    except MemoryError:
        return packed(TaskRefusal(message("job.memory", megabytes=int(sys.argv[1]) // 2**20)))
    except Exception as error:
        # The traceback goes to the service's log; the sentence to whoever asked.
        traceback.print_exc()
        return packed(TaskRefusal(message("job.task_failed", kind=type(error).__name__, why=str(error))))


def _keep_within(memory_bytes: int) -> None:
    """Let the system refuse more memory than that, and give the processor to others first."""
    if sys.platform != "win32":
        import resource

        # The data segment and not the address space, of which libraries reserve much that they never use
        # (decision 0023).
        resource.setrlimit(resource.RLIMIT_DATA, (memory_bytes, memory_bytes))
        os.nice(_POLITENESS)


def _send(stream: BinaryIO, message: bytes) -> None:
    stream.write(message)
    stream.flush()


def _end_with_the_service() -> None:
    # The service holds our input open as long as it lives: a killed service leaves no worker behind.
    # Read past the buffer: its lock, held by a daemon thread, would abort an orderly end.
    os.read(0, 1)
    os._exit(1)


if __name__ == "__main__":
    sys.exit(main())
