"""Pure tasks with a name and a number each, and where they run, as whoever has many of them sees it.

What chance a task is given follows from the seed of the work and the number of the task alone, as NumPy
spawns seeds (`SeedSequence`; NumPy reference, "Parallel random number generation"), so it does not matter who
computes it, when, after what, or how often.
"""

import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeAlias, TypeVar

import numpy as np

from truepose.analysis.errors import PartFailedError
from truepose.domain.errors import TrueposeError
from truepose.messages.error_codes import code_of
from truepose.messages.message import Text

Item = TypeVar("Item")
Answer = TypeVar("Answer")
Does: TypeAlias = Callable[[Item, np.random.SeedSequence], Answer]  # of a module, so that it can travel


@dataclass(frozen=True, slots=True)
class Part(Generic[Item]):
    """One of many: what it is called, and what it is computed from."""

    name: str
    item: Item


@dataclass(frozen=True, slots=True)
class PartAnswer(Generic[Answer]):
    """A part with its answer."""

    number: int  # of the part, from 0
    name: str
    answer: Answer
    compute_s: float  # that the task itself took, where it ran


@dataclass(frozen=True, slots=True)
class PartFailure:
    """A part without an answer, and the sentence that says why."""

    number: int
    name: str
    why: str
    code: str = ""  # of the error, where it has one


Outcome: TypeAlias = PartAnswer[Answer] | PartFailure


@dataclass(frozen=True, slots=True)
class Task:
    """A part as it travels."""

    does: Callable[[Any, np.random.SeedSequence], Any]
    seed: int
    number: int
    item: Any

    def perform(self) -> "Reply":
        """Return what comes of it; errors are sentences here already, as they may not travel."""
        began_s = time.perf_counter()
        try:
            answer = self.does(self.item, seed_of(self.seed, self.number))
        except TrueposeError as error:
            return Reply(None, 0.0, str(error), code_of(error))
        # Whatever a part raises is its answer. An exception may not unpickle elsewhere, and one bad part must
        # not end the night of all others.
        except Exception as error:
            traceback.print_exc()  # where it ran
            return failed_reply(error)
        return Reply(answer, time.perf_counter() - began_s)


@dataclass(frozen=True, slots=True)
class Reply:
    """What comes back of a task: an answer, or the sentence that says why there is none."""

    answer: Any
    compute_s: float
    why: str = ""
    code: str = ""

    def outcome(self, number: int, name: str) -> "Outcome[Any]":
        """Return it as the outcome of a part."""
        if self.why:
            return PartFailure(number, name, self.why, self.code)
        return PartAnswer(number, name, self.answer, self.compute_s)


def seed_of(seed: int, number: int) -> np.random.SeedSequence:
    """Return the seed of a task: child `number` of `SeedSequence(seed).spawn`, without its elder ones."""
    # Not drawn from a stream: by its number a part has the same chance wherever and however often it is
    # computed (decision 0063).
    return np.random.SeedSequence(seed, spawn_key=(number,))


def in_order(outcomes: Iterable[Outcome[Answer]]) -> Iterator[Outcome[Answer]]:
    """Yield outcomes by their numbers, each as soon as all before it are there."""
    early: dict[int, Outcome[Answer]] = {}
    due = 0
    for outcome in outcomes:
        early[outcome.number] = outcome
        while due in early:
            yield early.pop(due)
            due += 1


Told = Callable[[float, Text], None]
T = TypeVar("T")
ALLOWED_FAILURES = 3  # times that a worker may be lost at one task before the task is blamed; as of Dask


class TaskExecutor(Protocol):
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

    def __init__(self, places: TaskExecutor) -> None:
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
            # Also where whoever asked stops listening: a generator that is closed comes here, and its workers
            # are freed.
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
    if isinstance(outcome, PartAnswer):
        return outcome.answer
    raise PartFailedError(f"{outcome.name}: {outcome.why}")


def failed_reply(error: Exception) -> Reply:
    """Return what is said of a task at which the program failed."""
    why = f"The program failed on this part ({type(error).__name__}: {error}); please report this error."
    return Reply(None, 0.0, why, code_of(error))


def lost_reply(times: int) -> Reply:
    """Return what is said of a task that lost its worker too often."""
    why = (
        f"The worker was lost {times} times while computing this part, so this part was abandoned; it most "
        "likely needs more memory than a worker has."
    )
    return Reply(None, 0.0, why)
