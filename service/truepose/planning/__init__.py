"""Which configurations to measure: candidates, feasibility, observability, choice by exchange. Pure."""
