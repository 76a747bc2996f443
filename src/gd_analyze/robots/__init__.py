"""Robot arms: the value, the ways to build one, and the built-in ones."""
