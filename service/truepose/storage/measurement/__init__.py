"""What is measured: sessions, their readings, and the ledger of the ballbar."""
