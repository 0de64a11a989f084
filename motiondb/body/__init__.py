"""Rotations, kinematics, the canonical body, and the conversion of captures to it and back.

Every function takes arrays and returns arrays: metres, seconds, radians unless a docstring says
degrees, quaternions w, x, y, z, world frame right-handed with y up.
"""
