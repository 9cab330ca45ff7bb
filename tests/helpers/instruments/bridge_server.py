"""A ballbar bridge for tests: sends what a bar shows, a hundred times a second, while its cable is in."""

import asyncio

from truepose_drivers.ballbar_bridge.protocol import BridgeReading, Hello, encode
from truepose_simulators.instruments.endpoint import Endpoint


def bridge_endpoint(bar, clock) -> Endpoint:
    async def serve(reader, writer) -> None:
        writer.write(encode(Hello("QC20-W", "12A345", 0.0001)))
        while bar.plugged:
            sample = bar.sample(clock.now_s)
            reading = BridgeReading(sample.deviation_mm, sample.signal, sample.temperature_c, sample.sequence)
            writer.write(encode(reading))
            await writer.drain()
            await asyncio.sleep(0.01)

    return Endpoint("ballbar", "ballbar_bridge", serve)
