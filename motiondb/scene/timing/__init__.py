"""Time: the clock of a scene, the clips of each player over time, and the schedule."""
