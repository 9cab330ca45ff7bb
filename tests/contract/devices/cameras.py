"""A model of a camera that knows where its artefact is, and the driver on a hostile wire to it."""

import math
from dataclasses import replace

from truepose_drivers.contract.bench import PoseTrackerBench, messages
from truepose_drivers.ndi_polaris.driver import PLUGIN, PolarisTracker
from truepose_drivers.ndi_polaris.protocol import (
    OKAY,
    RESET,
    Binary,
    PortStatus,
    ReplyReader,
    RequestReader,
    Text,
    ToolFrame,
    ToolPose,
    decode_binary,
    encode_binary,
    encode_handles,
    encode_reply,
    error_text,
)

_RATE_HZ = 60.0
_GOOD = PortStatus(0x31)


class Camera(PoseTrackerBench):
    """A Polaris that takes a frame whenever it is asked for one, and the clock that counts them."""

    plugin = PLUGIN
    specials = {
        "old_frame": "frozen", "other_tool": "foreign", "missing": "nonsense", "outside": "nonsense",
        "no_unit": "nonsense", "nan": "nonsense", "reset": "foreign", "refused": "nonsense",
    }  # fmt: skip
    absent = {"another_unit_changes_no_reading": "the API states millimetres, and nothing changes that"}

    def __init__(self):
        super().__init__()
        self.frame = 0

    def driver(self, wiring):
        return PolarisTracker(wiring.line(self.answer), self, bytes(64))

    async def now_s(self):
        return self.frame / _RATE_HZ

    def answer(self, data):
        requests = RequestReader()
        requests.receive_data(data)
        name = requests.next_message().name
        if name == "BX":
            self.frame += 1
            return [encode_reply(encode_binary([self._seen()]))]
        version = Text(f"Polaris Vega Control Firmware\nNDI S/N: {self.serial}\nFreeze Tag: Vega Rev 003")
        said = {"VER": version, "PHSR": encode_handles([]), "PHRQ": Text("01")}.get(name, OKAY)
        return [encode_reply(said)]

    def decoded(self, data):
        return messages(ReplyReader(), data, _read)

    def special(self, name, wiring, rng):
        wiring.spoil = lambda _: [encode_reply(self._said(name))]

    def _said(self, name):
        if name in ("reset", "refused"):
            return RESET if name == "reset" else error_text(0x0C)
        seen = self._seen()
        elsewhere = replace(seen.pose, position_mm=(0.0, 0.0, -1000.0))
        tool = {
            "old_frame": replace(seen, pose=elsewhere, frame=max(0, self.frame - 5)),
            "other_tool": replace(seen, pose=elsewhere, handle=2),
            "missing": replace(seen, pose=None),
            "outside": replace(seen, pose=elsewhere, status=_GOOD | PortStatus.OUT_OF_VOLUME),
            "no_unit": replace(seen, pose=replace(elsewhere, quaternion=(0.5, 0.5, 0.5, 0.4))),
            "nan": replace(seen, pose=replace(elsewhere, position_mm=(math.nan, 0.0, 0.0))),
        }[name]
        return encode_binary([tool])

    def _seen(self):
        return ToolFrame(1, ToolPose((0.5, -0.5, 0.5, 0.5), self.position_mm, 0.1), _GOOD, self.frame)


def _read(reply):
    return decode_binary(reply) if isinstance(reply, Binary) else reply
