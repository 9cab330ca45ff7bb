"""What is kept of secrets, how often one may guess, and a time that nobody puts back."""

from datetime import UTC, datetime, timedelta

import pytest
from argon2 import PasswordHasher, Type, extract_parameters
from argon2.exceptions import VerifyMismatchError

from truepose.domain.people import Role, lesser, reaches
from truepose.people.attempts import Guesses
from truepose.people.errors import TooManyGuessesError
from truepose.people.secrets import (
    NOBODYS,
    Badges,
    chosen_hash,
    fingerprint,
    matches,
    new_secret,
)
from truepose.people.steady_time import SteadyTime

NOON = datetime(2026, 5, 4, 12, tzinfo=UTC)


def test_what_somebody_chose_is_kept_as_argon2id_of_19_mib_in_two_passes():
    for kept in (chosen_hash("on the looms of Lyon"), NOBODYS, Badges([]).hashed("0007421993")):
        made = extract_parameters(kept)
        assert (made.type, made.memory_cost >= 19 * 1024, made.time_cost >= 2) == (Type.ID, True, True)


def test_who_is_unknown_is_compared_with_a_hash_and_not_turned_away_before():
    with pytest.raises(VerifyMismatchError):  # what is no hash at all is InvalidHashError, at once
        PasswordHasher().verify(NOBODYS, "caf\u00e9 au lait")


def test_a_secret_is_that_one_and_no_other_however_it_was_typed():
    kept = chosen_hash("caf\u00e9 au lait")

    assert matches(kept, "cafe\u0301 au lait")
    assert not matches(kept, "cafe au lait")
    assert not matches(kept, "")
    assert not matches("no hash at all", "cafe au lait")


def test_a_badge_is_looked_up_among_others():
    badges = Badges([])
    first, second = badges.hashed("0007421993"), badges.hashed("0007421994")

    assert Badges([first, second]).hashed("0007421994") == second != first
    assert Badges([]).hashed("0007421994") != second  # another installation's


def test_random_secrets_are_long_and_only_their_hash_is_kept():
    assert len({new_secret() for _ in range(100)}) == 100
    assert len(new_secret()) == 43
    assert "x" * 43 not in fingerprint("x" * 43)


def test_no_minute_has_more_than_ten_guesses_for_an_account_or_an_address():
    now_s, taken = [0.0], []
    guesses = Guesses(lambda: now_s[0])
    for _ in range(3000):
        now_s[0] += 0.1
        try:
            guesses.take("account 1", "address 10.0.0.7")
        except TooManyGuessesError as error:
            assert 1 <= error.retry_after_s <= 12
        else:
            taken.append(now_s[0])

    most = max(sum(begin <= at < begin + 60 for at in taken) for begin in taken)
    assert 8 <= most <= 10


def test_an_address_that_guesses_spends_nobody_else_s_guesses():
    guesses = Guesses(lambda: 0.0)
    for _ in range(5):
        guesses.take("account 1", "address 10.0.0.7")

    with pytest.raises(TooManyGuessesError):
        guesses.take("account 2", "address 10.0.0.7")
    guesses.take("account 2", "address 10.0.0.8")


@pytest.mark.parametrize("jump", [timedelta(hours=-1), timedelta(days=-3650), timedelta(days=3650)])
def test_a_clock_that_is_set_makes_nothing_live_longer(jump):
    wall, elapsed_s = [NOON], [0.0]
    time = SteadyTime(None, lambda: wall[0], lambda: elapsed_s[0])
    until = time.in_future(1)

    wall[0] += jump
    elapsed_s[0] = 23 * 3600.0
    assert not time.is_over(until)
    elapsed_s[0] = 24 * 3600.0
    assert time.is_over(until)


def test_a_service_that_starts_in_1970_goes_on_from_its_newest_record():
    time = SteadyTime(NOON.isoformat(), lambda: datetime(1970, 1, 1, tzinfo=UTC), lambda: 0.0)

    assert time.now() == NOON
    assert not time.is_over(None)


def test_a_device_stands_on_no_rung():
    assert not reaches(Role.DEVICE, Role.VIEWER)
    assert not reaches(Role.DEVICE, Role.PLANT)
    assert not reaches(Role.ADMINISTRATOR, Role.DEVICE)
    assert reaches(Role.DEVICE, Role.DEVICE)
    assert [reaches(Role.OPERATOR, least) for least in Role] == [True, True, False, False, False, False]
    assert lesser(Role.DEVICE, Role.ADMINISTRATOR) is Role.DEVICE
    assert lesser(Role.METROLOGIST, Role.VIEWER) is Role.VIEWER
