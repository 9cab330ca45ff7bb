"""The best of several plans, each chosen from candidates of its own."""

from collections.abc import Callable
from functools import partial
from typing import Protocol

import numpy as np

from truepose.analysis.parallel.tasks import Cluster, Part
from truepose.messages.message import Text
from truepose.planning.prediction.plan import PromisedPlan

Told = Callable[[float, Text], None]
_INDEX = "O1"


class MakePlan(Protocol):
    """Plans so many configurations; what a seed draws are the candidates."""

    def __call__(self, *, n: int | None, seed: int) -> PromisedPlan:
        """Return a plan; raises PlanningError."""
        ...


def plan_of(make: Callable[[], PromisedPlan], _seed: np.random.SeedSequence) -> PromisedPlan:
    """Return the plan; its seed is the one that it would be given alone."""
    return make()


def best_plan(
    cluster: Cluster, planned: MakePlan, n: int | None, seed: int, tries: int, told: Told | None = None
) -> tuple[PromisedPlan, int]:
    """Return the plan with the largest O1 of those of `tries` seeds from `seed` on, and its seed.

    The index says how well the parameters are seen, which is what candidates are chosen by. It knows nothing
    of the places at which the promise was worked out, so that nobody picks a promise for being large. Without
    `n`, as many configurations as the first plan advises. Of equal plans the first.

    Raises
    ------
    PartFailedError
        One of the plans cannot be made.
    """
    # The first seed alone says how many configurations are advised. The others plan as many, so that the
    # index compares choices and not numbers.
    first, *_ = cluster.answers(plan_of, [_part(planned, n, seed)])
    wanted = len(first.joints_rad) if n is None else n
    if tries == 1 or not wanted:
        return first, seed
    others = [_part(planned, wanted, seed + k) for k in range(1, tries)]
    plans = [first, *cluster.answers(plan_of, others, told=told)]
    best = max(range(tries), key=lambda k: plans[k].observability.get(_INDEX, 0.0))
    return plans[best], seed + best


def _part(planned: MakePlan, n: int | None, seed: int) -> Part[Callable[[], PromisedPlan]]:
    return Part(f"seed {seed}", partial(planned, n=n, seed=seed))
