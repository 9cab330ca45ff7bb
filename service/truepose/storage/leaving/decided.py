"""Which records leave a cell, decided by table, and what is taken out of those that do.

Of a record that stays at home only its link leaves: number, stream, table and hash. The hash is what the
next record of its stream rests on, so that the chain can be followed over it and all around it be verified.
"""

import json
from collections.abc import Mapping
from typing import Any, Final

LEAVING: Final = frozenset({
    "sessions",
    "session_states",
    "readings",
    "skipped_stops",
    "registrations",
    "notes",
    "added_stops",
    "closings",
    "session_entries",
    "campaigns",
    "jobs",
    "job_states",
    "identifications",
    "diagnoses",
    "models",
    "validations",
    "corrections",
    "events",
    "reports",
    "series",
    "deliveries",
    "handed_down",
    "hand_down_uses",
})
# People and what opens the service to them, what they did and from where, and the keys of their requests.
AT_HOME: Final = frozenset({
    "people",
    "person_states",
    "credentials",
    "revocations",
    "acts",
    "request_keys",
    "ballbar_answers",
    "links",
    # What a plant has of its cells leaves it for nobody.
    "plant_cells",
    "plant_branches",
    "plant_visits",
    "plant_journal",
    "plant_sessions",
    "plant_days",
    "plant_results",
    "plant_told",
    "plant_certificates",
    "plant_robots",
    "plant_instruments",
    "plant_hand_downs",
    "plant_hand_down_states",
})
_SET_UP: Final = "setup"  # of a session: the cell with the options of its devices
_SECRET: Final = frozenset({"password", "passphrase", "pin", "secret", "token"})  # options of devices
_TAKEN_OUT: Final = "taken out"


def without_secrets(row: Mapping[str, Any]) -> Mapping[str, Any]:
    """Return a record as it may leave: itself, or with what opens a device taken out of its set-up.

    The latter has no longer the hash of its link: it can be read, and not verified.
    """
    if not isinstance(row.get(_SET_UP), str):
        return row
    set_up = json.loads(row[_SET_UP])
    told = _told(set_up)
    return row if told == set_up else {**row, _SET_UP: json.dumps(told)}


def _told(document: Any) -> Any:
    match document:
        case dict():
            return {key: _TAKEN_OUT if key in _SECRET else _told(value) for key, value in document.items()}
        case list():
            return [_told(value) for value in document]
        case _:
            return document
