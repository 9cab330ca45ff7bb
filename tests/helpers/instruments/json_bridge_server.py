"""An instrument bridge for tests: speaks for the simulated tracker of a cell and the probe on its flange."""

import numpy as np

from truepose_drivers.json_bridge.protocol import Answer, Failure, decode_question, encode_reply
from truepose_simulators.errors import BeamError
from truepose_simulators.faults.kinds import BeamBroken, TrackerCut
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.leica_emscon.probe import Probe
from truepose_simulators.physics.rigid import to_quaternion

WORDS = {"version": 1, "manufacturer": "FARO", "model": "Vantage", "firmware": "6.1"}


def json_bridge_endpoint(cell) -> Endpoint:
    bridge = Bridge(cell)

    async def serve(reader, writer) -> None:
        while line := await reader.readline():
            reply = encode_reply(await bridge.reply(decode_question(line)))
            if bridge.cut:
                bridge.cut = False
                writer.write(reply[: len(reply) // 2])
                return
            writer.write(reply)
            await writer.drain()

    return Endpoint("tracker", "json_bridge", serve)


class Bridge:
    def __init__(self, cell) -> None:
        self.cut = False
        self._cell = cell
        self._probe = Probe(cell, cell.scenario.probe)
        self._sequence = 0

    async def reply(self, question):
        try:
            values = await getattr(self, f"_{question.ask}")(question.details)
        except BeamError as error:
            failed = {"find_reflector": "reflector_not_found", "measure_pose": "artefact_not_seen"}
            kind = failed.get(question.ask, "beam_broken")
            return Failure(question.number, kind, f"{error}: clear the line of sight, then repeat")
        return Answer(question.number, "390001", values)

    async def _hello(self, details):
        return WORDS

    async def _initialise(self, details):
        self._cell.tracker.initialise()
        return {"settings": "The tracker measures an SMR of 0.5 in.", "sequence": self._sequence}

    async def _find_reflector(self, details):
        tracker, near_mm = self._cell.tracker, np.array(details["near_mm"])
        tracker.point(near_mm)
        tracker.search(np.arctan2(details["radius_mm"], np.linalg.norm(near_mm)))
        tracker.locked_target()
        return {}

    async def _measure_point(self, details):
        tracker = self._cell.tracker
        tracker.locked_target()
        fault = self._cell.faults.next_reading()
        self.cut = isinstance(fault, TrackerCut)
        if isinstance(fault, BeamBroken):
            tracker.release()
        await self._cell.clock.sleep(details["duration_s"])
        point = tracker.measure(details["duration_s"])
        stated = point.apriori_covariance_mm2
        return self._measured(
            point_mm=point.position_mm.tolist(),
            deviation_mm=np.sqrt(np.diag(point.covariance_mm2)).tolist(),
            covariance_mm2=[*np.diag(stated).tolist(), stated[0, 1], stated[0, 2], stated[1, 2]],
            samples=point.samples,
            face=tracker.face,
        )

    async def _measure_pose(self, details):
        await self._cell.clock.sleep(details["duration_s"])
        pose = self._probe.measure()
        return self._measured(
            position_mm=pose.position_mm.tolist(),
            quaternion=to_quaternion(pose.rotation).tolist(),
            deviation_mm=np.sqrt(np.diag(pose.covariance_mm2)).tolist(),
            rotation_deviation_rad=pose.rotation_rad,
        )

    async def _change_face(self, details):
        self._cell.tracker.face = 3 - self._cell.tracker.face
        return {}

    async def _environment(self, details):
        return {"temperature_c": 21.5, "pressure_hpa": 1001.0, "humidity_percent": 40.0}

    def _measured(self, **values):
        self._sequence += 1
        return {"unit": "mm", "sequence": self._sequence, **values}
