"""What surrounds a desk: a real database, fake devices, and the runners that were made."""

from tests.integration.web.bench import Bench
from truepose.domain.cell import DeviceEntry
from truepose.sessions.devices import DeviceRegistry, MountedDevice
from truepose.storage.ledger.entries import LedgerRepository
from truepose.storage.ledger.sessions import SessionRepository


class Surroundings:
    """Of sessions that measure with one instrument: the tracker or the ballbar."""

    def __init__(self, database, instrument):
        bench = Bench()
        devices = [(instrument, getattr(bench, instrument)), ("robot", bench.robot)]
        self.rack = DeviceRegistry(
            [MountedDevice(DeviceEntry(kind, "fake", {}), kind, "fake", it) for kind, it in devices],
            bench.clock,
        )
        self.sessions = SessionRepository(database)
        self.ledger = LedgerRepository(database)
        self.runners = []
