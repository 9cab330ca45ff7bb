"""The independent client CESAPI reads what our codec writes; runs where that package is installed."""

import inspect

import pytest

from tests.helpers.machine import CESAPI
from truepose_drivers.leica_emscon.protocol import Answer, Command, Record, encode, exchange

packet = pytest.importorskip("CESAPI.packet", reason=CESAPI.reason)

ANSWERS = [
    made
    for name, made in inspect.getmembers(packet, inspect.isclass)
    if name.endswith("RT") and name != "BasicCommandRT"
]


def members(structure) -> list[int | float | bytes]:
    """Members of a structure in wire order, nested ones included."""
    found = []
    for name, value in vars(structure).items():
        if name.startswith("_") or name in {"packet", "packetInfo"}:
            continue
        found += [value] if isinstance(value, int | float | bytes) else members(value)
    return found


def seven(zero: object) -> int | float | str:
    """A value of the same kind as `zero`; a boolean has no 7."""
    if isinstance(zero, bool):
        return True
    return type(zero)(7) if isinstance(zero, float | str) else 7


@pytest.mark.parametrize("structure", ANSWERS, ids=lambda made: made.__name__)
def test_an_answer_of_ours_is_read_member_by_member(structure):
    theirs = structure()
    command = Command(theirs.packetInfo.command)
    layout = exchange(command).answer
    sent = {name: seven(kind.zero) for name, kind in layout.members}

    theirs.unpack(encode(Answer(command, values=Record(sent))))

    read = [value.rstrip(b"\0") if isinstance(value, bytes) else value for value in members(theirs)]
    assert read == [b"7" if value == "7" else value for value in sent.values()]
