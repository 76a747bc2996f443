"""The five steps of the main job, a file each: read, decompose, rank, simplify, collect."""
