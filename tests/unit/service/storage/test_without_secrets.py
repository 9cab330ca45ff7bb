"""What may open something stays in the cell, however its option is called; what opens nothing leaves."""

import json
from importlib.metadata import entry_points

import pytest

from truepose.storage.plant.outbox import without_secrets

CANARY = "canary-7f3a"


def options_told(**options):
    """Return the options of a device as they leave."""
    setup = {"cell": {"devices": [{"name": "robot", "options": options}]}}
    told = without_secrets({"id": 1, "setup": json.dumps(setup)})
    return json.loads(told["setup"])["cell"]["devices"][0]["options"]


@pytest.mark.parametrize(
    "name",
    [
        "password",
        "passwd",
        "Password",
        "pass_word",
        "controller_password",
        "controllerPassword",
        "api_key",
        "apikey",
        "PIN",
        "robot-pin",
        "user",
        "community",  # of another program's driver: nobody here knows what it opens
    ],
)
def test_what_may_open_a_device_is_taken_out(name):
    told = options_told(**{name: CANARY, "host": "r1", "port": 700, "reversed": True})

    assert told == {name: "taken out", "host": "r1", "port": 700, "reversed": True}


@pytest.mark.parametrize("name", ["pin", "robot_pin", "pass", "token"])
def test_a_number_under_such_a_name_is_taken_out(name):
    assert options_told(**{name: 1234}) == {name: "taken out"}


@pytest.mark.parametrize(
    ("written", "told"),
    [
        ("http://ada:canary-7f3a@10.0.0.1:80", "http://10.0.0.1:80"),
        ("http://ada:canary@7f3a/x@10.0.0.1", "http://10.0.0.1"),
        ("ada:canary-7f3a@10.0.0.1", "10.0.0.1"),
        ("socket://10.0.0.1:4001", "socket://10.0.0.1:4001"),
        ("0fe7:4001", "0fe7:4001"),
    ],
)
def test_user_and_password_are_taken_out_of_an_address(written, told):
    assert options_told(host=written) == {"host": told}


def test_what_opens_something_is_taken_out_wherever_it_stands_in_a_set_up():
    setup = {"cell": {"further": [{"login": {"password": CANARY}}, f"see https://ada:{CANARY}@c/x"]}}

    told = json.loads(without_secrets({"id": 1, "setup": json.dumps(setup)})["setup"])

    assert told == {"cell": {"further": [{"login": {"password": "taken out"}}, "see https://c/x"]}}


@pytest.mark.parametrize(
    "setup",
    [
        '{ "cell" : {"devices": []} }',
        '{"robot_key": "a", "passes": 2, "spindle": "s", "options": {"host": "r1", "port": 7}}',
    ],
)
def test_a_set_up_without_a_secret_leaves_as_it_was_kept(setup):
    row = {"id": 1, "setup": setup}

    assert without_secrets(row) is row


def test_of_the_shipped_drivers_texts_that_open_a_controller_stay_and_no_others():
    staying = set()
    for entry in entry_points(group="truepose.drivers"):
        told = options_told(**dict.fromkeys(entry.load().options, "1 text"))
        staying |= {name for name, value in told.items() if value == "taken out"}

    numbers = {name for name in staying if name.endswith(("port", "_mm"))} | {"baud", "decimals"}
    assert staying - numbers == {"user", "password"}
