"""The true cell: arm, air, clock and journal, and what is planted in them."""
