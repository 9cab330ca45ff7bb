"""Points that a tracker's own software exported, and how they find the configurations they were read at."""
