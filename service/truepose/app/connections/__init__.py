"""Connections: how many there may be, how slow they may be, and who goes first when there are too many."""
