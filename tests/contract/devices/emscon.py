"""A model of an emScon server whose settings other programs change, with a reflector or a probe before it."""

import numpy as np

from truepose_drivers.contract.bench import PoseTrackerBench, TrackerBench, messages
from truepose_drivers.leica_emscon.driver import PLUGIN, LaserTracker
from truepose_drivers.leica_emscon.probe import PLUGIN as PLUGIN_6D
from truepose_drivers.leica_emscon.probe import ProbeTracker
from truepose_drivers.leica_emscon.protocol import (
    RESULTS,
    Answer,
    Command,
    FrameReader,
    PacketType,
    Record,
    Result,
    StatusChange,
    SystemStatusChange,
    decode_from_server,
    decode_request,
    encode,
    exchange,
)
from truepose_drivers.leica_emscon.protocol.settings import LengthUnit

MM_PER_INCH = 25.4
_SPECIALS = {
    "silent_units": "unit", "announced_units": "unit", "silent_frame": "unit", "silent_coordinates": "unit",
    "units_meanwhile": "unit", "stale_result": "stale", "repeated_result": "frozen", "try_mode": "foreign",
    "nan": "nonsense",
}  # fmt: skip


class _Server:
    """Answers as set; `result_type`, `coordinates` and `stated` are those of what it measures."""

    tolerance_mm = 1e-6

    def __init__(self):
        super().__init__()
        self.result = b""
        self.taken_result = b""  # the last one that the driver took
        self.kept = {}
        self.script = None

    def answer(self, data):
        reader, said = FrameReader(), []
        reader.receive_data(data)
        while (frame := reader.next_message()) is not None:
            said += self._answers(decode_request(frame))
        return said

    def decoded(self, data):
        return messages(FrameReader(), data, decode_from_server)

    def _answers(self, request):
        name = Command(request.command).name
        if name.startswith("SET_"):
            self.kept[f"GET_{name[4:]}"] = request.values
        if request.command == Command.START_MEASUREMENT:
            script, self.script = self.script, None
            return (script or self._measured)()
        values = exchange(request.command).answer.zeros() | self._told(request.command, name)
        return [encode(Answer(request.command, 0, Record(values)))]

    def _told(self, command, name):
        serial = {"tracker_processor_status": 5, "tracker_serial_number": int(self.serial)}
        return {
            Command.GET_SYSTEM_STATUS: serial,
            Command.GET_FACE: {"tracker_face": 1},
            Command.GET_REFLECTORS: {
                "total_reflectors": 1,
                "internal_reflector_id": 7,
                "reflector_name": "R",
            },
            Command.GET_PROBE: {"internal_probe_id": 2},
            Command.GET_PROBES: {"total_probes": 1, "internal_probe_id": 2, "name": "T-Mac"},
            Command.GET_CURRENT_PRISM_POSITION: self._place(("val1", "val2", "val3")),
        }.get(command, self.kept.get(name, {}))

    def _place(self, names):
        """Where the reflector is, in the units and the frame that somebody has set."""
        kept = {name: value for values in self.kept.values() for name, value in values.items()}
        true_mm = np.array(self.true_mm)
        shown = true_mm / (MM_PER_INCH if kept.get("len_unit_type") == LengthUnit.INCH else 1.0)
        shown = shown + (100.0 if kept.get("apply_transformation_params") else 0.0)
        if kept.get("coord_sys_type"):
            shown = np.array([0.3, 1.2, np.linalg.norm(shown)])
        return dict(zip(names, shown.tolist(), strict=True))

    def _result(self, **changes):
        members = RESULTS[self.result_type].zeros() | self.stated | self._place(self.coordinates) | changes
        return encode(Result(self.result_type, Record(members)))

    def _measured(self, **changes):
        self.result = self._result(**changes)
        return [encode(Answer(Command.START_MEASUREMENT, 0)), self.result]

    def special(self, name, wiring, rng):
        announce = encode(StatusChange(SystemStatusChange.UNITS_CHANGED))
        accepted = encode(Answer(Command.START_MEASUREMENT, 0))
        first, second, _ = self.coordinates
        match name:
            case "silent_units" | "announced_units":
                self.kept["GET_UNITS"] = Record(self.kept["GET_UNITS"], len_unit_type=LengthUnit.INCH)
                if name == "announced_units":
                    wiring.say(announce)
            case "silent_frame":
                self.kept["GET_SYSTEM_SETTINGS"] = Record(
                    self.kept["GET_SYSTEM_SETTINGS"], apply_transformation_params=True
                )
            case "silent_coordinates":
                self.kept["GET_COORDINATE_SYSTEM_TYPE"] = Record(coord_sys_type=7)
            case "units_meanwhile":
                wrong = {key: value / 1000.0 for key, value in self._place(self.coordinates).items()}
                self.script = lambda: [accepted, announce, self._result(**wrong), announce]
            case "stale_result":
                stale = self._result(**{first: 777.0})
                self.script = lambda: [stale, *self._measured()]
            case "repeated_result":
                again = self.taken_result
                self.script = lambda: [accepted, again] if again else self._measured()
            case "try_mode":
                self.script = lambda: self._measured(**{"is_try_mode": True, first: 1.0})
            case "negative_scatter":
                self.script = lambda: self._measured(**{"std1": -1.0, first: 1.0})
            case "no_unit":
                self.script = lambda: self._measured(**{"quaternion0": 0.7, first: 1.0})
            case "other_probe":
                self.script = lambda: self._measured(**{"internal_probe_id": 1, first: 1.0})
            case "not_vouched_for":
                self.script = lambda: self._measured(**{"rotation_status": 2, first: 1.0})
            case "nan":
                self.script = lambda: self._measured(**{second: float("nan")})

    async def ask(self, device):
        value = await super().ask(device)
        self.taken_result = self.result
        return value


class Tracker(_Server, TrackerBench):
    """With a reflector before it."""

    plugin = PLUGIN
    specials = {**_SPECIALS, "negative_scatter": "nonsense"}
    result_type = PacketType.SINGLE_MEAS_RESULT_2
    coordinates = ("val1", "val2", "val3")

    def driver(self, wiring):
        return LaserTracker(wiring.line(self.answer), wiring.clock)

    @property
    def true_mm(self):
        return self.point_mm

    @property
    def stated(self):
        return {"std_total": 1e-5 * self.point_mm[0], **{f"apriori_std{axis}": 0.01 for axis in (1, 2, 3)}}


class Probe(_Server, PoseTrackerBench):
    """With a probe before it."""

    plugin = PLUGIN_6D
    specials = {
        **_SPECIALS, "no_unit": "nonsense", "other_probe": "foreign", "not_vouched_for": "nonsense",
    }  # fmt: skip
    result_type = PacketType.STATIONARY_PROBE_MEAS_RESULT
    coordinates = ("position1", "position2", "position3")

    def driver(self, wiring):
        return ProbeTracker(wiring.line(self.answer), wiring.clock)

    @property
    def true_mm(self):
        return self.position_mm

    @property
    def stated(self):
        turned = {"quaternion0": 0.5, "quaternion1": -0.5, "quaternion2": 0.5, "quaternion3": 0.5}
        deviation = 1e-8 * (self.position_mm[0] + 1000.0)
        return {
            "meas_mode": 6,
            "rotation_status": 1,
            "internal_probe_id": 2,
            "std_dev_rotation_angle_total": deviation,
            **turned,
        }
