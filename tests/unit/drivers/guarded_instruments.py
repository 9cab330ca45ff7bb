"""Devices behind a guard that answer, or raise, what a test says; and every call of each kind."""

from truepose_drivers.api import BallbarReading, MotionGuard, MotionLimits

LENGTH = BallbarReading(0.1234, "good", 1e-4, 10.0, 21.0, 7)


class Instrument:
    """A device of any kind; what it is asked for comes from `says`, or is raised."""

    can_stop_motion = False

    def __init__(self, *says: object) -> None:
        self.says = list(says)
        self.connected = True

    async def _answer(self, *asked: object, **more: object):
        said = self.says.pop(0) if len(self.says) > 1 else self.says[0]
        if isinstance(said, BaseException):
            raise said
        return said

    connect = identify = initialise = find_reflector = measure_point = change_face = environment = _answer
    measure_pose = _answer
    set_limits = move_joints = read_joints = read = do = now_s = sleep = _answer

    async def close(self) -> None:
        self.connected = False


class Box(Instrument):
    """Several gauges that answer at once."""

    async def read_channels(self):
        return await self._answer()


class Able(Instrument):
    """Offers everything that a driver may offer."""

    motion_guard = MotionGuard(longest_piece_s=0.8, speed_share=0.5)
    settings = "It measures an SMR."

    async def reflector_now(self):
        return await self._answer()


CALLS = {
    "tracker": [
        ("connect", (), {}),
        ("identify", (), {}),
        ("initialise", (), {}),
        ("find_reflector", ((1.0, 0.0, 0.0),), {"search_radius_mm": 5.0}),
        ("measure_point", (), {"duration_s": 1.0}),
        ("change_face", (), {}),
        ("environment", (), {}),
        ("reflector_now", (), {}),
    ],
    "pose_tracker": [
        ("connect", (), {}),
        ("identify", (), {}),
        ("initialise", (), {}),
        ("measure_pose", (), {"duration_s": 1.0}),
    ],
    "robot": [("set_limits", (MotionLimits(),), {}), ("move_joints", ((0.0,),), {}), ("read_joints", (), {})],
    "ballbar": [("read", (), {})],
    "linear_gauge": [("read_channels", (), {})],
    "hands": [("do", ("detach", {}), {})],
    "clock": [("now_s", (), {}), ("sleep", (1.0,), {})],
}
