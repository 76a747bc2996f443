"""One file per formulation of the dynamics; array code only, and none imports another."""
