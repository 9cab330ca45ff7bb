"""What controllers do with a target: by their makers' rules, which joints they take to it."""
