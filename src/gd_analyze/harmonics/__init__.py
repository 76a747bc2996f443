"""The exact trigonometric-polynomial form of an arm's dynamics."""
