"""What an address says of how a result is to be judged."""

from typing import Annotated

from fastapi import Depends, Query

from truepose.domain.results.validation import DecisionRule
from truepose.web.results.kinds import Choice
from truepose.web.schemas.base import NUMBER_LIMIT


async def _choice(
    model_id: Annotated[
        int | None, Query(ge=1, le=NUMBER_LIMIT, description="Which judges; by default the newest one.")
    ] = None,
    limit_mm: Annotated[float | None, Query(gt=0, le=1000, description="Largest error that passes.")] = None,
    rule: Annotated[DecisionRule, Query(description="How a limit counts the uncertainty.")] = "guard band",
) -> Choice:
    return Choice(model_id, limit_mm, rule)


Chosen = Annotated[Choice, Depends(_choice)]
