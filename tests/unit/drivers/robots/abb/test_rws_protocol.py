"""Requests and answers of Robot Web Services against recorded ones, and whatever else may arrive."""

import json
import math
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from tests.helpers.refusals import assert_refused_at_worst
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.http import (
    LONGEST_BODY_BYTES,
    Challenge,
    HttpRequest,
    HttpResponse,
    Login,
    RequestReader,
    ResponseReader,
    RwsProtocolError,
    authorization,
    challenge_header,
    decode_challenge,
    encode_request,
    encode_response,
    form_body,
    is_let_in,
)
from truepose_drivers.abb_rws.protocol import (
    Order,
    Progress,
    Report,
    array_text,
    decode_order,
    decode_report,
    number_text,
    numbers,
    single,
)

VECTORS = json.loads((Path(__file__).parents[4] / "vectors" / "rws_dialogue.json").read_text())
LOGIN = Login("Default User", "robotics")
CHALLENGE = Challenge(VECTORS["realm"], VECTORS["nonce"])
LOGGED_IN = [row for row in VECTORS["requests"] if "Authorization" in row["text"]]


def one(reader, data, chunk=4096):
    for start in range(0, len(data), chunk):
        reader.receive_data(data[start : start + chunk])
    return reader.next_message()


def json_response(document, status=200):
    return HttpResponse(status, (), json.dumps(document).encode())


def told(**state):
    return json_response({"_embedded": {"_state": [state]}})


@pytest.mark.parametrize("chunk", [1, 7, 4096])
@pytest.mark.parametrize("row", VECTORS["requests"])
def test_requests_of_the_public_client_are_read_and_end_where_they_end(row, chunk):
    reader = RequestReader()

    request = one(reader, row["text"].encode(), chunk)

    method, target, _ = row["text"].split(" ", 2)
    assert (request.method, request.target) == (method, target)
    assert request.form == row["form"]
    assert not reader.inside_message


@pytest.mark.parametrize("part", ["path", "query"])
def test_a_target_in_brackets_without_an_end_is_refused(part):
    with pytest.raises(RwsProtocolError, match="not a request target"):
        getattr(HttpRequest("GET", "//[1"), part)


@pytest.mark.parametrize("row", LOGGED_IN)
def test_the_public_client_is_let_in_with_its_password_and_with_no_other(row):
    request = one(RequestReader(), row["text"].encode())
    header = request.headers["authorization"]

    assert is_let_in(header, CHALLENGE, LOGIN, request.method, request.target)
    for login in (Login("Default User", "robotic"), Login("default user", "robotics")):
        assert not is_let_in(header, CHALLENGE, login, request.method, request.target)
    assert not is_let_in(header, CHALLENGE, LOGIN, request.method, "/rw/panel/opmode")
    assert not is_let_in(header, Challenge(CHALLENGE.realm, "another"), LOGIN, request.method, request.target)


def test_digest_answers_are_those_of_the_standard():
    # RFC 2617, section 3.5
    challenge = Challenge("testrealm@host.com", "dcd98b7102dd2f0e8b11d0f600bfb0c093")
    login = Login("Mufasa", "Circle Of Life")

    header = authorization(challenge, login, "GET", "/dir/index.html", count=1, client_nonce="0a4f113b")

    assert 'response="6629fae49393a05397450978507c4ef1"' in header
    assert "nc=00000001" in header


def test_a_challenge_is_read_as_controllers_write_it_and_as_ours_does():
    assert decode_challenge(VECTORS["challenge"]) == CHALLENGE
    assert decode_challenge(challenge_header(CHALLENGE)) == CHALLENGE
    assert decode_challenge('Digest realm="r", nonce="n"') == Challenge("r", "n", qop="")


@pytest.mark.parametrize(
    "header",
    [
        None, "", 'Basic realm="r"', 'Digest realm="r"', 'Digest nonce="n", algorithm=SHA-256',
        'Digest nonce="n", qop="auth-int"', 'Digest nonce="\xe9"',
    ],
)  # fmt: skip
def test_another_way_in_is_refused(header):
    with pytest.raises(RwsProtocolError, match="Digest authentication"):
        decode_challenge(header)


@pytest.mark.parametrize("chunk", [1, 13, 4096])
def test_joints_of_a_controller_are_read_from_any_split_of_the_stream(chunk):
    reader = ResponseReader()

    response = one(reader, VECTORS["replies"]["jointtarget"].encode(), chunk)

    assert protocol.joint_angles_deg(response) == (-10.12346, 20.5, 0.0, 1.5e-5, 45.0, -123.4567)
    assert response.cookies == {"-http-session-": "8::http.session::d5ae", "ABBCX": "57"}
    assert not reader.inside_message


def test_a_refusal_is_read_with_its_sentence_and_one_without_by_its_status():
    response = one(ResponseReader(), VECTORS["replies"]["refusal"].encode())

    assert (response.status, protocol.error_sentence(response)) == (400, "Operation not allowed.")
    assert protocol.error_sentence(HttpResponse(500, (), b"<html>")) == "HTTP status 500"


def test_what_stands_behind_an_answer_is_seen():
    reader = ResponseReader()
    said = encode_response(HttpResponse(204))

    assert one(reader, said + said[:3]).status == 204
    assert reader.inside_message
    assert reader.next_message() is None


@pytest.mark.parametrize(
    "data",
    [
        b"4 1 10 20 30 40 50 60\r\n\r\n",
        b"\x00\xff" * 20 + b"\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: -1\r\n\r\n",
        b"HTTP/1.1 200 OK\r\nContent-Length: 3\r\nContent-Length: 4\r\n\r\nabcd",
        b"HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\nzz\r\n",
        b"HTTP/1.1 200 OK\r\nx: " + b"a" * 20_000,
        b"HTTP/1.1 200 OK\r\nContent-Length: 9000000\r\n\r\n" + b"a" * (LONGEST_BODY_BYTES + 1),
    ],
)
def test_what_is_no_http_or_has_no_end_is_refused(data):
    with pytest.raises(RwsProtocolError):
        one(ResponseReader(), data)


@given(st.binary(max_size=200), st.sampled_from([b"", b"HTTP/1.1 200 OK\r\n", b"HTTP/1.1 200 OK\r\n\r\n"]))
def test_any_bytes_are_an_answer_or_refused(data, before):
    response = assert_refused_at_worst(RwsProtocolError, one, ResponseReader(), before + data)
    if response is not None:
        assert_refused_at_worst(RwsProtocolError, protocol.joint_angles_deg, response)


@pytest.mark.parametrize(
    "document",
    [
        [], None, 7, {}, {"_embedded": []}, {"_embedded": {}}, {"_embedded": {"_state": {}}},
        {"_embedded": {"_state": []}}, {"_embedded": {"_state": ["x"]}},
        {"_embedded": {"_state": [{"_type": "pnl-opmode", "opmode": "AUTO"}]}},
        {"_embedded": {"_state": [{"_type": "ms-jointtarget", "rax_1": "1"}]}},
    ],
)  # fmt: skip
def test_json_without_joints_is_refused(document):
    with pytest.raises(RwsProtocolError):
        protocol.joint_angles_deg(json_response(document))


@pytest.mark.parametrize("body", [b"", b"{", b"[" * 100_000, b"\xff", b"NaN"])
def test_what_is_no_json_is_refused(body):
    with pytest.raises(RwsProtocolError):
        protocol.joint_angles_deg(HttpResponse(200, (), body))


@pytest.mark.parametrize("angle", ["nan", "inf", "1_0", "9E9", "3600.5", "", 10.0, None, "1e999", "9" * 400])
def test_an_angle_that_is_none_is_refused(angle):
    angles = {f"rax_{joint}": "0" for joint in range(1, 7)} | {"rax_4": angle}

    with pytest.raises(RwsProtocolError):
        protocol.joint_angles_deg(told(_type="ms-jointtarget", **angles))


def test_the_panel_is_read_in_the_controllers_words():
    assert protocol.controller_state(told(_type="pnl-ctrlstate", ctrlstate="guardstop")) == "guardstop"
    assert protocol.operation_mode(told(_type="pnl-opmode", opmode="MANR")) == "MANR"
    assert protocol.execution(told(_type="rap-execution", ctrlexecstate="running", cycle="once")) == "running"
    assert protocol.speed_percent(told(_type="pnl-speedratio", speedratio="50")) == 50.0


@pytest.mark.parametrize(
    ("read", "state"),
    [
        (protocol.controller_state, {"_type": "pnl-ctrlstate", "ctrlstate": "on"}),
        (protocol.controller_state, {"_type": "pnl-ctrlstate"}),
        (protocol.operation_mode, {"_type": "pnl-ctrlstate", "opmode": "AUTO"}),
        (protocol.speed_percent, {"_type": "pnl-speedratio", "speedratio": "101"}),
        (protocol.speed_percent, {"_type": "pnl-speedratio", "speedratio": "-1"}),
    ],
)
def test_a_state_that_nobody_knows_is_refused(read, state):
    with pytest.raises(RwsProtocolError):
        read(told(**state))


def test_only_motors_automatic_and_speed_together_let_the_arm_move():
    ready = protocol.Panel(
        protocol.ControllerState.MOTORS_ON, protocol.OperationMode.AUTO, protocol.Execution.STOPPED, 100.0
    )
    states = [
        protocol.Panel(state, mode, protocol.Execution.RUNNING, percent)
        for state in protocol.ControllerState
        for mode in protocol.OperationMode
        for percent in (0.0, 1.0, 100.0)
    ]

    assert ready.obstacle is None
    free = [now for now in states if now.obstacle is None]
    assert {(now.state, now.mode) for now in free} == {(ready.state, ready.mode)}
    assert all(now.speed_percent > 0.0 for now in free)


def test_the_newest_event_is_told_whatever_the_order():
    entries = [
        {"_title": f"/rw/elog/0/{number}", "code": str(number), "title": f"Event {number}", "desc": "x"}
        for number in (9, 10, 2)
    ]

    assert protocol.last_event(json_response({"_embedded": {"_state": entries}})) == "10 Event 10: x"
    assert protocol.last_event(json_response({"_embedded": {"_state": []}})) == ""


def test_a_report_of_a_number_beyond_those_of_rapid_is_refused():
    report = Report(Progress.ARRIVED, Order(number=7).values()).encode()

    with pytest.raises(RwsProtocolError, match="not a RAPID number"):
        decode_report(report.replace("7", "7" * 400))


def test_numbers_are_written_as_short_as_a_single_float_allows():
    assert array_text([1.0, -20.123456, 9e9, 1e-5, 0.1]) == "[1,-20.123455,9E+09,1E-05,0.1]"


@given(st.floats(width=32, allow_nan=False, allow_infinity=False, min_value=-1e6, max_value=1e6))
def test_a_single_float_survives_its_text(value):
    text = number_text(value)

    assert single(numbers(f"[{text}]", 1)[0]) == value


@pytest.mark.parametrize(
    "value", ["", "[]", "[1,2", "1,2]", "[1;2]", "[1,2,3]", "[1,nan]", "[1,]", None, 7, "[1,4E38]"]
)
def test_an_array_that_is_none_is_refused(value):
    with pytest.raises(RwsProtocolError):
        numbers(value, 2)


def test_an_order_and_its_report_survive_their_text():
    order = Order(17, (10.12345, -20.0, 0.0, 1e-4, 359.99999, -180.0), 250.0, 20.0)
    report = decode_report(Report(Progress.TAKEN, order.values()).encode())

    assert decode_order(order.encode()).values() == order.values()
    assert report.is_about(order)
    assert report.next_number == 18
    assert not report.is_about(Order(17, (10.12445, *order.target_deg[1:]), 250.0, 20.0))
    assert not report.is_about(Order(17, order.target_deg, 260.0, 20.0))


@pytest.mark.parametrize("value", ["[6,0,0,0,0,0,0,0,0,0]", "[0.5,0,0,0,0,0,0,0,0,0]", "[1,0,0]", "TRUE"])
def test_a_report_that_is_none_is_refused(value):
    with pytest.raises(RwsProtocolError):
        decode_report(value)


def test_a_request_goes_out_with_its_form_and_a_header_keeps_its_line():
    request = HttpRequest("POST", "/rw?action=set&json=1", {"cookie": "a=b"}, form_body({"value": "[1,2]"}))

    assert encode_request(request, "10.0.0.1:80") == (
        b"POST /rw?action=set&json=1 HTTP/1.1\r\nhost: 10.0.0.1:80\r\naccept-encoding: identity\r\n"
        b"cookie: a=b\r\ncontent-type: application/x-www-form-urlencoded\r\ncontent-length: 17\r\n\r\n"
        b"value=%5B1%2C2%5D"
    )
    with pytest.raises(ValueError, match="header"):
        encode_request(HttpRequest("GET", "/", {"cookie": "a\r\nhost: other"}), "memory")


def test_order_numbers_start_again_before_rapid_counts_wrong():
    assert Report(Progress.IDLE, (1_000_000.0, *Order().values()[1:])).next_number == 1
    assert math.isclose(Report(Progress.IDLE, Order().values()).next_number, 1)
