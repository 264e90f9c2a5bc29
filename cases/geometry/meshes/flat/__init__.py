"""Flat bags: the plane of a pattern, and two sheets that lie on each other told apart."""
