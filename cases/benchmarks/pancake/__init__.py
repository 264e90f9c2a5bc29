"""The main job: `suite.py` runs the coupled pancake and measures it, ``views.py`` shows it.

Other benchmarks and tests take the reduced mesh `suite.FAST` and `suite.simulate` from here.
"""
