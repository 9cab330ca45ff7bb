"""How campaigns differ from what the model of a fleet puts there: all by a little, or one in everything."""
