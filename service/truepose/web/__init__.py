"""REST, events and pages; the only room that imports fastapi. Thin: parse, call, translate."""
