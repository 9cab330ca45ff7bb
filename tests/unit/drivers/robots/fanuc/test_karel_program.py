"""Our program for FANUC controllers says the same as the codec; nobody here can run it."""

import re
from pathlib import Path

import pytest

from truepose_drivers.fanuc_mappdk import protocol
from truepose_drivers.fanuc_mappdk.protocol import Command, Motion, TimedMotion

CONTROLLER = Path(protocol.__file__).parent / "controller"
MOTION, LOGGER, REQUESTS, PORT = (
    (CONTROLLER / f"{name}.kl").read_text() for name in ("truepose", "truelog", "truecmd", "trueport")
)
ZEROS = (0.0,) * 6


def code(text):
    """The program without its comments."""
    return re.sub(r"--.*", "", text)


@pytest.mark.parametrize("command", Command)
def test_every_request_is_served(command):
    outputs = {"setrdo", "getrdo", "setdout", "getdout"}

    assert (command[1:] if command in outputs else command) in code(REQUESTS)


def test_the_ports_are_those_of_the_driver():
    assert f"PORT_NUMBER = {protocol.MOTION_PORT}" in MOTION
    assert f"PORT_NUMBER = {protocol.LOGGER_PORT}" in LOGGER


def test_the_identity_and_the_greeting_are_those_of_the_codec():
    assert f"'0:{protocol.OUR_SERVER},'" in REQUESTS
    assert f"WRITE port('{protocol.encode_reply(protocol.GREETING).decode()}')" in PORT


def test_an_arm_that_nobody_hears_is_at_rest_in_time():
    look_s = int(re.search(r"LOOK_MS = (\d+)", MOTION)[1]) / 1000.0

    assert protocol.BEAT_S + look_s < protocol.SILENCE_S
    assert protocol.SILENCE_S + 2.0 * look_s < protocol.STOPS_WITHIN_S
    assert "ABORT_TASK(tp_program, TRUE, TRUE, status)" in code(MOTION)


def test_only_the_motion_server_moves():
    assert "MAY_MOVE = TRUE" in MOTION
    assert "MAY_MOVE = FALSE" in LOGGER
    assert "RUN_TASK" not in LOGGER + REQUESTS


def test_fields_stand_where_the_program_looks_for_them():
    motion = protocol.encode_motion(Command.MOVE_TO_JOINTS, Motion(ZEROS, 50, 80, 25, linear=True)).decode()
    timed = protocol.encode_timed_motion(TimedMotion(ZEROS, 12.3)).decode()
    places = [tuple(map(int, found)) for found in re.findall(r"register_set\(8\d, (\d+), (\d+)\)", REQUESTS)]

    assert [motion[first - 1 : first - 1 + chars] for first, chars in places] == ["0050", "0080", "025"]
    assert (motion[21 - 1], motion[23 - 1], motion[25 - 1 : 25 + 13]) == ("1", "6", "+000000.000000")
    assert (timed[7 - 1 : 7 + 4], timed[13 - 1]) == ("00123", "6")
    assert "target_set(23" in REQUESTS
    assert "target_set(13" in REQUESTS


@pytest.mark.parametrize("name", ["truepose.kl", "truelog.kl", "truecmd.kl", "trueport.kl"])
def test_every_block_is_closed(name):
    text = code((CONTROLLER / name).read_text())
    text = re.sub(r"'[^']*'", "''", text)

    for opens, closes in (("IF", "ENDIF"), ("FOR", "ENDFOR"), ("WHILE", "ENDWHILE")):
        assert len(re.findall(rf"\b{opens}\b", text)) == len(re.findall(rf"\b{closes}\b", text)), opens
    routines = re.findall(r"^ROUTINE (\w+)", text, re.MULTILINE)
    assert routines == [name for name in re.findall(r"^END (\w+)", text, re.MULTILINE) if name in routines]


@pytest.mark.parametrize("name", ["truemovj", "truemovl", "truemovt"])
def test_each_motion_has_its_program_on_the_pendant(name):
    text = (CONTROLLER / f"{name}.ls").read_text()

    assert text.startswith(f"/PROG  {name.upper()}\n")
    assert "PR[81] R[81]" in text
    assert f"'{name.upper()}'" in REQUESTS
