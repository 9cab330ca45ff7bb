"""Figures of the report as SVG that takes its colours from the page, so that dark mode and print fit."""
