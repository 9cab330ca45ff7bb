"""The import wizard: files of any program, with columns detected and shown before anything is made."""
