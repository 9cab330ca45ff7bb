"""Which campaigns can be compared, and in a sentence why another cannot."""

from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from datetime import date

from truepose.analysis.fleets.told import Told
from truepose.exchange.tables.visits import Stated
from truepose.fleet.misfit.unlike import Unlike


@dataclass(frozen=True, slots=True)
class Entry:
    """A campaign as a fleet takes it."""

    campaign: str
    stated: Stated
    told: Told


def unfit_of(entries: Sequence[Entry]) -> Iterator[tuple[Entry, str]]:
    """Yield the campaigns of one type that cannot be compared, each with the sentence that says why."""
    usual = Counter(one.told.robot.joints for one in entries).most_common(1)
    before: dict[bytes, str] = {}
    for one in entries:
        readings = one.told.right.tobytes() + one.told.normal.tobytes()
        if why := _lacking(one.stated):
            yield one, why
        elif one.told.robot.joints != usual[0][0]:
            yield one, _OTHER_TABLE
        elif readings in before:
            yield one, f"It has the same readings as {before[readings]}: they count once."
        else:
            before[readings] = one.campaign


_OTHER_TABLE = (
    "Its nominal table of the robot is another than that of most campaigns of this type, and parameters "
    "count from that table: give it the table of the others, or a type of its own."
)


def said_unlike(one: Unlike) -> str:
    """Return in a sentence why a campaign is not compared with the others of its robot."""
    day = date.fromordinal(int(one.day)).isoformat()
    other = f"It fits {one.resembles}" if one.resembles else "It fits no other robot of the fleet"
    return (
        f"On {day} {one.robot} is unlike itself on its other days. {other}: look which robot, tool and nests "
        "were measured; if all are right, measure it again."
    )


def _lacking(stated: Stated) -> str:
    """Return in a sentence what nobody says of a campaign; empty: all is said."""
    known = {
        "robot_serial_number": stated.robot,
        "instrument_serial_number": stated.instrument,
        "measured_on": stated.day,
    }
    lacking = [name for name, value in known.items() if not value]
    if not lacking:
        return ""
    return f"Nobody says its {', '.join(lacking)}: write that into its campaign.json, or give a table."
