"""The ball: who has it, where it is, and the hands and heads that follow it."""
