"""Where tasks run, as whoever has many of them sees it: so many fit in at a time, outcomes as they come."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Protocol, TypeVar

from truepose.analysis.cluster.parts import Answer, Does, Done, Item, Outcome, Part, Reply, Task, in_order
from truepose.analysis.errors import PartFailedError

Told = Callable[[float, str], None]
T = TypeVar("T")
ALLOWED_FAILURES = 3  # times that a worker may be lost at one task before the task is blamed; as of Dask


class Places(Protocol):
    """Where tasks run. A lost worker's task is given to another; a task that loses several is given up."""

    def room(self) -> int:
        """Return how many more tasks are taken now: no worker waits for the next one, none hoards many."""
        ...

    def begin(self, task: Task) -> None:
        """Take a task; its number is its name here."""
        ...

    def ended(self) -> tuple[int, Reply]:
        """Wait for the next task that has ended, and return its number with what came of it."""
        ...

    def give_up(self) -> None:
        """Drop the tasks that have not ended."""
        ...


class Cluster:
    """Computes many parts in the places that there are."""

    def __init__(self, places: Places) -> None:
        self._places = places

    def outcomes(
        self, does: Does[Item, Answer], parts: Iterable[Part[Item]], seed: int = 0
    ) -> Iterator[Outcome[Answer]]:
        """Yield the outcome of every part as it comes; closing the iterator drops those that have not ended.

        Parameters
        ----------
        does : callable
            A function of a module, pure: it is given the item and a seed of its own, and may be called twice.
        parts : iterable of Part
            Read as far ahead as workers need, so that many large ones never lie in memory together.
        seed : int
            Of the whole work.

        Raises
        ------
        ClusterError
            The workers cannot be used, or are lost for good; outcomes that were yielded stand.
        """
        names: dict[int, str] = {}
        waiting = enumerate(parts)
        try:
            while True:
                self._fill(does, waiting, seed, names)
                if not names:
                    return
                number, reply = self._places.ended()
                yield reply.outcome(number, names.pop(number))
        finally:
            if names:
                self._places.give_up()

    def answers(
        self, does: Does[Item, Answer], parts: Sequence[Part[Item]], seed: int = 0, told: Told | None = None
    ) -> list[Answer]:
        """Return the answers in the order of the parts.

        Raises
        ------
        PartFailedError
            A part has none; it names the part and says why.
        ClusterError
            As of `outcomes`.
        """
        answers: list[Answer] = []
        for outcome in in_order(self.outcomes(does, parts, seed)):
            answers.append(_answer(outcome))
            if told is not None:
                told(len(answers) / len(parts), f"{len(answers)} of {len(parts)}: {outcome.name}")
        return answers

    def _fill(
        self,
        does: Does[Item, Answer],
        waiting: Iterator[tuple[int, Part[Item]]],
        seed: int,
        names: dict[int, str],
    ) -> None:
        for _ in range(self._places.room()):
            number, part = next(waiting, (None, None))
            if number is None or part is None:
                return
            self._places.begin(Task(does, seed, number, part.item))
            names[number] = part.name


def _answer(outcome: Outcome[T]) -> T:
    if isinstance(outcome, Done):
        return outcome.answer
    raise PartFailedError(f"{outcome.name}: {outcome.why}")


def lost_reply(times: int) -> Reply:
    """Return what is said of a task that lost its worker too often."""
    why = (
        f"Its worker was lost {times} times while it was computed, so it was given up; most often it needs "
        "more memory than a worker has."
    )
    return Reply(None, 0.0, why)
