"""One library call per study: the main job, evaluation, comparison of two files."""
