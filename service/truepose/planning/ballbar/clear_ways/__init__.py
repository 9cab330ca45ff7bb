"""Which ways of the arm around the ballbar are clear: computed from capsules; nothing moves here."""
