"""Files of a run folder; each recorder has the shape of `coupling.protocols.Recorder`."""
