"""Models and exact dynamics as source text in other languages."""
