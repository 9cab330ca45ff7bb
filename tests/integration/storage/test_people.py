"""People and what opens the service to them: superseded and revoked, never changed."""

import pytest

from truepose.domain.people import Person, Role
from truepose.storage.people import (
    ActRepository,
    CredentialKind,
    CredentialRepository,
    NewCredential,
    PersonsAct,
)
from truepose.storage.records import Page


async def test_nobody_is_entered_at_first(database):
    entered = await CredentialRepository(database).entered()

    assert (entered.people, entered.credentials, entered.newest) == ((), (), None)


async def test_the_newest_state_of_a_person_counts(database):
    stored = CredentialRepository(database)
    ada, _ = await stored.enter("Ada", Role.OPERATOR, "Grace")
    grace, _ = await stored.enter("Grace", Role.ADMINISTRATOR, "Grace")

    await stored.change(Person(ada.id, "Ada", Role.METROLOGIST), "Grace")
    await stored.change(Person(grace.id, "Grace", Role.ADMINISTRATOR, active=False), "Ada")

    assert (await stored.entered()).people == (
        Person(ada.id, "Ada", Role.METROLOGIST),
        Person(grace.id, "Grace", Role.ADMINISTRATOR, active=False),
    )


async def test_what_was_revoked_opens_nothing(database):
    stored = CredentialRepository(database)
    ada, _ = await stored.enter("Ada", Role.OPERATOR, "Grace")
    token = NewCredential(CredentialKind.TOKEN, ada.id, "abc", None, {"name": "line"})
    kept, gone = await stored.exchange([token, NewCredential(CredentialKind.PIN, ada.id, "def")], (), "Grace")

    await stored.revoke((gone.id,), "Grace")

    assert (await stored.entered()).credentials == (kept,)


@pytest.fixture
async def acts(database):
    stored = ActRepository(database)
    names = ["Ada", "Grace", "Ada"]
    await stored.add([
        PersonsAct("2026-05-04T09:00:00+00:00", "start_session", f"/api/v1/sessions/{n}/start", 202, name)
        for n, name in enumerate(names)
    ])
    return stored


async def test_acts_are_found_by_what_stands_in_them(acts):
    assert [record.id for record in await acts.page(Page(), "ada")] == [1, 3]
    assert [record.id for record in await acts.newest(3, 5)] == [2, 1]
    assert await acts.count("sessions/1") == 1
    assert await acts.count("100%") == 0
