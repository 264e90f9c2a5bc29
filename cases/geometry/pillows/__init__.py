"""Pillows: bags of one zipped biquadratic surface, flat, folded, rolled or crumpled."""
