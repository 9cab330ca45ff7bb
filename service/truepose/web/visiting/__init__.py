"""What every page for people rests on: who visits, in which language and look, and the templates."""
