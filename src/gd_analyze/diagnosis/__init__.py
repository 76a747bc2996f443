"""Why a log and an arm's file disagree: hypotheses with few numbers, ranked by what remains."""
