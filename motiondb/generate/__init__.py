"""Generation: hidden Markov models in series, trajectories, stitched clips, foot contacts."""
