"""Results of a run: labelled tables, facts about them, and the results file."""
