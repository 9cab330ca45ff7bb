"""The gauges of a session: all channels of all boxes as one row of readings."""

from typing import Final

import numpy as np

from truepose.domain.measurement.contacts import ContactPlan
from truepose.sequencing.contacts.cell import GaugeBox
from truepose.sequencing.engine.identity.expected import same_number, told
from truepose.sequencing.errors import AttentionNeededError, ReadingRejectedError
from truepose_drivers.api import BallbarReading, Clock

_BETWEEN_S: Final = 0.1  # of two samples
_UNSTEADY: Final = 5.0  # standard uncertainties of a reading by which samples may scatter


class Gauges:
    """Reads them; each reading is of one channel, in the order of the cell file."""

    def __init__(self, boxes: tuple[GaugeBox, ...], clock: Clock, plan: ContactPlan) -> None:
        self._boxes = boxes
        self._clock = clock
        self._plan = plan

    async def open(self) -> tuple[str, ...]:
        """Connect them and say which answered; raises AttentionNeededError, and the driver's errors."""
        found = []
        for box in self._boxes:
            if not box.gauge.connected:
                await box.gauge.connect()
            identity = await box.gauge.identify()
            serial = told(identity.serial)
            if serial and box.serial and not same_number(serial, box.serial):
                raise AttentionNeededError(
                    f"Another {box.name} answers: serial number {serial} instead of {box.serial}. Connect "
                    f"{box.serial} again; or put {serial} into the cell file and plan a session with it."
                )
            model = f"{identity.manufacturer} {identity.model}"
            found.append(f"The {box.name} is {model}, serial {identity.serial}.")
        await self._require_channels()
        return tuple(found)

    async def close(self) -> None:
        """Close their links; never raises."""
        for box in self._boxes:
            await box.gauge.close()

    async def look(self) -> tuple[BallbarReading, ...]:
        """Return what each of them shows now; raises the driver's errors."""
        readings: list[BallbarReading] = []
        for box in self._boxes:
            readings += await box.gauge.read_channels()
        return tuple(readings)

    async def furthest_in_mm(self) -> float:
        """Return how far the one is pushed in that is furthest; one that is out of its range counts fully."""
        return max(self._pushed_mm(reading) for reading in await self.look())

    async def read(self) -> tuple[float, ...]:
        """Return the mean of some samples of each; raises ReadingRejectedError, and the driver's errors."""
        samples = []
        for number in range(self._plan.samples):
            if number:
                await self._clock.sleep(_BETWEEN_S)
            samples.append([self._within_mm(n, one) for n, one in enumerate(await self.look(), start=1)])
        scatter_mm = float(np.ptp(samples, axis=0).max())
        finest_mm = self._plan.reading_u_mm
        if scatter_mm > _UNSTEADY * finest_mm:
            raise ReadingRejectedError(
                f"The samples of a gauge differ by {1000.0 * scatter_mm:.1f} um, which a reading of "
                f"{1000.0 * finest_mm:.1f} um does not: see that nothing shakes or slides."
            )
        return tuple(float(mean) for mean in np.mean(samples, axis=0))

    def _pushed_mm(self, reading: BallbarReading) -> float:
        if reading.signal == "none":
            raise ReadingRejectedError("A gauge has no signal: check its cable and its power.")
        return reading.deviation_mm

    def _within_mm(self, number: int, reading: BallbarReading) -> float:
        usable_mm = self._plan.stroke_mm - self._plan.margin_mm
        shown_mm = self._pushed_mm(reading)
        if reading.signal != "good" or abs(shown_mm) > usable_mm:
            what = "is not touched" if shown_mm < 0.0 else "is pushed in too far"
            raise ReadingRejectedError(
                f"Gauge {number} {what}: it shows {shown_mm:+.3f} mm, and {usable_mm:g} mm either way of its "
                "zero are used."
            )
        return shown_mm

    async def _require_channels(self) -> None:
        there = len(await self.look())
        if there != self._plan.channels:
            raise AttentionNeededError(
                f"The cell has {there} gauges, and the session reads {self._plan.channels}: check the "
                "[[device]] entries, and their channels."
            )
