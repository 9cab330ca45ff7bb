"""What each driver and its simulated device say to each other while three readings are taken, in bytes."""

import asyncio

from tests.contract.devices.every import BENCHES
from tests.recorded.transcript import Transcript
from truepose_drivers.contract.case import SimulatedTimeLoop, Trial

_READINGS = 3
_SEED = 7


def listen():
    """Return the transcript of each driver."""
    return [_transcript(bench) for bench in BENCHES]


def _transcript(bench):
    taken = Transcript(f"wires/{bench.plugin.name}-{bench.__name__.lower()}")
    with asyncio.Runner(loop_factory=SimulatedTimeLoop) as runner:
        runner.run(_read(bench(), taken))
    return taken


async def _read(bench, taken):
    trial = Trial(bench, seed=_SEED)
    for _ in range(_READINGS):
        bench.move(trial.rng)
        value = await trial.ask()
        taken.add(*(f"> {_shown(data)}" for data in trial.wiring.sent))
        taken.add(*(f"< {_shown(data)}" for data in trial.wiring.said), f"= {value}", "")
        trial.wiring.sent.clear()
        trial.wiring.said.clear()
    if trial.connects:
        await trial.device.close()
    taken.add(*(f"> {_shown(data)}" for data in trial.wiring.sent))


def _shown(data):
    """Return bytes as text where they are text, else as hexadecimal pairs."""
    text = data.decode("ascii", "replace")
    return (
        repr(text)
        if text.isascii() and all(one.isprintable() or one in "\r\n\t" for one in text)
        else data.hex(" ")
    )
