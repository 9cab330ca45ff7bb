"""Commands that plan, identify, judge, diagnose and correct."""
