"""Texts as the service keeps them, for tests of how they are said in other languages."""

CLEAR = (
    "The robot is about to move. Is the cell clear of people and things, and is an emergency stop in reach?"
)
SCATTERS = "The reading scatters by 0.123 mm, limit 0.100 mm: the arm or the tracker is not at rest."
KEPT = (
    CLEAR,
    f"Stop was pressed. {CLEAR}",
    "A pause was asked for. Lunch, Bob says.",
    "The beam is broken. Nobody knows why.",
    "While measuring configuration 7: Fixed nest 2 was not found where it is expected: no answer",
    f"Configuration 12 could not be measured: {SCATTERS} It is number 3 in a row. Check the tracker and "
    "its line of sight, then resume.",
    "Gauge 2 is not touched: it shows -0.123 mm, and 4 mm either way of its zero are used.",
    "The database could not be written for a while (disk full); nothing is missing. " + CLEAR,
    "While measuring configuration 7: " * 24 + "no answer",  # each in the one before
)
