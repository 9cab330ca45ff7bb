"""What stands at the edge of every printed page: of which robot, when, and which report this is."""

from dataclasses import dataclass

from truepose.reports.traceability.conditions import ReportConditions
from truepose.words.catalogue import Catalogue


@dataclass(frozen=True, slots=True)
class Imprint:
    """The four corners of a page; empty ones stay empty."""

    subject: str
    number: str = ""  # of the report, with its revision
    written_at: str = ""
    person: str = ""


def imprint_of(robot: str, conditions: ReportConditions, words: Catalogue) -> Imprint:
    """Return the imprint of a report on a robot."""
    serial = conditions.robot_serial_number
    subject = words.say("report.robot.serial", robot=robot, serial=serial) if serial else robot
    return Imprint(subject, conditions.number, conditions.written_at, conditions.person)


def css_string(text: str) -> str:
    """Return text of others as a string of a style sheet, which it cannot leave."""
    escaped = "".join(one if one.isalnum() or one == " " else f"\\{ord(one):x} " for one in text)
    return f'"{escaped}"'
