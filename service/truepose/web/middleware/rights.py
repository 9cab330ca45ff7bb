"""Who asks, and the one table of who may do what: for each operation the least role that may ask for it.

An operation that is not here may be asked for by nobody: the service does not start.
"""

from collections.abc import Iterable, Mapping
from contextvars import ContextVar
from dataclasses import dataclass
from enum import StrEnum
from typing import Annotated, Final

from fastapi import Depends

from truepose.domain.errors import TrueposeError
from truepose.domain.people import Role, reaches
from truepose.people.register import EVERYBODY, Caller


@dataclass(slots=True)
class RequestRecord:
    """A request, as far as it goes on record."""

    caller: Caller = EVERYBODY
    address: str = ""
    reason: str | None = None  # why, as the body says
    about: str | None = None  # the person whom it is about, where nobody is signed in yet
    command: str | None = None  # of a request that asks something of a session
    renews: bool = False  # keeps what the same person has already: no event


_REQUEST: Final[ContextVar[RequestRecord | None]] = ContextVar("asking", default=None)


def current_request() -> RequestRecord:
    """Return who asks; everybody where no gate stands before the routes."""
    return _REQUEST.get() or RequestRecord()


def begin_request(found: RequestRecord) -> None:
    """Say who asks, for the rest of this request."""
    _REQUEST.set(found)


def signed_in_name() -> str | None:
    """Return the name of whoever is signed in; None where nobody is asked."""
    return current_request().caller.name or None


async def _request() -> RequestRecord:
    return current_request()


async def _caller() -> Caller:
    return current_request().caller


CurrentRequest = Annotated[RequestRecord, Depends(_request)]
CurrentCaller = Annotated[Caller, Depends(_caller)]


class Anybody(StrEnum):
    """Of an operation: whoever reaches the service, signed in or not."""

    ANYBODY = "anybody"


_BY_LEAST: Final[Mapping[Role | Anybody, str]] = {
    # What a supervisor and a sign-in page need; nothing of it tells of the shop.
    Anybody.ANYBODY: """
        get_health static_file tablet_file tablet_texts report_style sign_in_page first_person_page
        welcome_page sign_in get_caller enter_first_person accept_link watch_page follow_watched
        colours package_file
    """,
    # Whoever sees a robot move may stop it: `command_session` asks for more where it is no halt.
    Role.VIEWER: """
        openapi get_metrics api_page cell_page work_page noun_page reports_page errors_page error_page
        robot_page campaign_page identification_page validation_page model_page job_page closing_page
        report_page report_pdf report_file checklist_view checklist_pdf get_session_space
        plan_checklist_view plan_checklist_pdf
        sessions_page session_page result_page operator_page new_session_page again_page
        get_identification_space get_validation_space get_diagnosis_space
        get_identification_residuals get_validation_residuals get_diagnosis_residuals
        identification_readings validation_readings diagnosis_readings
        corrections_page correction_page diagnoses_page diagnosis_page plan_page faults_page
        list_cells get_cell list_devices get_device list_robots get_robot
        list_sessions get_session get_plan get_progress get_proof get_circles get_sphere get_accuracy
        get_promise_of_session get_promise_of_cell list_readings list_readings_of_session get_reading
        get_situation get_scene read_ledger follow_session
        list_contact_readings get_hands get_faults follow_events
        list_jobs get_job list_campaigns get_campaign download_campaign
        list_identifications get_identification list_validations get_validation
        list_diagnoses get_diagnosis compare_diagnoses
        list_models get_model download_model download_export
        list_corrections list_corrections_of_model get_correction list_targets download_corrected
        get_sheet get_outlook get_closing
        list_series get_series list_readings_of_series
        bring_page draft_page list_drafts get_draft get_understood
        command_session
        list_hand_downs get_hand_down get_hand_down_check handed_down_page
        list_plant_cells get_plant_cell list_plant_hand_downs get_plant_hand_down
        list_seen_robots get_robot_life list_seen_instruments get_instrument_life
        list_plant_results get_plant_record
        plant_page plant_cell_page fleet_page robot_life_page instrument_life_page
        list_plant_records list_plant_changes
        sign_out show_again switch_person choose_secrets account_page not_yours_page get_authority
    """,
    Role.OPERATOR: """
        plan_session add_configurations plan_session_again connect_device
        disconnect_device use_hands
        make_campaign upload_campaign identify_campaign validate_model diagnose_campaign diagnose_session
        start_draft add_draft_file correct_draft remove_draft_file remove_draft make_campaign_of_draft
        start_series add_readings make_draft_of_series
        use_hand_down plan_visit
        cancel_job claim_authority give_up_authority list_watch_links make_watch_link revoke_watch_link
    """,
    Role.METROLOGIST: """
        accept_branch add_hand_down accept_handed_down_model
        close_session correct_file give_fault end_fault audit_page list_acts download_acts
    """,
    Role.ADMINISTRATOR: """
        people_page list_people enter_person change_role remove_person make_link list_tokens make_token
        revoke_token
        get_chain_head list_links accept_hand_down
    """,
}
# What a program may do beside looking: it plans, brings data and has them computed.
_DEVICES: Final = """
    plan_session plan_session_again make_campaign upload_campaign
    identify_campaign validate_model diagnose_campaign diagnose_session correct_file cancel_job
    start_draft add_draft_file correct_draft remove_draft_file remove_draft make_campaign_of_draft
    start_series add_readings make_draft_of_series
"""
# What a plant may ask of a cell, and nothing beside it; above it whoever says who may do what.
_PLANTS: Final = "get_chain_head list_links accept_hand_down list_hand_downs get_hand_down"
# After these a calibration counts: whoever asks shows once more that it is them. Of commands after which an
# arm may move, `require_authority` asks for that.
FRESH: Final = frozenset({"close_session"})

# What commands of the machine's administrator ask for; the arm is none of their business.
OF_MACHINE: Final = frozenset({
    "list_people",
    "enter_person",
    "change_role",
    "remove_person",
    "make_link",
    "make_token",
})

_OF_DEVICES: Final = frozenset(_DEVICES.split())
_OF_PLANTS: Final = frozenset(_PLANTS.split())
LEAST: Final[Mapping[str, Role | Anybody]] = {
    name: least for least, names in _BY_LEAST.items() for name in names.split()
}


class MissingRightError(TrueposeError):
    """Nobody has said who may ask for an operation."""


def require_complete(operations: Iterable[str]) -> None:
    """Raise MissingRightError where the table does not say who may ask for one of these."""
    missing = sorted(set(operations) - LEAST.keys())
    if missing:
        raise MissingRightError(
            f"No minimum role is defined for {', '.join(missing)}. Add one for each in "
            "truepose/web/middleware/rights.py."
        )


def may_ask(caller: Caller, operation: str | None) -> bool:
    """Whether somebody may ask for an operation: a program never for more than its owner may now."""
    if caller.role is None:
        return False
    owner = caller.person if caller.token is not None else None
    return may(caller.role, operation) and (owner is None or may(owner.role, operation))


def may(role: Role, operation: str | None) -> bool:
    """Whether a role may ask for an operation; None: for what does not exist, to be told so."""
    least = Role.VIEWER if operation is None else LEAST[operation]
    if isinstance(least, Anybody):
        return True
    if role is Role.PLANT:
        return operation in _OF_PLANTS
    if role is Role.DEVICE:
        return least is Role.VIEWER or operation in _OF_DEVICES
    return reaches(role, least)
