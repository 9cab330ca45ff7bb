"""A model of a camera that knows where its artefact is, and the driver on a hostile wire to it."""

import math
from dataclasses import replace

import numpy as np

from tests.studies.wires.hostile_link import HostileLink
from tests.studies.wires.machines import Machine
from truepose_drivers.errors import NotInitialisedError
from truepose_drivers.ndi_polaris.driver import PolarisTracker
from truepose_drivers.ndi_polaris.protocol import (
    OKAY,
    RESET,
    PortStatus,
    RequestReader,
    Text,
    ToolFrame,
    ToolPose,
    encode_binary,
    encode_handles,
    encode_reply,
    error_text,
)

_RATE_HZ = 60.0
_GOOD = PortStatus(0x31)
_TOLERANCE_MM = 1e-3  # single floats of two metres
_DURATION_S = 0.05


class Camera(Machine):
    """A Polaris that takes a frame whenever it is asked for one, and the clock that counts them."""

    kind = "pose_tracker"

    def __init__(self):
        self.frame = 0
        self.position_mm = np.array([0.0, 0.0, -2000.0])
        self.link = HostileLink(self.answer)
        self.driver = PolarisTracker(self.link, self, bytes(752))
        self.specials = (
            "old_frame",
            "other_tool",
            "missing",
            "outside",
            "no_unit",
            "nan",
            "reset",
            "refused",
        )

    async def now_s(self):
        return self.frame / _RATE_HZ

    async def prepare(self, device):
        await device.initialise()

    def move(self, rng):
        self.position_mm = rng.uniform((-500.0, -500.0, -2500.0), (500.0, 500.0, -1500.0))

    def answer(self, data):
        requests = RequestReader()
        requests.receive_data(data)
        name = requests.next_message().name
        if name == "BX":
            self.frame += 1
            return [encode_reply(encode_binary([self._seen()]))]
        said = {"PHSR": encode_handles([]), "PHRQ": Text("01")}.get(name, OKAY)
        return [encode_reply(said)]

    def special(self, name, rng):
        self.link.spoil = lambda _: [encode_reply(self._said(name))]

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
        x, y, z = map(float, self.position_mm)
        return ToolFrame(1, ToolPose((0.5, -0.5, 0.5, 0.5), (x, y, z), 0.1), _GOOD, self.frame)

    async def ask(self, device):
        try:
            reading = await device.measure_pose(duration_s=_DURATION_S)
        except NotInitialisedError:
            await device.initialise()
            reading = await device.measure_pose(duration_s=_DURATION_S)
        return np.array(reading.position_mm)

    def is_right(self, position_mm):
        return bool(np.allclose(position_mm, self.position_mm, rtol=0.0, atol=_TOLERANCE_MM))
