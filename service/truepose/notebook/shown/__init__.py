"""How a notebook sees answers: as DataFrames, small tables and text."""
