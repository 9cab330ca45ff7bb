"""A broken program ends in one sentence with file, line and place in the line."""

import random
import re
import time

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from tests.helpers.exchange.robot_programs import PROGRAMS, read
from truepose.exchange.errors import (
    BadValueError,
    InputFileError,
    MissingEntryError,
    UnreadableFileError,
)
from truepose.exchange.programs import parsed_program
from truepose.exchange.programs.formats import FORMATS, format_of, read_program
from truepose.exchange.programs.number_replacement import rewritten

TARGET = "[[1,2,3],[1,0,0,0],[0,0,0,0],[9E9,9E9,9E9,9E9,9E9,9E9]]"
FANUC_HEAD = "/PROG M\n/MN\n/POS\n"

BROKEN = {
    "a bracket that stays open": (
        "MODULE M\nCONST robtarget p:=[[1,2,3],[1,0,0,0;\nENDMODULE\n",
        "m.mod, line 2, column 29: the bracket [ that begins here is not closed.",
    ),
    "a bracket that was not opened": (
        "MODULE M\nCONST num a:=1];\nENDMODULE\n",
        "m.mod, line 2, column 15: ] closes a bracket that was not opened.",
    ),
    "a string that stays open": (
        'MODULE M\nPROC a()\nTPWrite "hello;\nENDPROC\nENDMODULE\n',
        "m.mod, line 3, column 9: the string that begins here does not end on its line.",
    ),
    "a module that is cut off": (
        f"MODULE M\nCONST robtarget p:={TARGET};\nPROC a()\nMoveL p,v100,fine,tool0;\n",
        "m.mod, line 3, column 1: the PROC that begins here has no ENDPROC; the file is cut off.",
    ),
    "a statement that is cut off": (
        "MODULE M\nENDMODULE\nCONST num",
        "m.mod, line 3, column 1: the statement that begins here does not end with ;.",
    ),
    "a routine that ends twice": (
        "MODULE M\nENDPROC\nENDMODULE\n",
        "m.mod, line 1, column 1: the MODULE that begins here has no ENDMODULE; the file is cut off.",
    ),
    "too few numbers": (
        f"MODULE M\nCONST robtarget p:={TARGET.replace('1,2,3', '1,2')};\nENDMODULE\n",
        "m.mod, line 2, column 21: this part of a robtarget has 3 parts, 2 found.",
    ),
    "a part that is missing": (
        "MODULE M\nCONST jointtarget p:=[[0,0,0,0,0,0]];\nENDMODULE\n",
        "m.mod, line 2, column 22: jointtarget has 2 parts, 1 found.",
    ),
    "an element that is missing": (
        f"MODULE M\nCONST robtarget p{{2}}:=[{TARGET},];\nENDMODULE\n",
        "m.mod, line 2, column 23: an element of this array is missing.",
    ),
    "a number that none can be": (
        f"MODULE M\nCONST robtarget p:={TARGET.replace('1,2,3', '1,2,3E99')};\nENDMODULE\n",
        "m.mod, line 2, column 26: 3E99 is too large for any quantity.",
    ),
    "a number of thousands of digits": (
        f"MODULE M\nCONST robtarget p:={TARGET.replace('1,2,3', '1,2,' + '3' * 5000)};\nENDMODULE\n",
        f"m.mod, line 2, column 26: {'3' * 40}... is too large for any quantity.",
    ),
    "brackets without end": (
        f"MODULE M\nCONST num a:={'[' * 900}{']' * 900};\nENDMODULE\n",
        "m.mod, line 2, column 64: brackets are nested too deeply.",
    ),
    "a motion without a target": (
        "MODULE M\nPROC a()\nMoveL \\Conc;\nENDPROC\nENDMODULE\n",
        "m.mod, line 3, column 1: MoveL has no target.",
    ),
    "KRL that is cut off": (
        "DEF M( )\nPTP {A1 0,A2 0,A3 0,A4 0,A5 0,A6 0}\n",
        "m.src, line 1, column 1: the DEF that begins here has no END; the file is cut off.",
    ),
    "braces that stay open": (
        "DEFDAT M\nDECL E6POS P={X 1,Y 2\nENDDAT\n",
        "m.dat, line 2, column 14: the bracket { that begins here is not closed.",
    ),
    "KRL without a target": (
        "DEF M( )\nLIN\nEND\n",
        "m.src, line 2, column 1: LIN has no target.",
    ),
    "LS that is cut off": (
        FANUC_HEAD,
        "m.ls, line 3, column 5: the program has no /END; the file is cut off.",
    ),
    "a position that is cut off": (
        f"{FANUC_HEAD}P[1]{{\n   GP1:\n/END\n",
        "m.ls, line 4, column 1: the position that begins here is not closed by }.",
    ),
    "a position without a number": (
        f"{FANUC_HEAD}P[1]{{\n GP1:\n X = 1.000 mm, Y = 1.000 mm,\n W = 0.000 deg\n}};\n/END\n",
        "m.ls, line 5, column 6: P[1] has no Z.",
    ),
    "URScript that is cut off": (
        "def m():\n  while True:\n    movel(p[0,0,0,0,0,0])\nend\n",
        "m.script, line 1, column 1: the def that begins here has no end; the file is cut off.",
    ),
    "URScript that ends twice": (
        "def m():\nend\nend\n",
        "m.script, line 3, column 1: this end has no matching beginning.",
    ),
    "G-code that does not say its angles": (
        "G1 X0 Y0 Z0 A0 B0 C0\n",
        "m.nc, line 1, column 14: the file does not state the axes of A, B and C; specify them: "
        "xyz, zyx, fixed xyz.",
    ),
    "a word that stands twice": (
        "G1 X0 Y0 Z0 X1\n",
        "m.nc, line 1, column 13: X appears twice in this block.",
    ),
    "a remark that stays open": (
        "G1 X0 (here\n",
        "m.nc, line 1, column 7: the remark that begins here is not closed.",
    ),
    "a job without a head": ("//POS\nEND\n", "m.jbi, line 1, column 1: a job begins with /JOB."),
    "a job that is cut off": (
        "/JOB\n//INST\nNOP\n",
        "m.jbi, line 3, column 4: the job has no END; the file is cut off.",
    ),
    "a position of a job that is cut off": (
        "/JOB\n//POS\n///POSTYPE ROBOT\n///RECTAN\nC0=1,2,3\n//INST\nEND\n",
        "m.jbi, line 5, column 4: C0 has 6 numbers, 3 found.",
    ),
    "VAL3 that is cut off": (
        "<Database>\n<Datas>\n",
        "m.dtx, line 2, column 8: the Database has no end; the file is cut off.",
    ),
    "a tag that stays open": (
        '<Database>\n<Value key="0"\n</Database>\n',
        "m.dtx, line 2, column 1: the tag that begins here is not closed.",
    ),
    "VAL3 of another version": (
        "<dataList/>\n",
        "m.dtx, line 1, column 1: this is not VAL3 data of version 7 or later: it has no Database.",
    ),
    "text for a number": (
        '<Database><Data type="joint"><Value j1="x" j2="0" j3="0" j4="0" j5="0" j6="0"/></Data></Database>',
        "m.dtx, line 1, column 41: 'x' is not a number.",
    ),
    "no orientation in a list": (
        '[{"x_mm": 1, "y_mm": 2, "z_mm": 3, "qw": 1, "qx": 1, "qy": 0, "qz": 0}]',
        "m.json, line 1, column 42: qw to qz have the norm 1.41421; that of an orientation is 1.",
    ),
    "a list with text": (
        '[{"x_mm": 1, "y_mm": 2, "z_mm": "here", "qw": 1, "qx": 0, "qy": 0, "qz": 0}]',
        "m.json, line 1, key [0].z_mm: 'here' is not a number.",
    ),
    "JSON without a key": (
        '[{"x_mm": 1}]',
        "m.json, line 1, key [0]: key y_mm is missing; it is required.",
    ),
    "a file without anything": (
        " \n",
        "m.mod: the file is empty; a program is required.",
    ),
}


@pytest.mark.parametrize(("text", "sentence"), BROKEN.values(), ids=list(BROKEN))
def test_a_broken_program_is_refused_in_one_sentence(text, sentence):
    name = re.split("[,:]", sentence)[0]

    with pytest.raises(InputFileError) as refused:
        read_program(text.encode(), name)

    assert str(refused.value) == sentence
    assert refused.value.file == name


LONG = "0" * 5000
POSE = "X = 1.000 mm, Y = 2.000 mm, Z = 3.000 mm, W = 0.000 deg, P = 0.000 deg, R = 0.000 deg"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("m.ls", f"{FANUC_HEAD}P[{LONG}1]{{ GP{LONG}1: UF : {LONG}, UT : {LONG}7, {POSE} }};\n/END\n"),
        ("m.jbi", f"/JOB\n//POS\n///POSTYPE ANGLE\nC{LONG}1=1,2,3,4,5,6\n//INST\nMOVL C1\nEND\n"),
        ("m.mod", f"MODULE M\nCONST robtarget p:={TARGET.replace('1,2,3', f'1,2,3E{LONG}')};\nENDMODULE\n"),
        ("m.mod", f"MODULE M\nCONST robtarget p:={TARGET.replace('1,2,3', f'1,2,0E-9{LONG}')};\nENDMODULE\n"),
        ("m.json", '[{"\\u00711_deg": 1, "q2_deg": 2e0}]'),
        ("m.json", '[{"q1_deg": 1e-' + LONG + '7, "q2_deg": 0e9' + LONG + "}]"),
        (
            "m.dat",
            f"DEFDAT M\nDECL E6POS P={{X 1,Y 2,Z 3,A 0,B 0,C 0,S 2,T 'H{'f' * 5000}'}}\nENDDAT\n",
        ),
    ],
)
def test_digits_without_end_and_escaped_keys_are_read_as_they_are_meant(name, text):
    program = read_program(text.encode(), name)

    assert len(program.targets) == 1
    assert rewritten(program, {0: program.targets[0].value}) == text.encode()


TIMES = 8
FEWEST = 400


def read_time_s(text, name, targets):
    """Return the shortest of three: what else the machine does lengthens one of them, seldom all."""
    times = []
    for _ in range(3):
        began = time.process_time()
        assert len(read_program(text.encode(), name).targets) == targets
        times.append(time.process_time() - began)
    return min(times)


@pytest.mark.parametrize(
    ("name", "written", "targets"),
    [
        ("m.src", lambda n: "DEF M( )\n" + "LOOP\n" * n + "ENDLOOP\n" * n + "END\n", 0),
        ("m.script", lambda n: "while True:\n" * n + "end\n" * n, 0),
        ("m.ls", lambda n: f"/PROG M\n/MN\n{':L P[1]' * (n // 20)}\n" + ":\n" * 8 * n + "/POS\n/END\n", 0),
        ("m.dtx", lambda n: f"<Database><Data {'a' * 8 * n}></Data></Database>", 0),
    ],
    ids=["loops of KRL", "loops of URScript", "statements without ends", "an attribute without a value"],
)
def test_what_stands_in_itself_or_never_ends_takes_no_time_out_of_proportion(name, written, targets):
    short_s = read_time_s(written(FEWEST), name, targets)

    # Eight times as much: eight times the time in proportion, 64 times where each looks at all others.
    assert read_time_s(written(TIMES * FEWEST), name, targets) < 3 * TIMES * short_s + 1e-3


def test_indices_that_choose_among_thousands_again_and_again_are_refused(monkeypatch):
    monkeypatch.setattr(parsed_program, "_MOST_MEANT", 1000)
    places = "".join(f"PTS[{k}]={{X 1,Y 2,Z 3,A 0,B 0,C 0}}\n" for k in range(1, 31))
    moves = "LIN PTS[I]\n" * 30

    with pytest.raises(UnreadableFileError, match=r"m.src, line 49, .* too many targets"):
        read_program(f"DEF M( )\n{places}{moves}END\n".encode(), "m.src")


def test_a_binary_file_and_text_of_two_bytes_a_character_are_refused():
    with pytest.raises(UnreadableFileError, match="binary file; the program as text is required"):
        read_program(b"/PROG\x00\x01", "m.ls")
    with pytest.raises(UnreadableFileError, match="UTF-16"):
        read_program("MODULE M\nENDMODULE\n".encode("utf-16"), "m.mod")


def test_a_byte_order_mark_is_no_part_of_a_program():
    data = b"\xef\xbb\xbf" + PROGRAMS["row.mod"]

    program = read("row.mod", data)

    assert rewritten(program, {i: target.value for i, target in enumerate(program.targets)}) == data


def test_an_unknown_ending_is_refused_with_those_that_are_known():
    with pytest.raises(
        UnreadableFileError, match=r"are tables \(\.csv\), ABB RAPID \(\.mod .*Staubli VAL3 \(\.dtx\)"
    ):
        read_program(b"x", "m.pdf")


def test_an_ending_belongs_to_one_format():
    endings = [suffix for known in FORMATS for suffix in known.suffixes]

    assert len(endings) == len(set(endings))
    assert format_of("A.MOD").name == "ABB RAPID"


def test_what_kind_of_fault_it_is_can_be_told():
    with pytest.raises(BadValueError):
        read_program(BROKEN["too few numbers"][0].encode(), "m.mod")
    with pytest.raises(MissingEntryError):
        read_program(BROKEN["G-code that does not say its angles"][0].encode(), "m.nc")


PIECES = (b":=", b"[", b"}", b"END", b"\n", b'"', b",", b"PTP", b"P[1]", b"1e400")


@given(seed=st.integers(0, 2**32), name=st.sampled_from(sorted(PROGRAMS)))
@settings(max_examples=300, deadline=None)
def test_a_damaged_program_is_refused_in_a_sentence_or_kept_byte_for_byte(seed, name):
    draw = random.Random(seed)
    data = bytearray(PROGRAMS[name])
    for _ in range(draw.choice([1, 1, 2, 5])):
        at = draw.randrange(len(data) or 1)
        match draw.randrange(3):
            case 0:
                del data[at : at + draw.randrange(1, 40)]
            case 1:
                data[at:at] = draw.choice(PIECES)
            case _:
                del data[at:]

    try:
        program = read(name, bytes(data))
    except InputFileError as refused:
        assert "\n" not in str(refused)
        return

    assert rewritten(program, {i: target.value for i, target in enumerate(program.targets)}) == data
