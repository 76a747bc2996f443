"""Motions of an arm: read from files, planned, pooled, or drawn as states."""
