"""The accuracy that a plan predicts before anything is measured."""
