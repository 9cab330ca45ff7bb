"""The service as a process: ready in one line, refused in one sentence, ended in order."""

import contextlib
import http.client
import json
import logging
import os
import re
import signal
import socket
import sqlite3
import subprocess
import sys
import time
from asyncio.constants import ACCEPT_RETRY_DELAY
from dataclasses import replace
from pathlib import Path
from urllib.parse import urlsplit

import httpx
import pytest

from tests.helpers.web.clients import prompt_id
from tests.integration.web.bench import CELL
from truepose.app import serve
from truepose.app.server import _listening, _url
from truepose.messages.error_codes import CODES
from truepose.settings import Settings
from truepose.storage.database import Database
from truepose.storage.secret_files import service_of

CODED = re.compile(r" \[(TP-\d{4})\]\n$")
PATIENCE_S = 120  # with a process that starts or ends, on a busy machine
SERVE = """
import sys
from pathlib import Path
from truepose.start import begin_lightly, end_lightly

begin_lightly()  # as `truepose serve` does

from truepose.app import serve
from truepose.settings import Settings

cell_file = Path(sys.argv[3]) if len(sys.argv) > 3 else None
status = serve(Settings(sys.argv[1], port=int(sys.argv[2]), cell_file=cell_file, simulated_pace=0))
end_lightly()
sys.exit(status)
"""


def start(database_url, port=0, *cell_file, script=SERVE):
    return subprocess.Popen(
        [sys.executable, "-c", script, database_url, str(port), *map(str, cell_file)],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )


@contextlib.contextmanager
def started(database_url):
    process = start(database_url)
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.fixture(scope="module")
def standing(tmp_path_factory):
    """A service that all tests ask that do not end it: its process, where it is, and its database."""
    database_url = f"sqlite:///{tmp_path_factory.mktemp('standing')}/truepose.sqlite3"
    with started(database_url) as process:
        yield process, url_of(process), database_url


@pytest.fixture(scope="module")
def resting(standing):
    """A connection that has been asked once, and the moment; it rests while other tests run."""
    connection = http.client.HTTPConnection(urlsplit(standing[1]).netloc)
    connection.request("GET", "/health")
    connection.getresponse().read()
    yield connection, time.monotonic()
    connection.close()


def get(url):
    return httpx.get(url, timeout=PATIENCE_S)


def post(url, json=None):
    return httpx.post(url, json=json, timeout=PATIENCE_S)


def url_of(service):
    line = service.stdout.readline()
    assert line, service.stderr.read()
    return json.loads(line)["url"]


def ended(process):
    """Return exit status, what is left of standard output, and standard error."""
    out, err = process.communicate(timeout=PATIENCE_S)
    return process.returncode, out, err


@pytest.fixture
def refused(monkeypatch, capsys):
    """Start a service that fails in this process; gives status, standard output and standard error.

    Each refusal ends with a code that can be quoted.
    """
    everything = logging.getLogger()
    level = everything.level
    monkeypatch.setattr(everything, "handlers", [])

    def start_here(settings):
        status = serve(settings)
        out, err = capsys.readouterr()
        assert CODED.search(err)[1] in CODES, err
        return status, out, err

    yield start_here
    everything.setLevel(level)


def given(url):
    return get(f"{url}/api/v1/simulated-faults").json()["faults"]


def test_an_engineer_gives_and_ends_a_fault_while_the_service_runs(standing, resting):
    _, url, _ = standing
    faults = f"{url}/api/v1/simulated-faults"
    wanted = {"person": "Ada", "kind": "smr_missing", "keys": {"nest": 2.0}}

    number = post(faults, json=wanted).json()["number"]
    refused = post(faults, json={**wanted, "keys": {"nest": 9}})
    (active,) = given(url)
    post(f"{faults}/{number}/end", json={"person": "Ada"})
    (over,) = given(url)

    assert (active["kind"], active["keys"], active["person"]) == ("smr_missing", {"nest": 2}, "Ada")
    assert (active["state"], over["state"]) == ("active", "over")
    assert refused.status_code == 422
    assert refused.json()["detail"] == 'The cell refused this: key "nest" must be 1 to 3, not 9.'
    assert "Reflector missing" in get(f"{url}/faults").text


def test_without_a_cell_file_it_says_on_every_page_that_all_is_simulated(standing):
    _, url, _ = standing

    assert get(f"{url}/health").json()["simulated"] is True
    for page in ("/", "/docs"):
        text = get(url + page).text
        assert "This service runs a simulated cell." in text
        elsewhere = re.findall(r"https?://(?!localhost[:/])[^\s\"<&]+", text.replace(url, ""))
        assert elsewhere == [], "a shop floor has no content network"


def test_the_body_of_an_answer_does_not_wait_for_the_acknowledgement_of_its_head():
    with _listening("127.0.0.1", 0) as listener, socket.create_connection(listener.getsockname()):
        accepted, _ = listener.accept()
        with accepted:
            assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


@pytest.mark.skipif(sys.platform != "linux", reason="the option is Linux's")
def test_a_connection_ends_whose_other_side_acknowledges_nothing():
    with _listening("127.0.0.1", 0) as listener, socket.create_connection(listener.getsockname()):
        accepted, _ = listener.accept()
        with accepted:
            assert accepted.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 30_000


def test_an_address_that_stands_for_all_is_told_as_one_that_answers():
    with _listening("0.0.0.0", 0) as listener:
        assert _url(listener, "http") == f"http://127.0.0.1:{listener.getsockname()[1]}"


def test_a_host_that_is_none_is_one_sentence_and_status_2(refused):
    status, _, err = refused(Settings(allowed_hosts=("cell3:8000",)))

    assert (status, err.count("\n")) == (2, 1)
    assert err.startswith("'cell3:8000' cannot be an allowed host")


def assert_ends_in_order(service, url, database_url, number):
    """A signal ends the service, its cell, and what commands of this machine know of it."""
    (cell,) = get(f"{url}/api/v1/cells").json()
    port = cell["endpoints"][0]["port"]
    database = Path(database_url.removeprefix("sqlite:///"))
    told = service_of(database)

    service.send_signal(number)
    status, out, err = ended(service)

    assert (status, out) == (0, ""), err
    assert told.url == url
    assert service_of(database) is None  # commands of this machine ask nobody any more
    assert "Traceback" not in err
    with pytest.raises(ConnectionRefusedError):
        socket.create_connection(("127.0.0.1", port), timeout=1)
    return err


def test_more_silent_connections_than_there_are_descriptors_keep_nobody_out_and_an_interrupt_ends_it(
    database_url,
):
    few = "import resource; resource.setrlimit(resource.RLIMIT_NOFILE, (200, 200))\n"
    service = start(database_url, script=few + SERVE)
    with contextlib.ExitStack() as crowd:
        crowd.callback(service.kill)
        url = url_of(service)
        address = ("127.0.0.1", int(url.rpartition(":")[2]))
        for _ in range(300):
            crowd.enter_context(socket.create_connection(address, timeout=60))
        answers = [get(f"{url}/health").status_code for _ in range(5)]
        time.sleep(1.5 * ACCEPT_RETRY_DELAY)  # asyncio complains of a listener that is closed before
        err = assert_ends_in_order(service, url, database_url, signal.SIGINT)

    assert answers == [200] * 5
    assert err.count("\n") < 10, err


def assert_no_stream_holds_up_the_end(service, url, database_url):
    with httpx.stream("GET", f"{url}/api/v1/events", timeout=60) as stream:
        lines = stream.iter_lines()
        next(lines)
        err = assert_ends_in_order(service, url, database_url, signal.SIGTERM)
        # A stream that had to be cut breaks off in the middle of a chunk, which httpx reports; this one ends.
        assert [line for line in lines if line.startswith("data")] == []

    assert "Cancel" not in err  # Uvicorn's word for requests that it waited for in vain


def test_a_second_service_on_the_same_database_is_one_sentence_and_status_3(standing, refused):
    _, _, database_url = standing

    status, out, err = refused(Settings(database_url, port=0))

    assert (status, out) == (3, "")
    assert "in use by another truepose service" in err
    assert "Traceback" not in err


def test_a_request_arrives_on_a_connection_that_a_client_has_kept_for_as_long_as_most_do(resting):
    connection, since_s = resting
    kept = connection.sock

    time.sleep(max(0.0, since_s + 5.3 - time.monotonic()))  # httpx keeps one for 5 s
    connection.request("GET", "/health")

    assert connection.getresponse().status == 200
    assert connection.sock is kept


def test_a_simulated_cell_that_ended_is_told_and_not_started_anew(standing):
    """The last that asks the service, which has no cell afterwards."""
    service, url, _ = standing
    children = Path(f"/proc/{service.pid}/task/{service.pid}/children").read_text(encoding="utf-8").split()
    os.kill(
        int(children[0]), signal.SIGKILL
    )  # the cell: what draws pages and looks after records comes later

    for _ in range(400):
        health = get(f"{url}/health").json()
        if health["status"] != "ok":
            break
        time.sleep(0.05)

    assert health["status"] == "degraded"
    assert health["fault"] == "The simulated cell has ended with status -9; restart the service."
    assert get(f"{url}/api/v1/simulated-faults").status_code == 503
    assert "The simulated cell does not answer." in get(f"{url}/faults").text
    refused = post(f"{url}/api/v1/devices/tracker/connect")
    assert refused.status_code == 503


def test_a_port_in_use_is_one_sentence_and_status_3(database_url, refused):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        status, out, err = refused(Settings(database_url, port=port))

    assert (status, out) == (3, "")
    assert err.startswith(
        f"Another program is listening at 127.0.0.1:{port}: stop it, or choose another --port."
    )
    assert err.endswith(" [TP-7003]\n")
    assert err.count("\n") == 1


def test_a_cell_file_with_a_mistake_is_one_sentence_and_status_2(database_url, tmp_path, refused):
    (tmp_path / "cell.toml").write_text(CELL.replace("centre_mm", "center_mm"))

    status, out, err = refused(Settings(database_url, port=0, cell_file=tmp_path / "cell.toml"))

    assert (status, out) == (2, "")
    assert err.startswith("cell.toml")
    assert err.count("\n") == 1


def test_faults_on_order_are_for_simulated_cells(database_url, tmp_path, refused):
    (tmp_path / "cell.toml").write_text(CELL)
    cell = Settings(database_url, port=0, cell_file=tmp_path / "cell.toml")

    status, out, err = refused(replace(cell, simulated_faults=tmp_path / "morning.toml"))

    assert (status, out) == (2, "")
    assert "faults can be scripted only in a simulated cell" in err
    assert err.count("\n") == 1


def test_a_driver_that_is_not_installed_is_one_sentence_and_status_3(database_url, tmp_path, refused):
    (tmp_path / "cell.toml").write_text(CELL)

    status, out, err = refused(Settings(database_url, port=0, cell_file=tmp_path / "cell.toml"))

    assert (status, out) == (3, "")
    assert "'fake_tracker'" in err
    assert err.count("\n") == 1


def test_a_newer_schema_is_one_sentence_and_status_3(database_url, tmp_path, refused):
    Database(database_url).close()
    with sqlite3.connect(tmp_path / "truepose.sqlite3") as connection:
        connection.execute("UPDATE alembic_version SET version_num = '9999'")
    connection.close()

    status, _, err = refused(Settings(database_url, port=0))

    assert status == 3
    assert "has schema 9999" in err
    assert "Traceback" not in err


def test_a_service_killed_in_a_session_lets_go_of_its_database_and_finds_it_awaiting_a_person(database_url):
    with (
        started(database_url) as service,  # and killed
        httpx.Client(base_url=url_of(service), timeout=PATIENCE_S) as client,
    ):
        joints = [[5.0 * k, 40.0, -30.0, 5.0 * k, 30.0, 0.0] for k in range(-18, 18)]
        stops = [{"config": k, "joints_deg": q, "nest": 1} for k, q in enumerate(joints, 1)]
        wanted = {"name": "a", "role": "calibration", "plan": {"method": "given", "stops": stops}}
        client.post("/api/v1/sessions", json=wanted).raise_for_status()
        path = "/api/v1/sessions/1"
        for command in ("start", "confirm"):
            asked = prompt_id(client.get(f"{path}/situation").json())
            said = {"command": command, "person": "Ada", "prompt_id": asked}
            client.post(f"{path}/commands", json=said).raise_for_status()
        acknowledged = readings_until(client, 12)

    with started(database_url) as second:
        url = url_of(second)
        found = get(f"{url}/api/v1/sessions/1").json()
        kept = get(f"{url}/api/v1/sessions/1/readings").json()
        assert_no_stream_holds_up_the_end(second, url, database_url)

    assert found["state"] == "awaiting_confirmation"
    assert "restarted" in found["reason"]
    assert [reading["id"] for reading in kept][: len(acknowledged)] == acknowledged


def readings_until(client, count):
    """Return the numbers of the first readings that the session tells of."""
    found = []
    with client.stream("GET", "/api/v1/events", params={"session_id": 1}) as stream:
        for line in stream.iter_lines():
            if line.startswith("data: ") and "reading_id" in line:
                found.append(json.loads(line.removeprefix("data: "))["reading_id"])
                if len(found) == count:
                    break
    return found


def test_the_service_is_ready_without_the_libraries_of_the_worker_and_of_migrations():
    unwanted = {"scipy", "matplotlib", "plotly", "alembic"}
    script = f"import sys, truepose.app; print(sorted({unwanted} & set(sys.modules)))"

    found = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)

    assert found.stdout.strip() == "[]"
