"""The physics of a vibrated cut: speeds, path, waveform, chips, demand.  Arrays and floats only."""
