"""Health of the service."""

from typing import Literal

from pydantic import Field

from truepose.storage.integrity.condition import Integrity
from truepose.web.healthiness.checks import Verdict
from truepose.web.schemas.base import Reply


class CheckReply(Reply):
    """One thing that was looked at."""

    name: str = Field(
        description="What it was: the database, the disk, the chain of records, and so on.",
        examples=["disk"],
    )
    verdict: Verdict = Field(description="`warn`: look at it soon. `bad`: look at it now.")
    sentence: str = Field(
        description="For whoever runs the service.", examples=["24.1 GB are free where the database lies."]
    )


class IntegrityReply(Reply):
    """Whether all records are as they were written; looked through after each start and now and then."""

    state: Integrity
    share: float = Field(description="Done, of the look under way or the last one.", examples=[1.0])


class Health(Reply):
    """Whether the service works, and on what."""

    status: Literal["ok", "degraded"] = Field(description="`degraded`: `fault` says what is amiss.")
    fault: str | None = Field(description="One sentence; null where all is well.")
    version: str = Field(description="Of the program.", examples=["0.1.0"])
    simulated: bool = Field(description="True: no robot and no instrument take part.")
    people: Literal["announced", "anybody"] = Field(
        description="Who may have the arm move: people of the cell file, or whoever gives a name."
    )
    writable: bool = Field(description="False: the disk refuses records; sessions wait for it.")
    integrity: IntegrityReply
    sqlite: str = Field(description="Version of the database library.", examples=["3.53.4"])
    sqlite_mended: bool = Field(
        description="False: the library has the fault of the WAL reset; one writer keeps it from striking."
    )
    verdict: Verdict = Field(description="The worst of all checks.")
    checks: list[CheckReply] = Field(description="What was looked at.")
    schema_revision: str = Field(alias="schema", description="Of the database.", examples=["0006"])
