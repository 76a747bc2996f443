"""Simplified models: their terms at every level, the searches, and the stated accuracy."""
