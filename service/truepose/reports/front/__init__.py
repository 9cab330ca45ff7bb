"""The first page of a report: pass or not, one figure, one picture, one sentence, who and when."""
