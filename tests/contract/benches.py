"""A bench for every registered driver: the simulated device it must get on with, in memory or on a socket."""

import asyncio
import tomllib
from collections.abc import Awaitable, Callable
from dataclasses import replace
from importlib.metadata import EntryPoint
from pathlib import Path

import numpy as np

from tests.helpers.ballbar.length_sources import FakeBar, FakeHands
from tests.helpers.instruments.bridge_server import bridge_endpoint
from tests.helpers.instruments.json_bridge_server import json_bridge_endpoint
from tests.helpers.instruments.memory_link import MemoryEnd, MemoryLink
from tests.helpers.instruments.usb_in_memory import UsbInMemory
from truepose_drivers.abb_open_abb.driver import OpenAbbRobot
from truepose_drivers.abb_rws.driver import RwsRobot
from truepose_drivers.api import Clock
from truepose_drivers.ballbar_bridge.driver import BridgedBallbar
from truepose_drivers.ballbar_hid.driver import HidBallbar
from truepose_drivers.cell_clock.driver import CellClock
from truepose_drivers.cell_hands.driver import CellHands
from truepose_drivers.fanuc_mappdk.driver import MappdkRobot
from truepose_drivers.fanuc_rmi.driver import RmiRobot
from truepose_drivers.fanuc_rmi.protocol import CONNECT_PORT
from truepose_drivers.heidenhain_nd.driver import HeidenhainCounter
from truepose_drivers.json_bridge.driver import BridgedTracker
from truepose_drivers.keyence_gt2.driver import KeyenceUnit
from truepose_drivers.kuka_variable_proxy.driver import KukaRobot
from truepose_drivers.leica_emscon.driver import LaserTracker
from truepose_drivers.leica_emscon.probe import ProbeTracker
from truepose_drivers.line_gauges.conversation import GaugeSettings, LineGauges
from truepose_drivers.mitutoyo_eh.driver import EhCounter
from truepose_drivers.mitutoyo_serial.driver import MitutoyoBox
from truepose_drivers.mitutoyo_usb_itn.driver import UsbItnGauge
from truepose_drivers.monotonic_clock import MonotonicClock
from truepose_drivers.ndi_polaris.driver import PolarisTracker
from truepose_drivers.registry import ENTRY_POINT_GROUP, DriverRegistry, load_registry
from truepose_drivers.transports.hid import HidOverUsb
from truepose_drivers.transports.link import Link
from truepose_drivers.transports.usb import UsbPort
from truepose_drivers.universal_robots.driver import Ports, UniversalRobot
from truepose_simulators.cell.environment import CellClock as SimulatedClock
from truepose_simulators.cell.true_cell import Cell
from truepose_simulators.instruments.accuracy import CameraSetup, ProbeSetup
from truepose_simulators.instruments.cell_endpoints import clock_endpoint, hands_endpoint
from truepose_simulators.instruments.endpoint import Endpoint
from truepose_simulators.instruments.gauges.ballbar_hid import HidBallbarGadget
from truepose_simulators.instruments.gauges.length_source import Electronics
from truepose_simulators.instruments.gauges.nd28x import nd28x_endpoint
from truepose_simulators.instruments.gauges.text_boxes import (
    keyence_gt2_endpoint,
    mitutoyo_eh_endpoint,
    mitutoyo_serial_endpoint,
)
from truepose_simulators.instruments.gauges.usb_itn import UsbItnGadget
from truepose_simulators.instruments.gauges.usbip import usbip_endpoint
from truepose_simulators.instruments.leica_emscon.server import tracker_endpoint
from truepose_simulators.instruments.ndi_polaris import camera_endpoint
from truepose_simulators.instruments.robot.abb_rws.controller import AbbController, OurProgram
from truepose_simulators.instruments.robot.abb_rws.server import web_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.controller import Controller as FanucController
from truepose_simulators.instruments.robot.fanuc_rmi.endpoints import connect_endpoint, session_endpoint
from truepose_simulators.instruments.robot.fanuc_rmi.program import RmiMove
from truepose_simulators.instruments.robot.kuka import Variables, proxy_endpoint
from truepose_simulators.instruments.robot.mappdk import MappdkProgram, mappdk_endpoint
from truepose_simulators.instruments.robot.open_abb import MotionProgram, robot_endpoint
from truepose_simulators.instruments.robot.universal_robots import Controller, Programs
from truepose_simulators.instruments.robot.universal_robots_ports import (
    dashboard_endpoint,
    rtde_endpoint,
    script_endpoint,
)
from truepose_simulators.instruments.tracker import in_tracker_frame
from truepose_simulators.scenarios.file import load_scenario

PYPROJECT = Path(__file__).parents[2] / "pyproject.toml"
ARTEFACT = PYPROJECT.parent / "tests" / "helpers" / "instruments" / "artefact.rom"
NEEDED = {  # options that a driver cannot do without here
    "ndi_polaris": {"tool_file": str(ARTEFACT)},
    **{name: {"range_mm": 1.0} for name in ("keyence_gt2", "mitutoyo_eh", "mitutoyo_serial")},
}


def gauges(link: Link, clock: Clock, dialect: object) -> LineGauges:
    return LineGauges(link, clock, dialect, GaugeSettings(range_mm=1.0), reply_timeout_s=0.5, settle_s=0.0)


LINKS: dict[str, Callable[[Callable[[], Link], Clock], object]] = {
    "leica_emscon": lambda new_link, clock: LaserTracker(new_link(), clock),
    "leica_emscon_6d": lambda new_link, clock: ProbeTracker(new_link(), clock),
    "json_bridge": lambda new_link, clock: BridgedTracker(new_link(), clock),
    "abb_open_abb": lambda new_link, clock: OpenAbbRobot(new_link(), clock),
    "abb_rws": lambda new_link, clock: RwsRobot(new_link(), clock),
    "fanuc_mappdk": lambda new_link, clock: MappdkRobot(new_link(), clock),
    "kuka_variable_proxy": lambda new_link, clock: KukaRobot(new_link(), clock),
    "ballbar_bridge": lambda new_link, clock: BridgedBallbar(new_link(), clock),
    "cell_clock": lambda new_link, clock: CellClock(new_link),
    "cell_hands": lambda new_link, clock: CellHands(new_link()),
    "keyence_gt2": lambda new_link, clock: gauges(new_link(), clock, KeyenceUnit()),
    "mitutoyo_eh": lambda new_link, clock: gauges(new_link(), clock, EhCounter()),
    "mitutoyo_serial": lambda new_link, clock: gauges(new_link(), clock, MitutoyoBox()),
    "heidenhain_nd": lambda new_link, clock: HeidenhainCounter(new_link(), clock, reply_timeout_s=1.5),
    "ndi_polaris": lambda new_link, clock: PolarisTracker(new_link(), clock, ARTEFACT.read_bytes()),
}
USB_PORTS: dict[str, Callable[[UsbPort, Clock], object]] = {
    "ballbar_hid": lambda port, clock: HidBallbar(HidOverUsb(port), clock),
    "mitutoyo_usb_itn": lambda port, clock: UsbItnGauge(port, clock),
}
WITHOUT_A_DEVICE = frozenset({"monotonic_clock"})


def registry() -> DriverRegistry:
    table = tomllib.loads(PYPROJECT.read_text())["project"]["entry-points"][ENTRY_POINT_GROUP]
    return load_registry(EntryPoint(name, value, ENTRY_POINT_GROUP) for name, value in table.items())


class _MemoryWriter:
    """What a simulated device needs of a stream writer, on a memory link."""

    def __init__(self, end: MemoryEnd) -> None:
        self._end = end
        self._closing = False

    def write(self, data: bytes) -> None:
        self._end.write(data)

    async def drain(self) -> None:
        await asyncio.sleep(0)

    def is_closing(self) -> bool:
        return self._closing

    def close(self) -> None:
        self._closing = True
        self._end.close()


def in_memory(endpoint: Endpoint, ends: list[MemoryEnd]) -> Callable[[MemoryEnd], Awaitable[None]]:
    """Serve an endpoint's clients from a memory link instead of a socket; lists them in `ends`."""

    async def feed(end: MemoryEnd, reader: asyncio.StreamReader) -> None:
        while data := await end.receive():
            reader.feed_data(data)
        reader.feed_eof()

    async def serve(end: MemoryEnd) -> None:
        ends.append(end)
        reader = asyncio.StreamReader()
        feeding = asyncio.create_task(feed(end, reader))
        try:
            await endpoint._serve(reader, _MemoryWriter(end))
        finally:
            feeding.cancel()

    return serve


def _irc5(cell: Cell) -> AbbController:
    controller = AbbController(cell)
    controller.task = OurProgram(controller)
    return controller


class Bench:
    """A simulated cell with its instruments, and drivers connected to them one way or the other."""

    def __init__(self, way: str) -> None:
        camera = CameraSetup(acceptance_deg=180.0)
        scenario = replace(load_scenario("irb120-clean"), camera=camera, probe=ProbeSetup())
        self.cell = Cell(scenario, 1, SimulatedClock(0))
        self.clock = MonotonicClock()
        self.bar = FakeBar()
        self.hands = FakeHands()
        bar = Electronics(self.bar, self.cell.faults, self.cell.clock)
        self.gadgets = {
            "ballbar_hid": HidBallbarGadget(bar),
            "mitutoyo_usb_itn": UsbItnGadget(bar),
        }
        self.endpoints = {
            **{name: usbip_endpoint(name, gadget) for name, gadget in self.gadgets.items()},
            "leica_emscon": tracker_endpoint(self.cell),
            "leica_emscon_6d": tracker_endpoint(self.cell),
            "json_bridge": json_bridge_endpoint(self.cell),
            "abb_open_abb": robot_endpoint(self.cell, MotionProgram(self.cell)),
            "abb_rws": web_endpoint(self.cell, _irc5(self.cell)),
            "fanuc_mappdk": mappdk_endpoint(self.cell, MappdkProgram(self.cell, "truepose")),
            "cell_clock": clock_endpoint(self.cell.clock),
            "ballbar_bridge": bridge_endpoint(self.bar, self.cell.clock),
            "cell_hands": hands_endpoint(self.hands),
            "heidenhain_nd": nd28x_endpoint(bar),
            "ndi_polaris": camera_endpoint(self.cell, camera),
            "keyence_gt2": keyence_gt2_endpoint([bar]),
            "mitutoyo_eh": mitutoyo_eh_endpoint([bar]),
            "mitutoyo_serial": mitutoyo_serial_endpoint([bar]),
        }
        controller = Controller(self.cell)
        programs = Programs(controller)
        self.endpoints |= {
            "universal_robots": rtde_endpoint(controller),
            "universal_robots script": script_endpoint(programs),
            "universal_robots dashboard": dashboard_endpoint(controller, programs),
        }
        fanuc = FanucController(self.cell)
        session = session_endpoint(fanuc, RmiMove(fanuc))
        self.endpoints |= {"fanuc_rmi": connect_endpoint(session), "fanuc_rmi session": session}
        self.endpoints["kuka_variable_proxy"] = proxy_endpoint(self.cell, Variables(self.cell, "truepose"))
        self._way = way
        self._ports: dict[str, int] = {}
        self._ends: list[MemoryEnd] = []
        self._usb_ports: list[UsbInMemory] = []
        self._opened: list[object] = []

    async def listen(self) -> None:
        if self._way == "socket":
            for name, endpoint in self.endpoints.items():
                self._ports[name] = (await endpoint.open("127.0.0.1", 0)).port

    async def close(self) -> None:
        for driver in self._opened:
            await driver.close()
        if self._way == "socket":
            for endpoint in self.endpoints.values():
                await endpoint.close()

    async def hang_up(self, name: str) -> None:
        """Let the device drop its connections, as one that is switched off and on again."""
        for end in self._ends:
            end.close()
        for port in self._usb_ports:
            port.hang_up()
        if self._way == "socket":
            for part in (part for part in self.endpoints if part.split()[0] == name):
                await self.endpoints[part].close()
                await self.endpoints[part].open("127.0.0.1", self._ports[part])

    def driver(self, name: str, use: str = ""):
        """Return a driver by its configuration name, on the device of this bench and not connected."""
        if self._way == "socket":
            further = NEEDED.get(name, {}) | self._further_ports(name)
            options = {"host": "127.0.0.1", "port": self._ports[name], **further}
            driver = registry().open(name, options, self.clock, use=use)
        elif name in USB_PORTS:
            port = UsbInMemory(self.gadgets[name])
            self._usb_ports.append(port)
            driver = USB_PORTS[name](port, self.clock)
        elif name == "universal_robots":
            ports = Ports(self._link(name), self._link(f"{name} script"), self._link(f"{name} dashboard"))
            driver = UniversalRobot(ports, self.clock)
        elif name == "fanuc_rmi":
            ports = {CONNECT_PORT: name}
            driver = RmiRobot(lambda port: self._link(ports.get(port, f"{name} session")), self.clock)
        else:
            driver = LINKS[name](lambda: self._link(name), self.clock)
        self._opened.append(driver)
        return driver

    def _link(self, name: str) -> MemoryLink:
        chunk_bytes = 7  # no packet of any protocol fits
        return MemoryLink(in_memory(self.endpoints[name], self._ends), chunk_bytes=chunk_bytes)

    def _further_ports(self, name: str) -> dict[str, int]:
        """Ports of a device that listens at several, as far as its driver has options for them."""
        named = {other.removeprefix(f"{name} ") + "_port": port for other, port in self._ports.items()}
        return {role: port for role, port in named.items() if role in registry().plugin(name).options}

    def fixed_nest_mm(self, number: int) -> tuple[float, float, float]:
        """Where a fixed nest is, in the tracker's frame; the simulator's knowledge."""
        x, y, z = in_tracker_frame(self.cell.tracker.frame, self.cell.fixed_nests_mm())[number - 1]
        return float(x), float(y), float(z)

    def spread_mm(self, point_mm: tuple[float, float, float]) -> float:
        """Largest standard deviation that the tracker's noise model states there."""
        covariance = self.cell.tracker.covariance_mm2(np.array(point_mm))
        return float(np.sqrt(np.linalg.eigvalsh(covariance)[-1]))
