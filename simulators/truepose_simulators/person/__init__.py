"""The person at the simulated cell: two hands, what they hold, and where they put the base fixture down."""
