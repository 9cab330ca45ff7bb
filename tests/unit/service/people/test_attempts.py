"""How often it may be tried: bounded over days, whatever addresses a stranger has."""

import contextlib
from types import SimpleNamespace

import pytest

from truepose.domain.people import Person, Role
from truepose.people.attempts import FROM_ALL_ADDRESSES, GUESSES, Attempts, address_block
from truepose.people.errors import TooManyGuessesError
from truepose.people.steady_time import SteadyTime

ADA = Person(1, "Ada Byron", Role.OPERATOR)
DAY_S = 24 * 3600


@pytest.fixture
def now_s():
    return [0.0]


@pytest.fixture
def attempts(now_s):
    time = SteadyTime(elapsed_s=lambda: now_s[0])
    return Attempts(SimpleNamespace(time=time, places=()))


def guesses(attempts, address):
    """Whether a wrong password is looked at."""
    try:
        with attempts.at_door(ADA, ADA.name, address):
            raise ValueError
    except TooManyGuessesError:
        return False
    except ValueError:
        return True


def test_a_day_of_guesses_from_everywhere_is_bounded_for_an_account(attempts, now_s):
    looked_at = 0
    for k in range(DAY_S // 20):
        now_s[0] = 20.0 * k
        looked_at += guesses(attempts, f"198.{k // 65536}.{k // 256 % 256}.{k % 256}")

    assert looked_at <= FROM_ALL_ADDRESSES.at_once + DAY_S / FROM_ALL_ADDRESSES.refill_s
    assert not guesses(attempts, "203.0.113.9")


def test_where_somebody_signed_in_within_a_month_strangers_do_not_count(attempts, now_s):
    attempts.places.note(ADA.id, "192.168.1.10")
    for k in range(100):
        guesses(attempts, f"198.51.100.{k}")

    now_s[0] = 29.0 * DAY_S
    for k in range(100):
        guesses(attempts, f"198.51.101.{k}")
    with attempts.at_door(ADA, ADA.name, "192.168.1.10"):
        pass
    now_s[0] = 31.0 * DAY_S
    for k in range(100):
        guesses(attempts, f"198.51.102.{k}")
    with pytest.raises(TooManyGuessesError), attempts.at_door(ADA, ADA.name, "192.168.1.10"):
        pass


def test_a_known_place_has_a_limit_of_its_own(attempts):
    attempts.places.note(ADA.id, "192.168.1.10")

    assert [guesses(attempts, "192.168.1.10") for _ in range(7)] == [True] * 5 + [False] * 2


def test_ever_new_names_from_one_address_have_nobody_s_count_forgotten(attempts, monkeypatch):
    monkeypatch.setattr("truepose.people.attempts._REMEMBERED", 20)
    attempts.places.note(ADA.id, "192.168.1.10")
    while guesses(attempts, "192.168.1.10"):
        pass

    for k in range(100):
        with (
            contextlib.suppress(TooManyGuessesError, ValueError),
            attempts.at_door(None, f"Person {k}", "203.0.113.9"),
        ):
            raise ValueError

    assert not guesses(attempts, "192.168.1.10")


def test_who_goes_on_guessing_is_not_forgotten_behind_others(attempts, monkeypatch):
    monkeypatch.setattr("truepose.people.attempts._REMEMBERED", 20)
    for _ in range(GUESSES):
        attempts.guesses.take("account 1")

    looked_at = 0
    for k in range(100):
        attempts.guesses.take(f"address 198.51.100.{k}")
        with contextlib.suppress(TooManyGuessesError):
            attempts.guesses.take("account 1")
            looked_at += 1

    assert looked_at == 0


def test_places_and_tablets_of_long_ago_are_forgotten(attempts, now_s):
    for k in range(5):
        attempts.places.note(ADA.id, f"192.168.1.{k}")
        attempts.pins.note_stood(ADA.id, k)
        attempts.pins.note_wrong(ADA.id, k)
    attempts.pins.note_wrong(ADA.id, 99)  # where nobody stood

    now_s[0] = 31.0 * DAY_S
    attempts.places.note(ADA.id, "192.168.1.9")
    attempts.pins.forget_others({4})

    assert len(attempts.places._until) == 1
    assert attempts.pins._stood == {(ADA.id, 4)}
    assert attempts.pins._wrong == {(ADA.id, 4): 1, (ADA.id, None): 1}


@pytest.mark.parametrize(
    ("address", "block"),
    [
        ("192.168.1.10", "192.168.1.10"),
        ("::ffff:192.168.1.10", "192.168.1.10"),
        ("2001:db8:1:2:3:4:5:6", "2001:db8:1:2::/64"),
        ("fe80::1%eth0", "fe80::/64"),
        ("", ""),
        ("a proxy's word", "a proxy's word"),
    ],
)
def test_what_of_an_address_tells_networks_apart(address, block):
    assert address_block(address) == block
