"""Our modules for ABB controllers say the same as the codecs; nobody here can run them."""

import re
from pathlib import Path

import pytest

from truepose_drivers.abb_egm import reader
from truepose_drivers.abb_open_abb import protocol
from truepose_drivers.abb_rws import protocol as web
from truepose_drivers.abb_rws.protocol import Order, Progress, Report

DRIVERS = Path(protocol.__file__).parents[1]
MODULES = {path.stem: path.read_text() for path in DRIVERS.glob("abb_*/controller/*.mod")}
SERVER, RWS, EGM = (MODULES[f"TruePose{name}"] for name in ("Server", "Rws", "Egm"))
STATES = {
    "WAITING": Progress.IDLE,
    "TAKEN": Progress.TAKEN,
    "MOVING": Progress.MOVING,
    "ARRIVED": Progress.ARRIVED,
    "GIVEN_UP": Progress.GIVEN_UP,
    "REFUSED": Progress.REFUSED,
}
SERVED = {"PING", "MOVE_JOINTS", "GET_JOINTS", "SET_TOOL", "SET_WORK_OBJECT", "SET_SPEED", "SET_ZONE"} | {
    "GET_SPEED",
    "WATCH",
    "CONTROLLER_INFO",
    "CLOSE",
}


def code(text):
    """The module without its comments and texts."""
    return re.sub(r'"[^"]*"', '""', re.sub(r"!.*", "", text))


def constant(text, name):
    return float(re.search(rf"CONST num {name}:=([\d.]+);", text)[1])


@pytest.mark.parametrize("name", sorted(MODULES))
@pytest.mark.parametrize("block", ["MODULE", "PROC", "FUNC", "TRAP", "WHILE", "TEST"])
def test_every_block_ends(name, block):
    text = code(MODULES[name])

    assert len(re.findall(rf"\b{block}\b", text)) == len(re.findall(rf"\bEND{block}\b", text))


@pytest.mark.parametrize("name", sorted(MODULES))
def test_every_choice_of_several_lines_ends(name):
    text = code(MODULES[name])

    assert len(re.findall(r"(?<!ELSE)\bIF\b.*\bTHEN\b", text)) == len(re.findall(r"\bENDIF\b", text))


@pytest.mark.parametrize("name", sorted(MODULES))
def test_every_routine_that_is_called_is_there_or_rapids_own(name):
    text = code(MODULES[name])
    own = set(re.findall(r"\b(?:PROC|TRAP|FUNC \w+) (\w+)", text))
    called = set(re.findall(r"^ +([A-Z][a-z]+[A-Z]\w*);$", text, flags=re.MULTILINE))

    assert called <= own | {"ClearPath", "StartMove"}


def test_the_variables_are_those_that_the_driver_writes_and_reads():
    assert f"PERS string {web.NAME}:={web.SERVER};" in RWS
    assert f"PERS num {web.ORDER}{{{len(Order().values())}}}:=" in RWS
    assert f"PERS num {web.BEAT}:=" in RWS
    report = Report(Progress.IDLE, Order().values())
    assert f"PERS num {web.REPORT}{{{1 + len(report.order)}}}:={report.encode()};" in RWS


def test_the_states_are_those_of_the_driver():
    assert {name: constant(RWS, name) for name in STATES} == STATES
    assert set(STATES.values()) == set(Progress)


@pytest.mark.parametrize(
    ("text", "silence_s", "beat_s", "stops_within_s"),
    [
        (RWS, web.SILENCE_S, web.BEAT_S, web.STOPS_WITHIN_S),
        (SERVER, protocol.SILENCE_S, protocol.BEAT_S, protocol.STOPS_WITHIN_S),
    ],
)
def test_an_arm_that_nobody_hears_is_at_rest_in_time(text, silence_s, beat_s, stops_within_s):
    look_s = constant(text, "LOOK_S")

    assert beat_s + look_s < silence_s
    assert silence_s + look_s < stops_within_s
    assert text.index("StopMove\\Quick;") < text.index("ProcerrRecovery\\SyncLastMoveInst;")
    assert text.index("ERRNO=ERR_PATH_STOP") < text.index("ClearPath;")


def test_the_watch_over_the_beats_is_that_of_the_driver():
    assert constant(RWS, "SILENCE_S") == web.SILENCE_S
    assert constant(RWS, "PATIENCE_S") == web.FIRST_BEAT_S


def test_every_request_of_the_driver_is_served():
    cases = {int(number) for number in re.findall(r"CASE (\d+):", SERVER)} | {2}  # which moves

    assert cases == {protocol.Code[name] for name in SERVED}
    assert f'SERVER_NAME:="{protocol.OUR_SERVER}"' in SERVER
    assert f'BEAT:="{protocol.BEAT.decode()}"' in SERVER
    assert constant(SERVER, "ANGLE_DECIMALS") == protocol.MOST_DECIMALS
    assert constant(SERVER, "SERVER_PORT") == protocol.MOTION_PORT


@pytest.mark.parametrize("text", [SERVER, RWS])
def test_both_servers_stream_the_joints_where_that_module_is_loaded(text):
    (started,) = re.findall(r'%"(\w+)"%;', text)

    assert f"PROC {started}()" in EGM
    assert constant(EGM, "EVERY_MS") / 1000.0 < reader._FRESH_WITHIN_S / 10.0
