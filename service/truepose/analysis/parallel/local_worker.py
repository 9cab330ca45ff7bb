"""A worker process of this computer (`python -m` this module): tasks come in, replies go out."""

import os
import queue
import sys
import threading
from typing import BinaryIO

from truepose.analysis.job_queue.pipe import claimed_output, packed, received, unpacked
from truepose.analysis.parallel.tasks import Reply, Task, failed_reply

_POLITENESS = 5  # of the processor: a session under way comes first


def main() -> int:
    """Perform the tasks that come."""
    answers = claimed_output()
    if sys.platform != "win32":
        os.nice(_POLITENESS)
    waiting: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    # Read on while a part is computed: the end of this pipe is how a worker learns that nobody wants its
    # answer, however its parent ended.
    threading.Thread(target=_listen, args=(os.fdopen(0, "rb"), waiting), daemon=True).start()
    while True:
        answers.write(_answer(waiting.get()))
        answers.flush()


def _answer(body: bytes) -> bytes:
    reply = _performed(body)
    try:
        return packed(reply)
    except Exception as error:  # an answer of any kind, of which some cannot travel
        return packed(failed_reply(error))


def _performed(body: bytes) -> Reply:
    try:
        task: Task = unpacked(body)
    except (ImportError, AttributeError) as error:
        return Reply(None, 0.0, f"The worker process cannot load this part ({error}).")
    return task.perform()


def _listen(tasks: BinaryIO, waiting: "queue.SimpleQueue[bytes]") -> None:
    """Take tasks as they come; whoever sent them is gone once the pipe is closed, and so is this process."""
    try:
        while True:
            waiting.put(received(tasks))
    # Whatever ends the listening: who computes on would never be given a task again.
    finally:
        os._exit(0)


if __name__ == "__main__":
    sys.exit(main())
