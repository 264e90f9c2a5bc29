"""Flat bags: the plane of a pattern, coincident sheets told apart, their chords split, drawn in."""
