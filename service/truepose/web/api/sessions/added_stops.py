"""Configurations that are added to the plan of a session."""

from pydantic import Field

from truepose.messages.message import message, together
from truepose.planning.tracker.added_stops import Addition, WantedStop
from truepose.sessions.tracker.service import WantedStops
from truepose.sessions.tracker.steps import numbers
from truepose.web.api.sessions.schemas import AngleDeg, SessionReply, StopReply
from truepose.web.middleware.language import Said, in_words
from truepose.web.schemas import Number, PersonName, Reply, Request, example


class ConfigurationRequest(Request):
    """A configuration to add to a plan."""

    joints_deg: list[AngleDeg] = Field(
        min_length=1, max_length=32, description="Nominal joint angles.", examples=[[0, 45, -30, 0, 30, 0]]
    )
    nest: Number | None = Field(
        None, description="Tool nest; null selects the one that faces the tracker best."
    )


class AdditionRequest(Request):
    """Configurations to add to the plan of a session, proposed by a diagnosis or chosen by the user."""

    model_config = example({
        "person": "Ada Byron",
        "configurations": [{"joints_deg": [0, 45, -30, 0, 30, 0]}, {"joints_deg": [10, 40, -20, 0, 45, 90]}],
    })

    person: PersonName
    configurations: list[ConfigurationRequest] = Field(min_length=1, max_length=1000)
    leave_out_unfit: bool = Field(
        False,
        description="True: omit configurations that cannot be measured in this cell and give the reasons "
        "in the reply. False: refuse the request if there is such a configuration.",
    )
    diagnosis_id: Number | None = Field(
        None,
        description="Diagnosis of this session that proposed the configurations. The diagnosis is "
        "repeated with the same initial model once the session has finished.",
    )


class AdditionReply(Reply):
    """Configurations added to the plan, and when they will be measured."""

    sentence: Said = Field(examples=["Added configurations 56 to 59; a person confirms ..."])
    stops: list[StopReply]
    left_out: list["LeftOutReply"]
    session: SessionReply


class LeftOutReply(Reply):
    """A configuration that cannot be measured in this cell."""

    configuration: int = Field(description="Position in the request, starting at 1.", examples=[2])
    reason: str


def wanted_stops(wanted: AdditionRequest) -> WantedStops:
    """Return what a request wants to add."""
    stops = [entry.into(WantedStop) for entry in wanted.configurations]
    return wanted.into(WantedStops, configurations=stops)


def addition_reply(found: Addition, session: SessionReply) -> AdditionReply:
    """Return what was added as it travels."""
    added = message("session.done.added", configurations=numbers(found.stops))
    return AdditionReply(
        sentence=in_words(together(added, found.notice)),
        stops=[StopReply.of(stop) for stop in found.stops],
        left_out=[LeftOutReply.of(left, configuration=left.number) for left in found.left_out],
        session=session,
    )
