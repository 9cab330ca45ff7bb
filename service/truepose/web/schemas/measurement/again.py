"""A session planned as an earlier one."""

from typing import Literal

from pydantic import Field

from truepose.web.schemas.base import VISIBLE, Number, Request, example


class RepeatRequest(Request):
    """A session to plan as an earlier one; nothing moves by planning."""

    model_config = example({"name": "left arm, November", "poses": "same"})

    name: str = Field(min_length=1, max_length=200, pattern=VISIBLE, examples=["left arm, November"])
    poses: Literal["same", "anew"] = Field(
        "same", description="same: those of then. anew: as many, chosen by the same rules in the cell of now."
    )
    attachment: Number | None = Field(
        None, description="How often the tool has been mounted; null: as often as then."
    )
