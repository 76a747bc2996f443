"""Figures as values, drawn once: SVG for page and paper, matplotlib axes on request."""
