"""The table of states keeps its two rules."""

import pytest

from truepose.domain.session import SessionState as S
from truepose.sessions.engine.states import TRANSITIONS, after_restart, has_ended, require_transition
from truepose.sessions.errors import NotNowError


def test_every_state_has_its_line_in_the_table():
    assert set(TRANSITIONS) == set(S)


def test_motion_is_allowed_again_only_from_where_a_person_answers():
    assert {state for state in S if S.RUNNING in TRANSITIONS[state]} == {S.AWAITING_CONFIRMATION, S.PAUSED}


def test_every_state_that_has_not_ended_can_fail_and_can_be_ended():
    for state in S:
        if not has_ended(state):
            assert S.FAILED in TRANSITIONS[state]
            assert {S.ABORTED, S.ABORTING} & TRANSITIONS[state]


def test_what_has_ended_stays_so():
    assert {state for state in S if has_ended(state)} == {S.ABORTED, S.FINISHED, S.FAILED}


def test_a_step_that_the_table_lacks_is_refused_in_words():
    with pytest.raises(NotNowError, match=r"is finished; it cannot become running"):
        require_transition(S.FINISHED, S.RUNNING)


@pytest.mark.parametrize("state", [S.RUNNING, S.PAUSING, S.PAUSED, S.AWAITING_CONFIRMATION])
def test_after_a_restart_whatever_could_move_waits_for_a_person(state):
    assert after_restart(state) is S.AWAITING_CONFIRMATION


@pytest.mark.parametrize("state", [S.PLANNED, S.FINISHED, S.FAILED, S.ABORTED])
def test_after_a_restart_what_stood_still_is_as_it_was(state):
    assert after_restart(state) is state


def test_a_session_that_was_ending_has_ended_after_a_restart():
    assert after_restart(S.ABORTING) is S.ABORTED
