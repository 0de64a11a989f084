"""What all quality tasks share: captures, folds, baselines, intervals, the report."""
