"""Model of an ABB controller's web services on a hostile wire."""

from tests.contract.devices.watched_robot import ABSENT, IRB_120_RANGES_DEG
from truepose_drivers.abb_rws import protocol
from truepose_drivers.abb_rws.driver import PLUGIN, RwsRobot
from truepose_drivers.abb_rws.http import (
    Challenge,
    HttpResponse,
    RequestReader,
    ResponseReader,
    challenge_header,
    encode_response,
)
from truepose_drivers.abb_rws.protocol import number_text
from truepose_drivers.contract.bench import RobotBench, messages
from truepose_drivers.contract.wire import HangUp

_CHALLENGE = ("www-authenticate", challenge_header(Challenge("validusers@robapi.abb", "6f6e6365")))
_OTHERS = {
    protocol.CONTROLLER_STATE: {"_type": "pnl-ctrlstate", "ctrlstate": "motoron"},
    protocol.ROBOT_TYPE: {"_type": "sys-robottype", "robot-type": "IRB 120-3/0.6"},
    protocol.SYSTEM: {"_type": "sys-system-li", "rwversion": "6.08.01.00"},
}


class WebServices(RobotBench):
    """An IRC5 that asks every new client for its password, once."""

    plugin = PLUGIN
    ranges_deg = IRB_120_RANGES_DEG
    decimals = 4
    free_numbers = True
    tolerance_deg = 1e-4
    specials = {
        "other_resource": "foreign", "page": "nonsense", "nan": "nonsense", "huge_angle": "nonsense",
        "five_joints": "nonsense", "no_states": "nonsense", "no_json": "nonsense",
    }  # fmt: skip
    absent = {
        **ABSENT,
        "a_frozen_device_gives_no_reading": "a state has neither number nor time",
    }

    def driver(self, wiring):
        return RwsRobot(wiring.line(self.answer), wiring.clock)

    def answer(self, data):
        reader, said = RequestReader(), []
        reader.receive_data(data)
        while (request := reader.next_message()) is not None:
            said.append(encode_response(self._response(request)))
        return said or [HangUp()]

    def _response(self, request):
        if "authorization" not in request.headers:
            return HttpResponse(401, (_CHALLENGE,))
        told = {
            **_OTHERS,
            protocol.IDENTITY: {"_type": "ctrl-identity-info", "ctrl-id": self.serial},
            protocol.JOINT_TARGET: self._joints(),
        }
        state = told.get(request.path)
        return HttpResponse(404) if state is None else _json(protocol.encode_states(request.path, [state]))

    def _joints(self):
        angles = enumerate(self.joints_deg, start=1)
        return {"_type": "ms-jointtarget", **{f"rax_{joint}": number_text(angle) for joint, angle in angles}}

    def decoded(self, data):
        return messages(ResponseReader(), data)

    def special(self, name, wiring, rng):
        joints = self._joints()
        bad = {
            "other_resource": _state(_OTHERS[protocol.CONTROLLER_STATE]),
            "page": HttpResponse(200, (("content-type", "text/html"),), b"<html>Please log in</html>"),
            "nan": _state(joints | {"rax_2": "nan"}),
            "huge_angle": _state(joints | {"rax_2": "90000"}),
            "five_joints": _state({key: value for key, value in joints.items() if key != "rax_6"}),
            "no_states": _json(b'{"_embedded": {}}'),
            "no_json": _json(b'{"_embedded": {"_state": [{"_type": "ms-join'),
        }[name]
        wiring.spoil = lambda _: [encode_response(bad)]


def _state(state):
    return _json(protocol.encode_states(protocol.JOINT_TARGET, [state]))


def _json(body):
    return HttpResponse(200, (("content-type", "application/json"),), body)
