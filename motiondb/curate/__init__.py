"""Which part of a library to train on, what a library holds, and what it lacks."""
