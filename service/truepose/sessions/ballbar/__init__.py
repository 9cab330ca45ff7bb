"""The ballbar session: a person connects the ballbar leg by leg, the robot moves only where one lets it."""
