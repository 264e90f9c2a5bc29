"""A kind of scene of the structure alone: static load paths with large rotations."""
