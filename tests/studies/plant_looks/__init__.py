"""How soon a plant is there and answers, with 1,000 robots and a million readings in its journal."""
