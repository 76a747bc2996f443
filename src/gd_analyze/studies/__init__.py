"""One library call per study: the main job, comparison, evaluation."""
