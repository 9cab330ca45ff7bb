"""Plans for the ballbar: where its base fixture stands, which poses are measured, how the arm gets there."""
