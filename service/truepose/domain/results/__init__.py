"""What is answered: identifications, validations, diagnoses, corrected targets."""
