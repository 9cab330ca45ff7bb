"""Pure tasks with a name and a number each, and what becomes of them.

What chance a task is given follows from the seed of the work and the number of the task alone, as NumPy
spawns seeds (`SeedSequence`; NumPy reference, "Parallel random number generation"), so it does not matter who
computes it, when, after what, or how often.
"""

import time
import traceback
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Any, Generic, TypeAlias, TypeVar

import numpy as np

from truepose.domain.errors import TrueposeError
from truepose.words.error_codes import code_of

Item = TypeVar("Item")
Answer = TypeVar("Answer")
Does: TypeAlias = Callable[[Item, np.random.SeedSequence], Answer]  # of a module, so that it can travel


@dataclass(frozen=True, slots=True)
class Part(Generic[Item]):
    """One of many: what it is called, and what it is computed from."""

    name: str
    item: Item


@dataclass(frozen=True, slots=True)
class Done(Generic[Answer]):
    """A part with its answer."""

    number: int  # of the part, from 0
    name: str
    answer: Answer
    compute_s: float  # that the task itself took, where it ran


@dataclass(frozen=True, slots=True)
class Failed:
    """A part without an answer, and the sentence that says why."""

    number: int
    name: str
    why: str
    code: str = ""  # of the error, where it has one


Outcome: TypeAlias = Done[Answer] | Failed


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
        except Exception as error:
            traceback.print_exc()  # where it ran
            why = f"The program failed at this part ({type(error).__name__}: {error}); please report it."
            return Reply(None, 0.0, why, code_of(error))
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
            return Failed(number, name, self.why, self.code)
        return Done(number, name, self.answer, self.compute_s)


def seed_of(seed: int, number: int) -> np.random.SeedSequence:
    """Return the seed of a task: child `number` of `SeedSequence(seed).spawn`, without its elder ones."""
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
