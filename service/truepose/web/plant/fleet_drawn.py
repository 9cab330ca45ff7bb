"""The content of a fleet's page, drawn in a worker process: the imports inside the function are the point."""

from dataclasses import dataclass
from typing import TYPE_CHECKING, Final

from truepose.analysis.fleets.desk import Collected
from truepose.storage.files.foreseen import to_bytes

if TYPE_CHECKING:
    from truepose.words.catalogue import Catalogue

LIMIT_MM: Final = 0.1  # of a change, where nobody asks for another


@dataclass(frozen=True, slots=True)
class FleetAsked:
    """What a page is drawn of."""

    robot: str  # the type
    campaigns: tuple[Collected, ...]
    limit_mm: float
    tag: str  # language and units
    computed_at: str


def drawn_fleet(asked: FleetAsked) -> bytes:
    """Return what the comparison foretells at the plant's limit, a line, and behind it the content.

    Raises ConfigurationError where the robots cannot be compared.
    """
    from datetime import date

    from truepose.analysis.fleets.compared import LeftOut, fleet_found
    from truepose.analysis.fleets.fit import Entry
    from truepose.analysis.fleets.foretold import foretold
    from truepose.analysis.fleets.told import told_from
    from truepose.exchange.tables.visits import Stated
    from truepose.reports.fleets.report import FleetInput, fleet_content
    from truepose.words.catalogue import catalogue

    entries, left_out = [], []
    for one in asked.campaigns:
        seen = one.seen
        name = f"{seen.cell} {seen.record_id} {seen.name}"
        if not one.told:
            left_out.append(LeftOut(name, one.why))
            continue
        day = date.fromisoformat(seen.measured_on)
        stated = Stated(seen.robot_serial_number, seen.instrument_serial_number, day)
        entries.append(Entry(name, stated, told_from(one.told)))
    found = fleet_found(entries, left_out, asked.robot)
    without = tuple((one.campaign, one.why) for one in found.left_out)
    given = FleetInput(found.account, asked.robot, asked.limit_mm, without, simulated=found.simulated)
    words = catalogue(asked.tag)
    computed = words.say("fleet.computed", moment=asked.computed_at)
    parts = (_simulated(words) if found.simulated else "", fleet_content(given, words), _muted(computed))
    newest = max(one.seen.id for one in asked.campaigns)
    told = foretold(found.account, asked.robot, newest, LIMIT_MM, asked.computed_at)
    return b"\n".join((to_bytes(told), "".join(parts).encode()))


def _simulated(words: "Catalogue") -> str:
    said = words.say("page.simulated"), words.say("page.simulated.meaning")
    return f'<p role="note"><strong>{said[0]}</strong> {said[1]}</p>'


def _muted(said: str) -> str:
    return f'<p class="muted">{said}</p>'
