"""The languages of robot programs, one file or folder each."""
