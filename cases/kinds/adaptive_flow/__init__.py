"""The second kind of scene: steady channel flow whose model adapts to a goal [T ch. 7]."""
