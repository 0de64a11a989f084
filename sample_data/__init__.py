"""The captures that motiondb makes itself, and the program that makes them."""
