"""Time: the clock of a scene, what each player plays when, and the schedule."""
