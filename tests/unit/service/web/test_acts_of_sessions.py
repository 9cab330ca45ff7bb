"""What people did in a session, as a report prints it."""

from truepose.domain.ballbar import LengthTaken, Suspicion
from truepose.domain.ledger import Control, EntryKind, LedgerEntry
from truepose.domain.session import IdentityTaken, PlannedStop, SessionState
from truepose.messages.catalogue import IN_ENGLISH
from truepose.storage.people import ActRecord, PersonsAct
from truepose.storage.records import AddedStops, AdditionRecord, LedgerRecord, StateChange
from truepose.web.api.authority import TAKEN_FROM
from truepose.web.pages.session_history import OnRecord, events_of

LEG = "placement-1/pose-12/leg-2-3"
LENGTH = LengthTaken(
    length_mm=300.1, deviation_mm=0.1, zero_mm=0.0, standard_uncertainty_mm=0.001, spread_mm=0.0, samples=20,
    initialisation=1, by_hand=True, temperature_c=21.0, instrument_serial="7", certificate="",
    certificate_expires="", time_s=1.0,
)  # fmt: skip


def at(minute):
    return f"2026-11-01T09:{minute:02}:00+00:00"


def lines(*entries):
    return [LedgerRecord(n, at(n), entry) for n, entry in enumerate(entries, start=1)]


def line(kind, step_id="", **said):
    return LedgerEntry(step_id, kind, 0.0, **{"person": "Ada", **said})


def told(*entries, states=(), **others):
    events = events_of(OnRecord(7, states, lines(*entries), **others), IN_ENGLISH)
    return [(one.when, one.person, IN_ENGLISH.spoken(one.what)) for one in events]


def test_what_nobody_answers_for_is_not_told():
    assert told() == []
    assert told(line(EntryKind.SHOWN, LEG), line(EntryKind.MOVED, LEG), line(EntryKind.REOPENED, LEG)) == []


def test_a_configuration_that_was_left_out_has_who_and_why():
    (event,) = told(line(EntryKind.SKIPPED, "stop-4", key="k", text="The beam is in the way."))

    assert event == (
        "2026-11-01 09:01 UTC", "Ada", "Skipped: configuration 4. Reason: The beam is in the way."
    )  # fmt: skip


def test_what_the_service_left_out_is_nobodys_act():
    (event,) = told(line(EntryKind.SKIPPED, "stop-4", text="No reflector was found."))

    assert event[1:] == ("", "Not measured: configuration 4. No reflector was found.")


def test_confirmations_are_counted_by_person_and_motions_among_them():
    move, leg = "placement-1/pose-12/move", LEG
    events = told(
        line(EntryKind.CONFIRMED, move), line(EntryKind.CONFIRMED, leg), line(EntryKind.CONFIRMED, move),
        line(EntryKind.CONFIRMED, move, person="Alan"),
    )  # fmt: skip

    span = "2026-11-01 09:01 UTC to 2026-11-01 09:03 UTC"
    assert events == [
        (span, "Ada", "Confirmations: 3. 2 of them started an arm motion."),
        ("2026-11-01 09:04 UTC", "Alan", "Confirmations: 1. 1 of them started an arm motion."),
    ]


def test_the_word_that_the_cell_is_clear_counts_and_the_same_question_stands_once():
    asked = StateChange(at(2), SessionState.AWAITING_CONFIRMATION, "Is the cell clear?", None)
    goes = StateChange(at(3), SessionState.RUNNING, "Ada continued the session.", "Ada")

    events = told(states=[asked, goes, asked, goes])

    assert [event[2] for event in events] == [
        "Session 7: awaiting confirmation. Is the cell clear?",
        "Confirmations: 2. 2 of them started an arm motion.",
    ]


def test_doubts_are_told_by_what_was_said_to_them():
    doubt = Suspicion("other_pair", (2, 3), (1, 3), 300.2, 300.9)

    events = told(
        line(EntryKind.ANSWERED, LEG, suspicion=doubt, text="reconnected"),
        line(EntryKind.MEASURED, LEG, suspicion=doubt, length=LENGTH),
    )

    assert [event[2] for event in events] == [
        "Suspect reading repeated: configuration 12 B2 to T3.",
        "Suspect reading kept on request: configuration 12 B2 to T3.",
        "Lengths stored manually: 1.",
    ]


def test_another_instrument_another_tablet_and_a_lost_zero_are_told():
    accepted = IdentityTaken("ballbar", "accepted", "77", "42", "Alan")
    events = told(
        line(EntryKind.CONTROL, identity=accepted, person=None),
        line(EntryKind.CONTROL, control=Control.HAND_OVER, tablet="at the door"),
        line(EntryKind.CONTROL, control=Control.ZERO_LOST, person=None),
        line(EntryKind.CONTROL, entered=SessionState.PAUSED),
    )

    assert [event[1:] for event in events] == [
        ("Alan", "Accepted a different instrument: ballbar, serial number 77."),
        ("Ada", "Moved to another tablet: at the door."),
        ("", "The ballbar lost power. Its zero was measured again afterwards."),
    ]


def test_who_took_the_authority_and_who_added_stand_in_the_order_of_time():
    act = PersonsAct(at(5), "claim_authority", "/", 200, "Grace", reason=f"{TAKEN_FROM}Ada")
    added = AddedStops(7, "Alan", (PlannedStop(40, (0.0,), 1), PlannedStop(41, (0.1,), 1)))

    events = told(
        line(EntryKind.REOPENED, "stop-4", key="k", text="It was knocked."),
        authority=[ActRecord(1, at(5), act)],
        additions=[AdditionRecord(at(3), added)],
    )

    assert [event[1:] for event in events] == [
        ("Ada", "Reopened, to be repeated: configuration 4. It was knocked."),
        ("Alan", "Configurations added to the plan: 2."),
        ("Grace", "Took control of the session from Ada."),
    ]
