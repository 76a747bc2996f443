"""Motions: plans and logs read, smoothed, planned, drawn; the states that models are held against."""
