"""The experiments of the five documents, repeated beside their authors' figures: `passo experiments`. Each module is one experiment."""
