"""The bench of every driver that is shipped: `--bench tests.contract.devices.every:BENCHES`."""

from tests.contract.devices.cameras import Camera
from tests.contract.devices.emscon import Probe, Tracker
from tests.contract.devices.fanuc import Fanuc
from tests.contract.devices.fanuc_rmi import FanucRmi
from tests.contract.devices.gauges import Bar, Bridge, Cable, Counter
from tests.contract.devices.json_bridge import PointBridge, PoseBridge
from tests.contract.devices.kuka import Kuka
from tests.contract.devices.line_gauges import KeyenceAmplifiers, MitutoyoCounter, MitutoyoLine
from tests.contract.devices.machines import ClockOfCell, Controller, HandsOfPerson
from tests.contract.devices.universal_robots import Universal
from tests.contract.devices.web_services import WebServices

BENCHES = [
    Tracker,
    Probe,
    PointBridge,
    PoseBridge,
    Controller,
    WebServices,
    Fanuc,
    FanucRmi,
    Universal,
    Kuka,
    Camera,
    Bar,
    Bridge,
    Counter,
    Cable,
    KeyenceAmplifiers,
    MitutoyoCounter,
    MitutoyoLine,
    ClockOfCell,
    HandsOfPerson,
]
