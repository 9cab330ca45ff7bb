"""What is made of readings: campaigns, jobs, identifications, models, validations, diagnoses."""
