"""Motions of an arm: read from files of any kind, planned, pooled, or drawn as states."""
