"""Figures as values, drawn as SVG for page and PDF, or as matplotlib axes."""
