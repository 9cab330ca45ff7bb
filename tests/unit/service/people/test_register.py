"""Changes that meet: each is judged by what there is when it is made, and what the disk refuses is owed."""

import asyncio
import contextlib
import itertools
from dataclasses import replace

import pytest

from tests.helpers.machine import HANGS_S
from truepose.domain.people import Person, Role
from truepose.people.errors import AccountRefusedError, SignInRefusedError, UnknownPersonError
from truepose.people.register import Register
from truepose.people.steady_time import SteadyTime
from truepose.storage.errors import StorageUnavailableError
from truepose.storage.people import CredentialKind, CredentialRecord, EnteredPeople, NewCredential

ADA = Person(1, "Ada Byron", Role.ADMINISTRATOR)
GRACE = Person(2, "Grace Hopper", Role.ADMINISTRATOR)


class Disk:
    """Keeps people and credentials in memory; holds writes or refuses them where it is told to."""

    def __init__(self, *people):
        self.people = {person.id: person for person in people}
        self.credentials = {}
        self.numbers = itertools.count(1)
        self.open = asyncio.Event()
        self.open.set()
        self.full = False

    async def entered(self):
        return EnteredPeople(tuple(self.people.values()), tuple(self.credentials.values()), None, ())

    async def enter(self, name, role, by, new=()):
        await self._write()
        person = Person(len(self.people) + 1, name, role)
        self.people[person.id] = person
        return person, self._add([replace(one, person_id=person.id) for one in new])

    async def change(self, person, by, new=(), gone=()):
        await self._write()
        self.people[person.id] = person
        return self._exchange(new, gone)

    async def exchange(self, new, gone, by):
        await self._write()
        return self._exchange(new, gone)

    async def revoke(self, numbers, by):
        await self.exchange((), numbers, by)

    async def _write(self):
        await self.open.wait()
        if self.full:
            raise StorageUnavailableError("The disk is full.")

    def _exchange(self, new, gone):
        for number in gone:
            self.credentials.pop(number, None)
        return self._add(new)

    def _add(self, new):
        records = tuple(
            CredentialRecord(
                next(self.numbers), "", one.kind, one.person_id, one.hash, one.expires_at, one.document
            )
            for one in new
        )
        self.credentials |= {record.id: record for record in records}
        return records


@pytest.fixture
def disk():
    return Disk(ADA, GRACE)


@pytest.fixture
async def register(disk):
    loaded = Register(disk)
    await loaded.load()
    return loaded


async def met(disk, *changes):
    """Return how changes end that all begin while the disk holds the first one's write."""
    disk.open.clear()
    tasks = [asyncio.create_task(change) for change in changes]
    await asyncio.sleep(0)
    disk.open.set()
    async with asyncio.timeout(HANGS_S):
        return await asyncio.gather(*tasks, return_exceptions=True)


def sign_in(person, kept="a browser"):
    return NewCredential(CredentialKind.SIGN_IN, person.id, kept)


async def test_a_new_role_brings_nobody_back_who_is_removed_meanwhile(disk, register):
    _, found = await met(
        disk, register.remove(GRACE, "Ada"), register.change_role(GRACE, Role.OPERATOR, "Ada")
    )

    assert isinstance(found, UnknownPersonError)
    assert disk.people[GRACE.id] == replace(GRACE, active=False)


async def test_two_who_demote_each_other_leave_an_administrator(disk, register):
    _, found = await met(
        disk,
        register.change_role(ADA, Role.VIEWER, "Grace"),
        register.change_role(GRACE, Role.VIEWER, "Ada"),
    )

    assert isinstance(found, AccountRefusedError)
    assert [person.role for person in disk.people.values()] == [Role.VIEWER, Role.ADMINISTRATOR]


async def test_an_older_view_of_the_last_administrator_does_not_remove_them(disk, register):
    await register.remove(GRACE, "Ada")

    with pytest.raises(AccountRefusedError):
        await register.remove(replace(ADA, role=Role.OPERATOR), "Ada")


async def test_nothing_is_opened_for_whoever_is_removed_meanwhile(disk, register):
    _, found = await met(disk, register.remove(GRACE, "Ada"), register.keep(sign_in(GRACE)))
    await register.enter(GRACE.name, Role.VIEWER, "Ada")

    assert isinstance(found, SignInRefusedError)
    assert register.credentials == ()


async def test_a_sign_in_by_a_password_that_is_changed_meanwhile_is_none(disk, register):
    old, new = (NewCredential(CredentialKind.PASSWORD, ADA.id, kept) for kept in ("old", "new"))
    (shown,) = await register.put(ADA, [old], by="Ada")

    _, found = await met(
        disk,
        register.put(ADA, [new], ends=[CredentialKind.SIGN_IN], by="Ada"),
        register.keep(sign_in(ADA), resting_on=[shown.id]),
    )

    assert isinstance(found, SignInRefusedError)
    assert [record.hash for record in register.credentials] == ["new"]


async def test_a_sign_in_that_is_kept_before_the_password_is_changed_ends_with_it(disk, register):
    new = NewCredential(CredentialKind.PASSWORD, ADA.id, "new")

    await met(
        disk,
        register.keep(sign_in(ADA)),
        register.put(ADA, [new], ends=[CredentialKind.SIGN_IN], by="Ada"),
    )

    assert [record.hash for record in register.credentials] == ["new"]


async def test_a_badge_that_two_choose_at_once_is_one_person_s(disk, register):
    chosen = [
        register.put(p, [NewCredential(CredentialKind.BADGE, p.id, "badge")], by="") for p in (ADA, GRACE)
    ]

    first, second = await met(disk, *chosen)

    assert [record.person_id for record in first] == [ADA.id]
    assert isinstance(second, AccountRefusedError)


async def test_of_two_first_persons_one_is_entered():
    disk = Disk()
    register = Register(disk)
    password = NewCredential(CredentialKind.PASSWORD, None, "kept")

    first, second = await met(
        disk, register.enter_first("Ada", password), register.enter_first("Eve", password)
    )

    assert (first.name, [one.name for one in disk.people.values()]) == ("Ada", ["Ada"])
    assert isinstance(second, SignInRefusedError)


async def test_a_full_disk_enters_no_first_person_who_could_not_come_in():
    disk = Disk()
    register = Register(disk)
    disk.full = True
    with pytest.raises(StorageUnavailableError):
        await register.enter_first("Ada", NewCredential(CredentialKind.PASSWORD, None, "kept"))
    disk.full = False

    ada = await register.enter_first("Ada", NewCredential(CredentialKind.PASSWORD, None, "kept"))

    assert [record.hash for record in register.of(ada.id, CredentialKind.PASSWORD)] == ["kept"]


async def test_a_full_disk_leaves_the_secret_that_was_to_be_replaced(disk, register):
    old, new = (NewCredential(CredentialKind.PASSWORD, ADA.id, kept) for kept in ("old", "new"))
    await register.put(ADA, [old], by="Ada")
    disk.full = True

    with pytest.raises(StorageUnavailableError):
        await register.put(ADA, [new], by="Ada")

    assert [record.hash for record in register.of(ADA.id, CredentialKind.PASSWORD)] == ["old"]


async def test_what_is_revoked_while_the_disk_is_full_is_on_record_once_it_is_not(disk, register):
    browser = await register.keep(sign_in(ADA))
    disk.full, writable = True, asyncio.Event()
    following = asyncio.create_task(register.follow(writable.wait))
    with pytest.raises(StorageUnavailableError):
        await register.revoke(browser.id, by="Ada")
    opened = register.credential(browser.id)

    disk.full = False
    writable.set()
    async with asyncio.timeout(HANGS_S):
        while disk.credentials:
            await asyncio.sleep(0)
    following.cancel()
    with contextlib.suppress(asyncio.CancelledError):
        await following

    assert opened is None
    assert disk.credentials == {}


async def test_what_has_expired_is_forgotten(disk, register):
    now_s = [0.0]
    register.time = SteadyTime(elapsed_s=lambda: now_s[0])
    for n in range(3):
        await register.keep(replace(sign_in(ADA, f"browser {n}"), expires_at=register.time.in_future(1)))

    now_s[0] = 2 * 24 * 3600.0
    await register.keep(sign_in(ADA, "the last one"))

    assert [record.hash for record in register._credentials.values()] == ["the last one"]
    assert [kept for _, kept in register._by_hash] == ["the last one"]
