"""Which records leave a cell, decided by table.

Of a record that stays at home only its link leaves: number, stream, table and hash. The hash is what the
next record of its stream rests on, so that the chain can be followed over it and all around it be verified.
"""

from typing import Final

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
