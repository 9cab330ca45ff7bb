"""What is measured: sessions, the ledger of what happened in them, readings, series and events."""
