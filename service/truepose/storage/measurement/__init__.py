"""What is measured: sessions, the ledger of what happened in them, and the readings of a tracker."""
