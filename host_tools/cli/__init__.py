"""The verbs of `passo`, one module each: they read options, call the other folders and print."""
