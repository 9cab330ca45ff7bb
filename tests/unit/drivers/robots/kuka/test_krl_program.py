"""Our program for KUKA controllers says the same as the codec; nobody here can run it."""

import re
from pathlib import Path

import pytest

from truepose_drivers import kuka_variable_proxy
from truepose_drivers.kuka_variable_proxy import protocol
from truepose_drivers.kuka_variable_proxy.protocol import ProgramState, Variable, encode_state

CONTROLLER = Path(kuka_variable_proxy.__file__).parent / "controller"
SOURCE, DATA = ((CONTROLLER / f"truepose.{kind}").read_text() for kind in ("src", "dat"))


def code(text):
    """The program without its comments."""
    return re.sub(r";.*", "", text)


@pytest.mark.parametrize("name", [name for name in Variable if name.startswith("TP_")])
def test_every_variable_of_the_program_is_declared_for_all_and_used(name):
    assert re.search(rf"^DECL GLOBAL \w+ {name}=", DATA, re.MULTILINE)
    assert name in code(SOURCE)


def test_the_state_has_the_fields_of_the_codec_in_their_order():
    stated = encode_state(ProgramState(0, 0, 0, 0))
    kind, fields = re.search(r"^GLOBAL STRUC (\w+) INT ([\w,]+)$", DATA, re.MULTILINE).groups()

    assert stated == "{" + kind + ": " + ", ".join(f"{field} 0" for field in fields.split(",")) + "}"


def test_an_arm_that_nobody_hears_is_at_rest_in_time():
    silences = {int(ms) / 1000.0 for ms in re.findall(r"\$TIMER\[20\]=-(\d+)", code(SOURCE))}

    assert silences == {protocol.SILENCE_S}
    assert 3.0 * protocol.BEAT_S < protocol.SILENCE_S < protocol.STOPS_WITHIN_S
    assert "BRAKE F" in code(SOURCE)
    assert "RESUME" in code(SOURCE)


def test_nothing_moves_before_somebody_was_heard():
    watched = code(SOURCE).partition("DEF MOVE_WATCHED()")[2].partition("\nEND")[0]

    assert (
        watched.index("INTERRUPT ON 22") < watched.index("WAIT FOR TP_BEAT") < watched.index("PTP TP_TARGET")
    )
    assert watched.index("PTP TP_TARGET") < watched.index("WAIT SEC 0") < watched.index("TP_STATE.ARRIVED=")
    assert code(SOURCE).count("PTP ") == 2  # the other one is to where the arm stands


def test_the_ranges_of_all_six_axes_are_looked_at():
    assert re.findall(r"TP_TARGET\.A(\d)<\$SOFTN_END\[(\d)\]", SOURCE) == [
        (f"{n}", f"{n}") for n in range(1, 7)
    ]
    assert re.findall(r"TP_TARGET\.A(\d)>\$SOFTP_END\[(\d)\]", SOURCE) == [
        (f"{n}", f"{n}") for n in range(1, 7)
    ]


def test_every_block_is_closed():
    for opens, closes in (("IF", "ENDIF"), ("FOR", "ENDFOR"), ("LOOP", "ENDLOOP"), ("DEFFCT", "ENDFCT")):
        begun = re.findall(rf"^\s*{opens}\b", code(SOURCE), re.MULTILINE)
        assert len(begun) == len(re.findall(rf"^\s*{closes}\b", code(SOURCE), re.MULTILINE)), opens
    assert len(re.findall(r"^DEF ", SOURCE, re.MULTILINE)) == len(re.findall(r"^END$", SOURCE, re.MULTILINE))
