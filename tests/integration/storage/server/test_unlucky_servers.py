"""What administrators and others' programs do to a server: one sentence, nothing lost, and on it goes."""

import asyncio
import os

import psycopg
import pytest

from tests.helpers.storage.sessions import add, names
from truepose.storage.database import Database
from truepose.storage.engine.postgresql_connections import translate_error
from truepose.storage.engine.postgresql_server import require_fit
from truepose.storage.errors import ServerAwayError, ServerRefusedError
from truepose.storage.integrity.verification import verify_left_at

pytestmark = pytest.mark.engine("postgresql")
PATIENCE_S = 120


@pytest.fixture
def administrator(server, name):
    with server.connect(name) as connection:
        yield connection.execute


async def test_limits_on_time_that_are_set_for_others_end_nothing_here(database_url, administrator, name):
    for limit in ("statement_timeout", "idle_in_transaction_session_timeout", "idle_session_timeout"):
        administrator(f'ALTER DATABASE "{name}" SET {limit} = 200')
    database = Database(database_url)

    def slow(connection):
        connection.exec_driver_sql("SELECT pg_sleep(0.3)")

    await database.write(slow)
    await asyncio.sleep(0.3)  # idle
    assert await add(database) == 1
    await database.read(slow)
    assert database.condition.fault is None
    database.close()
    assert verify_left_at(database_url).findings == ()


async def test_a_server_that_takes_no_writes_is_said_to_and_waited_for(database, administrator, name):
    def fail_over(change):
        administrator(f'ALTER DATABASE "{name}" {change}')
        administrator(
            "SELECT pg_terminate_backend(pid) FROM pg_stat_activity "
            "WHERE datname = current_database() AND pid <> pg_backend_pid()"
        )

    await add(database)
    fail_over("SET default_transaction_read_only = on")
    async with asyncio.timeout(PATIENCE_S):
        with pytest.raises(ServerRefusedError, match=r"is read-only .*; it is a standby"):
            while True:
                await add(database, "meanwhile")
    kept = await names(database)
    await asyncio.sleep(0.6)  # two trials, which write nothing that such a server refuses
    assert "is read-only" in database.condition.trouble
    with pytest.raises(ServerRefusedError, match="is read-only"):
        await add(database, "refused")
    fail_over("RESET default_transaction_read_only")
    await asyncio.wait_for(database.writable(), PATIENCE_S)
    await add(database, "last")

    assert await names(database) == [*kept, "last"]


def test_a_service_does_not_start_on_a_server_that_takes_no_writes(database_url, administrator, name):
    administrator(f'ALTER DATABASE "{name}" SET default_transaction_read_only = on')

    with pytest.raises(ServerRefusedError, match="is read-only"):
        Database(database_url)


@pytest.fixture
def user(server):
    """Somebody who may connect to an empty database, and nothing else; the address with that name."""
    name = f"theirs_{os.getpid()}"
    url = server.make(name, "template1")
    with server.connect() as administrator:
        administrator.execute(f"CREATE ROLE {name} LOGIN")
    yield url.replace("//postgres@", f"//{name}@")
    server.drop(name)
    with server.connect() as administrator:
        administrator.execute(f"DROP ROLE {name}")


async def test_who_may_make_no_tables_is_told_what_is_missing(server, beside, user):
    name = f"theirs_{os.getpid()}"
    with pytest.raises(ServerRefusedError, match=r"permission denied for schema.*owner of its schema"):
        Database(user)
    with server.connect() as administrator:
        administrator.execute(f"ALTER DATABASE {name} OWNER TO {name}")

    database = Database(user)
    await add(database)
    with server.connect() as administrator:
        administrator.execute(f"ALTER ROLE {name} CONNECTION LIMIT 1")
    with pytest.raises(ServerRefusedError, match=r"too many connections.*close other connections to it"):
        await names(database)
    await add(database, "second")  # over the connection that there is
    with server.connect() as administrator:
        administrator.execute(f"ALTER ROLE {name} CONNECTION LIMIT -1")

    assert await names(database) == ["first", "second"]
    database.close()


@pytest.mark.parametrize("encoding", ["LATIN1", "SQL_ASCII"])
def test_a_database_that_does_not_keep_every_text_is_refused_and_untouched(server, beside, encoding):
    name = f"narrow_{os.getpid()}"
    with server.connect() as administrator:
        administrator.execute(f"CREATE DATABASE {name} TEMPLATE template0 ENCODING '{encoding}' LOCALE 'C'")
    try:
        with pytest.raises(ServerRefusedError, match=f"encoding {encoding}.*ENCODING 'UTF8'"):
            Database(server.url(name))
        with server.connect(name) as administrator:
            tables = administrator.execute("SELECT count(*) FROM pg_tables WHERE schemaname = 'public'")
            assert tables.fetchone() == (0,)
    finally:
        server.drop(name)


class _Answering:
    """A server of an earlier version, as far as it is asked."""

    def execute(self, _query):
        return self

    def fetchone(self):
        return 120022, "12.22", "UTF8", "public"


def test_a_server_that_is_too_old_is_refused():
    with pytest.raises(ServerRefusedError, match=r"is PostgreSQL 12\.22; use 13 or newer"):
        require_fit(_Answering(), "db")


@pytest.mark.parametrize(
    ("said", "kind", "to_do"),
    [
        ("connection refused", ServerAwayError, "check that it is running"),
        ("FATAL: sorry, too many clients already", ServerRefusedError, "raise max_connections"),
        ("FATAL: remaining connection slots are reserved", ServerRefusedError, "raise max_connections"),
        ('FATAL: password authentication failed for user "ada"', ServerRefusedError, "PGPASSWORD"),
        ("fe_sendauth: no password supplied", ServerRefusedError, "PGPASSWORD"),
        ('FATAL: no pg_hba.conf entry for host "10.0.0.7"', ServerRefusedError, "pg_hba.conf"),
        ("server does not support SSL, but SSL was required", ServerRefusedError, "set ssl = on"),
        ("SSL error: certificate verify failed", ServerRefusedError, "sslrootcert"),
        ('FATAL: database "trupose" does not exist', ServerRefusedError, "another with --database"),
        ("FATAL: Passwort-Authentifizierung fehlgeschlagen", ServerAwayError, "accepts this service"),
    ],
)
def test_who_is_not_let_in_is_told_what_to_do(said, kind, to_do):
    found = translate_error("db", psycopg.OperationalError(f"connection failed: {said}"))

    assert type(found) is kind
    assert said in str(found)
    assert to_do in str(found)
