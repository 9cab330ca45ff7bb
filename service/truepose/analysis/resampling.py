"""A campaign's parameters resampled in many draws, on whatever workers there are."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from truepose.analysis.job_queue.tasks import stored_campaign
from truepose.analysis.parallel.tasks import Cluster, Part
from truepose.domain.arrays import FloatArray
from truepose.domain.campaign import Campaign
from truepose.identification.resampling import Resampling, Spread, Way
from truepose.messages.message import Text
from truepose.storage.documents import pack

TOGETHER: Final = 50  # draws of a part: each begins with a fit of its own, which takes as long as some ten


@dataclass(frozen=True, slots=True)
class DrawsToMake:
    """Draws as they travel to a worker."""

    campaign: bytes
    effects: tuple[str, ...] | None
    way: Way
    draws: int


def draw_parameters(asked: DrawsToMake, seed: np.random.SeedSequence) -> list[FloatArray | None]:
    """Return the parameters of some draws, each with a seed of its own; raises TrueposeError."""
    again = Resampling(stored_campaign(asked.campaign), asked.effects)
    return [again.draw(asked.way, np.random.default_rng(own)) for own in seed.spawn(asked.draws)]


def resample_parameters(
    cluster: Cluster,
    campaign: Campaign,
    effects: tuple[str, ...] | None,
    way: Way,
    draws: int,
    seed: int = 0,
    told: Callable[[float, Text], None] | None = None,
) -> Spread:
    """Return how the parameters of a campaign scatter over so many draws.

    The first draws of many are those of few, whoever makes them.

    Raises
    ------
    ConfigurationError
        The request cannot be understood, or too few draws converged.
    ClusterError
        As of `Cluster.answers`.
    """
    fitted = Resampling(campaign, effects)
    # Arrays as the storage has them: a worker reads them without parsing tables again.
    content = pack(campaign)
    # Parts of one size, and not one for each worker: which draws a part makes must not depend on who is there
    # (decision 0063).
    sizes = [min(TOGETHER, draws - first) for first in range(0, draws, TOGETHER)]
    parts = [
        Part(f"draws {TOGETHER * k + 1} to {TOGETHER * k + size}", DrawsToMake(content, effects, way, size))
        for k, size in enumerate(sizes)
    ]
    made: Sequence[list[FloatArray | None]] = cluster.answers(draw_parameters, parts, seed, told)
    return fitted.spread(way, [one for some in made for one in some])
