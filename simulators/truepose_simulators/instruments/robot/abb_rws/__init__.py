"""An IRC5 as its web services show it: panel, programs and their variables, behind HTTP."""
