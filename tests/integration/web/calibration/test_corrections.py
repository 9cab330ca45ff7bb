"""Corrections over REST: a program goes in, comes back with other numbers, and stays on record."""

import asyncio
import csv
import hashlib
import io
import threading
from dataclasses import replace

import pytest

from tests.helpers.domain.robots import IRB_120
from tests.helpers.web.clients import ENDED, made, until
from tests.helpers.web.pages import Page, links
from tests.helpers.web.performing import perform_here
from tests.integration.web.calibration.stored_models import store_model
from truepose.storage.documents import unpack
from truepose.storage.results import corrections as stored_corrections
from truepose.web.api import corrections

REST = "[9E9,9E9,9E9,9E9,9E9,9E9]"
PROGRAM = (
    "MODULE Weld\r\n  ! t\xfcrseitig\r\n"
    f"  CONST jointtarget jHome:=[[20,30,-25,40,50,60],{REST}];\r\n"
    "  PROC main()\r\n    MoveAbsJ jHome,v100,fine,tool0;\r\n    MoveL Offs(pNo,0,0,9),v1,fine,tool0;\r\n"
    "  ENDPROC\r\nENDMODULE\r\n"
).encode("latin-1")
TABLE = b"target,x_mm,y_mm,z_mm,qw,qx,qy,qz,note\nnear,350,100,400,0,0,1,0,ok\nfar,9000,0,0,1,0,0,0,\n"


@pytest.fixture
async def model_id(app):
    return await store_model(app.state.context)


@pytest.fixture
def send(client, model_id):
    async def sending(name, data, beside=(), model=None, **options):
        files = [("file", (name, data)), *(("beside", one) for one in beside)]
        path = f"/api/v1/models/{model or model_id}/corrections"
        return await client.post(path, files=files, params=options)

    return sending


async def test_a_program_comes_back_with_other_numbers_and_is_on_record(client, send, model_id):
    path = await made(client, await send("weld.mod", PROGRAM))

    record = (await client.get(path)).json()
    back = await client.get(record["file_url"])
    before, after = PROGRAM.split(b"\r\n"), back.content.split(b"\r\n")
    assert [k for k, (a, b) in enumerate(zip(before, after, strict=True)) if a != b] == [2]
    assert back.headers["content-disposition"] == "attachment; filename*=UTF-8''weld-corrected.mod"
    assert record["original_sha256"] == hashlib.sha256(PROGRAM).hexdigest()
    assert record["corrected_sha256"] == hashlib.sha256(back.content).hexdigest()
    assert (record["model_id"], record["name"], record["document"]["corrected"]) == (model_id, "weld.mod", 1)
    assert record["document"]["left_alone"] == [
        {
            "line": 6,
            "what": "MoveL Offs(pNo,0,0,9),v1,fine,tool0",
            "reason": "the position is computed at run time",
            "file": None,
        }
    ]
    assert 0.1 < record["largest_shift_mm"] < 10.0
    assert (await client.get(f"/api/v1/models/{model_id}/corrections")).json() == [record]
    assert (await client.get("/api/v1/corrections")).json() == [record]


async def test_each_target_of_a_table_is_told_and_its_own_columns_come_back(client, send):
    path = await made(client, await send("t.csv", TABLE, frame="base"))

    targets = (await client.get(f"{path}/targets")).json()
    (far,) = (await client.get(f"{path}/targets", params={"after": 1, "limit": 1})).json()
    rows = list(csv.DictReader(io.StringIO((await client.get(f"{path}/file")).text)))
    assert [(one["name"], one["line"], one["status"]) for one in targets] == [
        ("near", 2, "ok"),
        ("far", 3, "out_of_reach"),
    ]
    assert targets[0]["place_mm"] == pytest.approx([350.0, 100.0, 400.0])
    assert targets[0]["u_mm"] == pytest.approx(float(rows[0]["u_mm"]), rel=1e-5)
    assert (far["number"], far["u_mm"], far["shift_mm"]) == (2, None, [None] * 3)
    assert [row["note"] for row in rows] == ["ok", ""]


FANUC = (
    b"/PROG A\n/MN\n   1:J P[1] 20% FINE ;\n/POS\nP[1]{\n   GP1:\n\tUF : 0, UT : 1,\n"
    b"\tJ1= 10.000 deg, J2= 20.000 deg, J3= -10.000 deg,\n"
    b"\tJ4= 0.000 deg, J5= 40.000 deg, J6= 0.000 deg\n};\n/END\n"
)


async def test_joints_of_a_fanuc_are_corrected_where_they_are_said_to_be_coupled(app, client, send):
    number = await store_model(app.state.context, replace(IRB_120, name="left arm"))

    silent = await client.get(await made(client, await send("a.ls", FANUC, model=number)))
    told = await client.get(await made(client, await send("a.ls", FANUC, model=number, coupled=True)))

    assert [reply.json()["document"]["corrected"] for reply in (silent, told)] == [0, 1]
    assert [reply.json()["asked"]["coupled"] for reply in (silent, told)] == [False, True]


FITTING_MM = [(350, 100, 400), (330, 150, 420), (300, -200, 450), (380, 50, 350), (360, -120, 380)]
INCHES = "\n".join(
    ["target,x_mm,y_mm,z_mm,qw,qx,qy,qz"]
    + [f"t,{x / 25.4},{y / 25.4},{z / 25.4},0,0,1,0" for x, y, z in FITTING_MM]
).encode()


async def test_numbers_that_would_fit_in_inches_are_not_corrected_unless_they_are_meant_so(client, send):
    asked = await send("t.csv", INCHES, frame="base")
    job = await until(client, asked.headers["Location"], lambda job: job["state"] in ENDED)
    nothing = (await client.get("/api/v1/corrections")).json()
    meant = await made(client, await send("t.csv", INCHES, frame="base", as_written=True))

    assert (job["state"], job["result_id"], nothing) == ("failed", None, [])
    assert "100% would be if x, y and z were in inches" in job["message"]
    assert "set as_written (command line: --as-written)" in job["message"]
    assert (await client.get(meant)).json()["asked"]["as_written"] is True
    assert "use as written" in (await client.get(meant.removeprefix("/api/v1"))).text


BEYOND = (
    b"target,x_mm,y_mm,z_mm,qw,qx,qy,qz\nbelow,370,60,-200,0,0,1,0\n"  # q2 = 122 deg, 12 beyond its limit
)


async def test_limits_that_nobody_knows_are_empty_and_said(app, client, send):
    unknown = await store_model(app.state.context, replace(IRB_120, name="shop robot 7"))
    path = await made(client, await send("t.csv", BEYOND, model=unknown, frame="base"))

    (target,) = (await client.get(f"{path}/targets")).json()
    (row,) = csv.DictReader(io.StringIO((await client.get(f"{path}/file")).text))
    record = (await client.get(path)).json()
    assert (target["status"], row["status"]) == ("limits_unknown", "limits_unknown")
    assert float(row["q2_deg"]) == pytest.approx(122.0, abs=2.0)
    assert row["beyond_limit_deg"] == ""
    assert record["document"]["statuses"] == {"limits_unknown": 1}
    page = (await client.get(f"/corrections/{record['id']}")).text
    assert "The joint limits of this robot are unknown" in page


async def test_a_target_beyond_the_limits_of_a_known_robot_is_not_corrected(client, send):
    path = await made(client, await send("t.csv", BEYOND, frame="base"))

    (row,) = csv.DictReader(io.StringIO((await client.get(f"{path}/file")).text))
    assert (row["status"], row["q2_deg"]) == ("joint_limit", "")
    assert float(row["beyond_limit_deg"]) == pytest.approx(12.0, abs=2.0)


async def test_the_same_key_corrects_once(client, send, model_id):
    path, files = f"/api/v1/models/{model_id}/corrections", {"file": ("weld.mod", PROGRAM)}
    key = {"Idempotency-Key": "k1"}

    first = await client.post(path, files=files, headers=key)
    await made(client, first)
    again = await client.post(path, files=files, headers=key)
    other = await client.post(path, files={"file": ("w.mod", PROGRAM)}, headers=key)

    assert again.json()["id"] == first.json()["id"]
    assert other.status_code == 409
    assert len((await client.get("/api/v1/corrections")).json()) == 1


SEVEN = b'[{"q1_deg":1,"q2_deg":2,"q3_deg":3,"q4_deg":4,"q5_deg":5,"q6_deg":6,"q7_deg":7}]'


@pytest.mark.parametrize(
    ("name", "data", "options", "sentence"),
    [
        ("weld.txt", PROGRAM, {}, "weld.txt: unknown file extension; supported files are"),
        ("weld.mod", PROGRAM[:-20], {}, "weld.mod, line 4"),
        ("weld.mod", b"", {}, "weld.mod: the file is empty"),
        ("weld.mod", PROGRAM.decode("latin-1").encode("utf-16"), {}, "weld.mod: the text is UTF-16"),
        ("t.csv", TABLE.replace(b"near", b"n\xe4r"), {}, "t.csv, line 2: the text is not UTF-8"),
        ("t.csv", b"", {}, "t.csv: the file is empty"),
        (
            "t.csv",
            TABLE.replace(b",350,", b",here,"),
            {},
            "t.csv, line 2, column x_mm: 'here' is not a number",
        ),
        ("t.json", SEVEN, {}, "has 7 joints, the model has 6: the program is for another robot"),
        ("weld.ls", b"/PROG A\n/MN\n/POS\n/END\n", {}, "a program for FANUC robots"),
        ("p.nc", b"G1 X1 Y2 Z3 A0 B0 C0\n", {}, "does not state the axes of A, B and C"),
        ("weld.mod", PROGRAM, {"frame": "tool"}, "frame"),
        ("weld.mod", PROGRAM, {"branch": "left"}, "branch left: name a branch such as front/up/no flip"),
        ("weld.mod", PROGRAM, {"define": "tGun=1,2"}, "define tGun=1,2: give NAME=x,y,z,qw,qx,qy,qz"),
    ],
)
async def test_what_cannot_be_corrected_is_refused_in_a_sentence(client, send, name, data, options, sentence):
    reply = await send(name, data, **options)

    assert reply.status_code == 422
    assert sentence in reply.json()["detail"]
    assert (await client.get("/api/v1/corrections")).json() == []


async def test_more_targets_than_are_taken_at_once_are_refused(send, monkeypatch):
    assert corrections.MOST_TARGETS == 100_000
    monkeypatch.setattr(corrections, "MOST_TARGETS", 1000)
    header, row, *_ = TABLE.splitlines()

    many, large = [await send("t.csv", b"\n".join([header, *[row] * n])) for n in (1001, 620_000)]

    assert (many.status_code, large.status_code) == (422, 413)
    assert "more than 1,000 rows" in many.json()["detail"]
    assert "larger than 16 MB" in large.json()["detail"]


async def test_a_form_without_a_file_two_files_of_one_name_and_no_form_are_refused(client, send, model_id):
    path = f"/api/v1/models/{model_id}/corrections"

    none = await client.post(path, files={"other": ("a.mod", PROGRAM)})
    two = await send("a.mod", PROGRAM, beside=[("a.mod", PROGRAM)])
    json = await client.post(path, json={})

    assert (none.status_code, two.status_code, json.status_code) == (422, 422, 415)
    assert none.json()["detail"] == "file: a robot program or a table of targets is required."
    assert "Two files are called a.mod" in two.json()["detail"]


async def test_there_is_no_correction_by_a_model_that_is_not_there(client, send):
    assert (await send("weld.mod", PROGRAM, model=99)).status_code == 404
    for path in ("models/99/corrections", "corrections/9", "corrections/9/file", "corrections/9/targets"):
        assert (await client.get(f"/api/v1/{path}")).status_code == 404


async def test_a_program_that_waits_in_memory_keeps_others_from_doing_so(
    app, client, send, model_id, monkeypatch
):
    desk, gate = app.state.context.job_desk, asyncio.Event()

    async def held(task, told):
        await gate.wait()
        return await perform_here(task, told)

    monkeypatch.setattr(desk._queue, "_perform", held)
    path, files = f"/api/v1/models/{model_id}/corrections", {"file": ("weld.mod", PROGRAM)}
    key = {"Idempotency-Key": "k1"}
    first = await client.post(path, files=files, headers=key)
    taken = [await send("weld.mod", PROGRAM) for _ in range(3)]
    refused = await send("weld.mod", PROGRAM)
    again = await client.post(path, files=files, headers=key)
    gate.set()

    assert [reply.status_code for reply in (first, *taken)] == [202] * 4
    assert (again.status_code, again.json().get("id")) == (202, first.json()["id"])
    assert refused.status_code == 503
    assert "Too many files are waiting to be corrected" in refused.json()["detail"]


async def test_a_name_of_another_alphabet_comes_back(client, send):
    path = await made(client, await send("C:\\cells\\сварка.mod", PROGRAM))

    file = await client.get(f"{path}/file")

    assert (await client.get(path)).json()["name"] == "сварка.mod"
    assert file.headers["content-disposition"].endswith("%D1%81%D0%B2%D0%B0%D1%80%D0%BA%D0%B0-corrected.mod")


async def test_the_page_of_a_correction_says_what_became_of_each_target(client, send, model_id):
    number = (await made(client, await send("weld.mod", PROGRAM))).rsplit("/", 1)[1]

    page, french = (
        await client.get(f"/corrections/{number}"),
        await client.get(f"/corrections/{number}?language=fr"),
    )

    assert page.status_code == 200
    assert "1 of 1 targets corrected. One statement in the program was not changed" in page.text
    assert "the position is computed at run time" in page.text
    assert "sa place est calculée à l" in french.text
    assert "Shifts of the targets, seen from above and from the front" in page.text
    assert {f"/api/v1/corrections/{number}/file", f"/sessions/new?model_id={model_id}#prove"} <= set(
        links(page)
    )
    assert f"/sessions/new?model_id={model_id}#prove" in links(french)


async def test_a_correction_that_reached_nothing_draws_nothing_and_proves_nothing(client, send):
    number = (await made(client, await send("t.csv", TABLE.replace(b"350", b"9350")))).rsplit("/", 1)[1]

    page = await client.get(f"/corrections/{number}")

    assert "0 of 2 targets corrected." in page.text
    assert "<figure" not in page.text
    assert not [link for link in links(page) if link.endswith("#prove")]


async def test_many_targets_are_shown_some_hundred_at_a_time(client, send):
    rows = TABLE.splitlines()
    table = b"\n".join([rows[0], *[rows[1]] * 201])
    number = (await made(client, await send("t.csv", table, frame="base"))).rsplit("/", 1)[1]

    first, rest = (
        await client.get(f"/corrections/{number}"),
        await client.get(f"/corrections/{number}?after=200"),
    )

    assert "?after=200" in links(first)
    assert [text.text.count("<th>near</th>") for text in (first, rest)] == [200, 1]


async def test_of_many_places_left_alone_a_record_tells_the_first_and_counts_all(client, send):
    head, tail = PROGRAM.split(b"    MoveL Offs", 1)
    program = head + b"    MoveL Offs(pNo,0,0,9),v1,fine,tool0;\r\n" * 1200 + b"    MoveL Offs" + tail
    path = await made(client, await send("weld.mod", program))

    record = (await client.get(path)).json()
    page = Page((await client.get(f"/corrections/{record['id']}")).text).text

    assert (record["left_alone_count"], len(record["document"]["left_alone"])) == (1201, 500)
    assert "1,201 statements in the program were not changed" in page
    assert "The first 500 of 1,201 are listed." in page


async def test_long_columns_are_read_beside_the_loop_that_watches_over_the_robot(client, send, monkeypatch):
    path = await made(client, await send("t.csv", TABLE, frame="base"))
    readers = set()

    def noted(kind, data):
        readers.add(threading.current_thread())
        return unpack(kind, data)

    monkeypatch.setattr(stored_corrections, "unpack", noted)
    await client.get(f"{path}/targets")

    assert len(readers) == 1
    assert threading.main_thread() not in readers


async def test_the_form_offers_the_models_and_the_list_leads_to_what_was_corrected(client, send, model_id):
    number = (await made(client, await send("weld.mod", PROGRAM))).rsplit("/", 1)[1]

    page = await client.get(f"/corrections?model_id={model_id}")

    assert f'<option value="{model_id}" selected>' in page.text
    assert f"/corrections/{number}" in links(page)


async def test_without_a_model_there_is_no_form_and_no_correction_has_no_page(client):
    page, none = await client.get("/corrections"), await client.get("/corrections/none")

    assert "There is no model yet" in page.text
    assert "<form" not in page.text
    assert none.status_code == 404
    assert "Page not found" in none.text
