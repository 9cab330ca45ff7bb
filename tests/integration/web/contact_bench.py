"""Closed loops over REST: a wire, as a cell file has it and as a session asks for it."""

GAUGE = '[[device]]\nname = "wire"\ndriver = "fake_gauge"\nserial_number = "W-1"\n'
WIRE = {
    "kind": "contact",
    "name": "one wire",
    "targets": [{"kind": "wire", "place_mm": [600, -400, 0], "zero_mm": 600, "zero_is_certified": False}],
    "nest": 2,
    "stops": 6,
    "stroke_mm": 400,
    "margin_mm": 20,
    "reading_u_mm": 0.02,
}
